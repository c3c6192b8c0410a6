// Stages one by one. A stage's error is judged against what its inputs' own rounding does to the reference:
// the reference is run again with its inputs moved by a few units in the last place of single precision.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "base/components.hpp"
#include "check/check.hpp"
#include "check/item_class.hpp"
#include "reference/lights.hpp"
#include "scene/placement.hpp"

namespace regulus::check {

using glm::dvec2;
using glm::dvec3;
using glm::dvec4;
using namespace interface;
using render::Pass;
using render::RecordedBounce;
using render::Recording;

namespace {

constexpr double STEP_BOUND = 1e-4;  // directions, throughputs, relative
// Factors of a step below this are nothing: what a black metal reflects, (1 - cos)^5, has a relative error of
// some 20 roundings over 1 - cos, there more than STEP_BOUND.
constexpr double LEAST_FACTOR = 1e-9;
// t, relative to its conditioning: 8 units in the last place.
constexpr double DISTANCE_BOUND = 8 * 0x1p-23;
constexpr double TIE_DISTANCE = 1e-5;  // relative to the distance plus the size of coordinates
constexpr double ULP = 6e-8;
constexpr int JITTERS = 8;
// Thresholds that random numbers are compared with: errors of Fresnel terms and luminances.
constexpr double CHOICE_TOLERANCE = 1e-5;

/// +1 or -1, a different pattern for every jitter and input.
double sign_of(int jitter, int input) {
  const uint32_t hash =
      (static_cast<uint32_t>(jitter) * 73856093u) ^ (static_cast<uint32_t>(input + 1) * 2654435761u);
  return ((hash >> 13) & 1u) != 0 ? 1.0 : -1.0;
}

dvec3 moved(const dvec3& v, double amount, int jitter) {
  return v + amount * dvec3(sign_of(jitter, 0), sign_of(jitter, 1), sign_of(jitter, 2));
}

std::string text_of(const dvec3& v) {
  return fmt::format("({:.6g} {:.6g} {:.6g})", v.x, v.y, v.z);
}

reference::Ray ray_of(const Path& path) {
  reference::Ray ray{dvec3(path.origin), normalize(dvec3(path.direction))};
  ray.decision = {path.origin, path.direction};
  return ray;
}

/// Where a ray starts; without FEATURE_CONTACTS nothing is recorded, and nothing matters.
reference::Place place_of(const std::vector<PathMedia>& media, size_t index) {
  if (media.empty()) return {};
  return {reference::Media(media[index].around), media[index].triangle, dvec2(media[index].barycentrics)};
}

class StageChecker {
 public:
  StageChecker(const Subject& subject, Pass pass) : subject_(subject), is_camera_(pass == Pass::Camera) {}

  Tally generate(const Recording& recording) const {
    Tally tally(is_camera_ ? "camera_generate" : "light_generate", STEP_BOUND);
    // A light path that starts where its light is dark is not traced, and its slot holds what was there
    // before.
    const std::vector<uint32_t>& slots = recording.bounces.front().slots;
    const std::set<uint32_t> traced(slots.begin(), slots.end());
    for (uint32_t slot = 0; slot < recording.generated.size(); ++slot) {
      const Path& path = recording.generated[slot];
      if (!is_camera_ && !traced.contains(slot)) continue;
      is_camera_ ? compare_camera_ray(path, tally) : compare_emission(path, tally);
    }
    return tally;
  }

  void trace(const RecordedBounce& bounce, Tally& tally) const {
    for (const uint32_t slot : bounce.slots) {
      const Hit& hit = bounce.hits[slot];
      reference::Ray ray = ray_of(bounce.before[slot]);
      if (is_camera_ && bounce.before[slot].bounce == 0) {
        const reference::CameraRay clipped = subject_.camera.clipped(ray.origin, ray.direction);
        ray.t_min = clipped.nearest;
        ray.t_max = clipped.farthest;
      }
      const reference::Place place = place_of(bounce.media_before, slot);
      const auto expected = closest(ray, place);
      const double scale = largest_magnitude(ray.origin) + (expected ? expected->t : subject_.world.radius());
      if (expected && hit.triangle == expected->triangle) {
        if (!tally.add_error(std::abs(hit.t - expected->t) / distance_conditioning(ray, *expected)))
          tally.describe(fmt::format("slot {}: t {} against {}", slot, hit.t, expected->t));
      } else if (!expected && hit.triangle == INVALID_INDEX) {
        tally.add_error(0);
      } else {
        tally.add_difference(difference_of(ray, place, hit, expected, scale));
        if (difference_of(ray, place, hit, expected, scale) == Difference::Real)
          tally.describe(fmt::format("slot {}: triangle {} at {} against {} at {}; origin {} direction {}",
                                     slot, hit.triangle, hit.t, expected ? expected->triangle : INVALID_INDEX,
                                     expected ? expected->t : -1, text_of(ray.origin),
                                     text_of(ray.direction)));
      }
    }
  }

  void bounce(const RecordedBounce& bounce, uint32_t index, Tally& tally) const {
    const std::set<uint32_t> continuing(bounce.continuing.begin(), bounce.continuing.end());
    for (const uint32_t slot : bounce.slots) {
      const Hit& hit = bounce.hits[slot];
      if (hit.triangle == INVALID_INDEX) continue;
      const bool is_alive = continuing.contains(slot);
      const reference::Place place = place_of(bounce.media_on_arrival, slot);
      compare_step(bounce.before[slot], place, hit, index, is_alive, bounce.after[slot], slot, tally);
    }
  }

  void visibility(const RecordedBounce& bounce, Tally& tally) const {
    for (size_t i = 0; i < bounce.candidates.size(); ++i) {
      const VisibilityCandidate& candidate = bounce.candidates[i];
      const dvec3 added = dvec3(bounce.radiance[candidate.receiver]) -
                          dvec3(bounce.radiance_before_visibility[candidate.receiver]);
      const double wanted = largest_magnitude(dvec3(candidate.contribution));
      if (wanted < 1e-5 * largest_magnitude(dvec3(bounce.radiance[candidate.receiver])))
        continue;  // lost in the sum either way
      compare_segment(candidate, place_of(bounce.candidate_media, i), largest_magnitude(added) > 0.5 * wanted,
                      tally);
    }
    for (const render::Probe& probe : bounce.probes)
      compare_segment(probe.segment, place_of(bounce.media_before, probe.segment.receiver), probe.is_open,
                      tally);
  }

 private:
  /// Where a step leads.
  struct Step {
    dvec3 position, direction, throughput;
    uint32_t medium = INVALID_INDEX;
  };

  std::optional<reference::Intersection> closest(const reference::Ray& ray, reference::Place place) const {
    return subject_.world.meet(ray, place);
  }
  bool is_occluded(const reference::Ray& ray, const reference::Place& place) const {
    return subject_.world.has_contacts() ? closest(ray, place).has_value()
                                         : subject_.world.traversal().is_occluded(ray);
  }

  void compare_segment(const VisibilityCandidate& candidate, const reference::Place& place, bool is_open,
                       Tally& tally) const {
    reference::Ray ray{dvec3(candidate.origin), normalize(dvec3(candidate.direction))};
    ray.decision = {candidate.origin, candidate.direction};
    if (candidate.t_max < 1e38F) ray.t_max = candidate.t_max;
    if (is_open != is_occluded(ray, place)) {
      tally.add_error(0);
      return;
    }
    // A light at the segment's end must not cast a shadow on itself, unless the 16 roundings of its length by
    // which the segment is short are less than one of its coordinates.
    const bool is_short = 16 * ray.t_max < largest_magnitude(ray.origin);
    bool can_agree = (is_open || is_short) && ends_at_a_surface(ray, place);
    for (int k = 0; k < JITTERS && !can_agree; ++k) {
      reference::Ray other = ray;
      other.origin = moved(ray.origin, 4 * ULP * largest_magnitude(ray.origin), k);
      other.direction = normalize(moved(ray.direction, 4 * ULP, k + 7));
      other.t_max = ray.t_max * (1 + 16 * ULP * sign_of(k, 5));
      can_agree = is_open != is_occluded(other, place);
    }
    tally.add_difference(can_agree ? Difference::Edge : Difference::Real);
    if (!can_agree)
      tally.describe(fmt::format("slot {}: {} on the device; origin {} direction {} t_max {}",
                                 candidate.receiver, is_open ? "open" : "occluded", text_of(ray.origin),
                                 text_of(ray.direction), ray.t_max));
  }

  /// True if the segment ends at something within what the distance of a hit may err by.
  bool ends_at_a_surface(const reference::Ray& segment, const reference::Place& place) const {
    reference::Ray endless{segment.origin, segment.direction};
    endless.decision = segment.decision;
    const auto first = closest(endless, place);
    return first &&
           std::abs(first->t - segment.t_max) <= DISTANCE_BOUND * distance_conditioning(segment, *first);
  }

  /// What one relative rounding does to t: of the plane (origin and coordinates), seen at the ray's cosine,
  /// and of the triangle's edge functions, which err by E^2 each, with E the distance to the farthest vertex,
  /// and are divided by twice the area (see the triangle test).
  double distance_conditioning(const reference::Ray& ray, const reference::Intersection& hit) const {
    const reference::Surface surface = subject_.world.surface_at(hit.triangle, hit.barycentrics);
    double extent = 0;
    for (const glm::vec3& vertex : placed_positions(subject_.prepared.scene, hit.triangle))
      extent = std::max(extent, length(dvec3(vertex) - surface.position));
    const double shape = extent * extent / (2 * surface.area);
    const double cosine = std::abs(dot(surface.geometric_normal, ray.direction));
    return (largest_magnitude(ray.origin) + hit.t + extent * shape) / std::max(cosine, 1e-6);
  }

  Difference difference_of(const reference::Ray& ray, const reference::Place& place, const Hit& hit,
                           const std::optional<reference::Intersection>& expected, double scale) const {
    // A tie: the device's triangle is met at that distance, and the reference's as near as makes no
    // difference.
    if (expected && hit.triangle != INVALID_INDEX && std::abs(hit.t - expected->t) < TIE_DISTANCE * scale) {
      const auto p = placed_positions(subject_.prepared.scene, hit.triangle);
      const auto own = reference::intersect(ray, {dvec3(p[0]), dvec3(p[1]), dvec3(p[2])});
      if (own && std::abs(own->t - hit.t) < TIE_DISTANCE * scale) return Difference::Tie;
    }
    // An edge: a ray beside this one finds what the device found. Edge functions are of the vertices as seen
    // from the origin: from far away, or beside a triangle of kilometres, edges are known that much worse.
    double size = scale;
    for (const uint32_t triangle : {hit.triangle, expected ? expected->triangle : INVALID_INDEX})
      if (triangle != INVALID_INDEX)
        for (const glm::vec3& vertex : placed_positions(subject_.prepared.scene, triangle))
          size = std::max(size, largest_magnitude(dvec3(vertex) - ray.origin));
    for (int k = 0; k < JITTERS; ++k) {
      reference::Ray other = ray;
      other.origin = moved(ray.origin, 4 * ULP * size, k);
      const auto found = closest(other, place);
      if ((found ? found->triangle : INVALID_INDEX) == hit.triangle) return Difference::Edge;
    }
    return Difference::Real;
  }

  void compare_camera_ray(const Path& path, Tally& tally) const {
    const dvec4 u =
        random_block(subject_.reference_settings, path.number, path.sample_index, DIMENSION_BLOCK_CAMERA);
    const dvec2 centre =
        dvec2(path.number % subject_.camera.width(), path.number / subject_.camera.width()) + 0.5;
    const reference::CameraRay ray =
        subject_.camera.ray(centre + subject_.reference_settings.filter.sample({u.x, u.y}), {u.z, u.w});
    const double error = std::max(
        largest_magnitude(ray.direction - dvec3(path.direction)),
        largest_magnitude(ray.origin - dvec3(path.origin)) / std::max(largest_magnitude(ray.origin), 1e-30));
    if (!tally.add_error(error))
      tally.describe(fmt::format("pixel {}: direction {} against {}", path.number, text_of(path.direction),
                                 text_of(ray.direction)));
  }

  void compare_emission(const Path& path, Tally& tally) const {
    const reference::Settings& settings = subject_.reference_settings;
    const dvec4 u =
        random_block(settings, path.number & PATH_NUMBER, path.sample_index, DIMENSION_BLOCK_EMISSION);
    const dvec4 v = random_block(settings, path.number & PATH_NUMBER, path.sample_index,
                                 DIMENSION_BLOCK_EMISSION_DIRECTION);
    const reference::World& world = subject_.world;
    const auto [point, ray] = reference::start_light_path(world, u, {v.x, v.y});
    const reference::LightEnd end = light_end(world, point, ray.direction, ray.origin);
    const double cosine =
        point.is_triangle() ? std::abs(dot(ray.direction, point.surface.geometric_normal)) : 1;
    const dvec3 throughput = end.emitted * cosine / (end.point_pdf * end.density.value);
    // At the rim of a spot's cone falloff and density vanish together.
    const double excused = point.kind == LIGHT_SPOT ? 1e-6 / std::max(end.density.value, 1e-9) * STEP_BOUND
                           : point.kind == LIGHT_ENVIRONMENT ? environment_spread(point)
                                                             : 0;
    const double error =
        std::max({largest_magnitude(ray.direction - dvec3(path.direction)),
                  largest_magnitude(ray.origin - dvec3(path.origin)) /
                      (largest_magnitude(ray.origin) + world.radius()),
                  largest_magnitude(throughput - dvec3(path.throughput)) / largest_magnitude(throughput)});
    if (!tally.add_error(error, excused))
      tally.describe(fmt::format("light path {}: direction {} against {}, throughput {} against {}",
                                 path.number, text_of(path.direction), text_of(ray.direction),
                                 text_of(path.throughput), text_of(throughput)));
  }

  /// How far an environment's radiance moves, relative to itself, with the rounding of its direction: much
  /// beside a bright texel.
  double environment_spread(const reference::LightPoint& point) const {
    const dvec3 radiance = emitted(subject_.world, point, -point.direction);
    double spread = 0;
    for (int k = 0; k < JITTERS; ++k) {
      reference::LightPoint other = point;
      other.direction = normalize(moved(point.direction, 2 * ULP, k));
      const dvec3 difference = emitted(subject_.world, other, -other.direction) - radiance;
      spread = std::max(spread, largest_magnitude(difference) / largest_magnitude(radiance));
    }
    return spread;
  }

  /// The reference's step from the device's inputs, moved by jitter >= 0.
  std::optional<Step> step(const Path& path, const reference::Place& place, const Hit& hit, uint32_t index,
                           int jitter) const {
    const uint32_t last_bounce = subject_.plan.max_depth - (is_camera_ ? 2 : 3);
    if (subject_.plan.max_depth < (is_camera_ ? 2U : 3U) || index > last_bounce) return std::nullopt;
    const bool is_moved = jitter >= 0;
    reference::WalkState state;
    state.direction =
        normalize(is_moved ? moved(dvec3(path.direction), 2 * ULP, jitter) : dvec3(path.direction));
    state.throughput = path.throughput;
    state.eta_scale = path.eta_scale;
    state.medium = path.medium;
    state.place = place;
    if (subject_.world.has_dispersion())
      state.wavelength = reference::wavelength_of(subject_.reference_settings.seed, path.sample_index);
    dvec2 barycentrics(hit.u, hit.v);
    // Texture coordinates are rounded twice more, interpolated and scaled to texels.
    if (is_moved) barycentrics += 4 * ULP * dvec2(sign_of(jitter, 3), sign_of(jitter, 4));
    dvec4 u = random_block(
        subject_.reference_settings, path.number & PATH_NUMBER, path.sample_index,
        is_camera_ ? DIMENSION_BLOCKS_FIRST + index * DIMENSION_BLOCKS_PER_BOUNCE + DIMENSION_BLOCK_BSDF
                   : DIMENSION_BLOCK_LIGHT_BSDF + index);
    if (is_moved)
      u += dvec4(CHOICE_TOLERANCE * sign_of(jitter, 5), ULP * sign_of(jitter, 6), ULP * sign_of(jitter, 7),
                 2 * CHOICE_TOLERANCE * sign_of(jitter, 8));
    u = glm::clamp(u, dvec4(0), dvec4(1 - 1e-9));
    reference::Surface surface = subject_.world.surface_at(hit.triangle, barycentrics);
    const double sign_u = sign_of(jitter, 9), sign_v = sign_of(jitter, 10);
    if (is_moved) {
      surface.uv.own += 2 * ULP * abs(surface.uv.own) * dvec2(sign_u, sign_v);
      surface.uv.weights += 2 * ULP * surface.uv.weights * dvec3(sign_u, sign_v, -sign_u);
    }
    reference::WalkVertex vertex = arrive(subject_.world, surface, way(place, hit), state, 1, is_camera_);
    if (!is_camera_ && index == 0 && !end_by_range(subject_.world, light_point(path), vertex, state))
      return std::nullopt;
    const bool goes_on = is_camera_ ? scatter_from_camera(subject_.world, vertex, state, index, u)
                                    : scatter_from_light(subject_.world, vertex, state, index, u);
    if (!goes_on) return std::nullopt;
    return Step{state.position, state.direction, state.throughput, state.medium};
  }

  /// `before`: throughput of the path before the step.
  double error_between(const Step& a, const Step& b, double before) const {
    return std::max({largest_magnitude(a.direction - b.direction),
                     largest_magnitude(a.throughput - b.throughput) /
                         std::max(largest_magnitude(a.throughput), LEAST_FACTOR * before),
                     largest_magnitude(a.position - b.position) /
                         (subject_.world.radius() + largest_magnitude(a.position))});
  }

  /// Where a light path starts.
  reference::LightPoint light_point(const Path& path) const {
    const dvec4 u = random_block(subject_.reference_settings, path.number & PATH_NUMBER, path.sample_index,
                                 DIMENSION_BLOCK_EMISSION);
    return reference::start_light_path(subject_.world, u, {0, 0}).point;
  }

  /// Length of the last edge: with contacts between the surfaces themselves.
  double way(const reference::Place& place, const Hit& hit) const {
    if (!subject_.world.has_contacts() || place.triangle == INVALID_INDEX) return hit.t;
    const reference::Surface start = subject_.world.surface_at(place.triangle, place.barycentrics);
    const reference::Surface end = subject_.world.surface_at(hit.triangle, dvec2(hit.u, hit.v));
    return length(end.position - start.position);
  }

  void compare_step(const Path& path, const reference::Place& place, const Hit& hit, uint32_t index,
                    bool is_alive, const Path& after, uint32_t slot, Tally& tally) const {
    const std::optional<Step> expected = step(path, place, hit, index, -1);
    const auto of_class = [&] {
      const reference::Surface surface = subject_.world.surface_at(hit.triangle, dvec2(hit.u, hit.v));
      return lobes_of(subject_.world.bsdf_at(surface, place.around)) +
             (path.medium == INVALID_INDEX ? "" : " in a medium");
    };
    if (!is_alive && !expected) {
      tally.add_error(0, 0, of_class());
      return;
    }
    const double before = std::max(largest_magnitude(dvec3(path.throughput)), 1e-30);
    const Step found{dvec3(after.origin), dvec3(after.direction), dvec3(after.throughput), after.medium};
    const double error = is_alive && expected ? error_between(*expected, found, before) : HUGE_VAL;
    if (error <= STEP_BOUND) {
      tally.add_error(error, 0, of_class());
      return;
    }
    // Conditioning: how far the reference moves, and whether it can come to the same kind of result.
    double spread = 0;
    bool can_agree = false;
    for (int k = 0; k < JITTERS; ++k) {
      const std::optional<Step> other = step(path, place, hit, index, k);
      if (expected && other && dot(expected->direction, other->direction) > 0.99)
        spread = std::max(spread, error_between(*expected, *other, before));
      can_agree = can_agree || other.has_value() == is_alive;
      if (is_alive && other) can_agree = can_agree && error_between(*other, found, before) < 0.1;
    }
    const bool is_same_kind = std::isfinite(error) && dot(expected->direction, found.direction) > 0.99;
    if (is_same_kind) {
      if (tally.add_error(error, 4 * spread, of_class())) return;
    } else {
      tally.add_difference(can_agree ? Difference::Tie : Difference::Real, of_class());
      if (can_agree) return;
    }
    tally.describe(fmt::format(
        "slot {} bounce {} triangle {} material {}: {} {} throughput {} against {} {} throughput {}", slot,
        index, hit.triangle, placed_triangle(subject_.prepared.scene, hit.triangle).triangle.material,
        is_alive ? "goes" : "ends", text_of(found.direction), text_of(found.throughput),
        expected ? "goes" : "ends", expected ? text_of(expected->direction) : "",
        expected ? text_of(expected->throughput) : ""));
  }

  const Subject& subject_;
  bool is_camera_;
};

}  // namespace

std::vector<Tally> check_stages(const Subject& subject, Pass pass, const Recording& recording) {
  const StageChecker checker(subject, pass);
  const bool is_camera = pass == Pass::Camera;
  Tally trace(is_camera ? "trace_closest" : "light.trace_closest", DISTANCE_BOUND);
  Tally bounce(is_camera ? "camera_bounce" : "light_bounce", STEP_BOUND);
  Tally visibility("trace_visibility", 0);
  for (uint32_t i = 0; i < recording.bounces.size(); ++i) {
    checker.trace(recording.bounces[i], trace);
    checker.bounce(recording.bounces[i], i, bounce);
    if (is_camera) checker.visibility(recording.bounces[i], visibility);
  }
  std::vector<Tally> all{checker.generate(recording), trace, bounce};
  if (is_camera) all.push_back(visibility);
  return all;
}

}  // namespace regulus::check
