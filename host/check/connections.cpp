// Connections, merges and splats one by one, weights included: what each of the device's carries against the
// path's definition. The reference follows the device's walks from surface point to surface point, so that
// its paths are the device's and only the errors of what is judged here remain.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "check/check.hpp"
#include "check/sampled_light.hpp"
#include "check/sorting.hpp"
#include "reference/estimator.hpp"
#include "reference/light_choice.hpp"
#include "reference/parallel.hpp"

namespace regulus::check {

using glm::dvec2;
using glm::dvec3;
using namespace interface;
using render::ConnectionRecording;
using render::RecordedConnections;

namespace {

constexpr double VALUE_BOUND = 1e-4;   // relative
constexpr double WEIGHT_BOUND = 1e-5;  // absolute
constexpr double NOISE = 1e-6;         // of the mean of all, below which a value says nothing of its weight
// Share of walks that cannot be followed because another lobe was a tie, and of sums that differ because a
// vertex lies on the merge radius or a segment on an edge.
constexpr double ALLOWED = 1e-3;
// Sums on the film are multiples of this; below a million times as much they say nothing of a weight of 1e-5.
// Of the sum of four cosines that is a filter's window in one direction.
constexpr double WINDOW_ROUNDINGS = 8 * 0x1p-24;
// Of Settings::rounding_pattern. Errors of many roundings are nearly normal: that of all eight one is less
// than a fourth of what the device happens to have is a matter of 3e-6.
constexpr uint32_t ROUNDING_PATTERNS = 8;
constexpr double CONDITIONING = 4;

double largest(const dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

/// All walks of an iteration.
struct Iteration {
  std::vector<reference::CameraSubpath> camera;
  reference::LightCache light;
};

/// Something that the device has evaluated, and how to find it in the reference.
struct Item {
  uint32_t technique;
  uint32_t pixel;  // of the camera walk
  size_t camera_edges;
  uint32_t light_path;
  size_t light_edges;
  dvec3 found{0};
  uint32_t light = INVALID_INDEX;  // that the device sampled
};

/// The same by definition. `unweighted` times `weight` is what it contributes.
struct Expected {
  dvec3 unweighted{0};
  double weight = 1;
  bool is_one_path = true;  // false: the sum of several, whose weights cannot be told apart
  dvec3 value() const { return weight * unweighted; }
};

class ConnectionChecker {
 public:
  ConnectionChecker(const Subject& subject, uint32_t sample, const ConnectionRecording& recording)
      : subject_(subject),
        sample_(sample),
        recording_(recording),
        settings_(subject.reference_settings),
        owner_(light_paths_of(recording)) {
    settings_.expected_light_vertices = recording.expected_vertices;
    estimator_ = std::make_unique<reference::Estimator>(subject_.world, subject_.camera, settings_);
    set_ = estimator_->techniques(sample);
    gather_walks();
    iterations_.push_back(walk(0));
  }

  std::vector<Tally> run() {
    Tally pairs("connection pairs", 0);
    Tally choices("choices of a light", 0);
    std::vector<Item> hit, escaped, nee, connected, merged;
    for (uint32_t i = 0; i < recording_.bounces.size(); ++i) {
      const RecordedConnections& bounce = recording_.bounces[i];
      check_pairs(bounce, i, pairs);
      for (const uint32_t slot : bounce.slots) {
        const bool has_left = bounce.hits[slot].triangle == INVALID_INDEX;
        const size_t followed = iterations_.front().camera[slot].vertices.size();
        if (has_left ? followed == i : followed > i)
          (has_left ? escaped : hit).push_back({TECHNIQUE_HIT, slot, i + 1, 0, 0, dvec3(bounce.met[slot])});
        if (!is_same_walk(bounce, slot, i)) continue;
        const dvec3 sum = bounce.merged[slot];
        if (bounce.camera_vertices[slot].edges != 0)
          merged.push_back({TECHNIQUE_MERGE, slot, i + 1, 0, 0, sum});
      }
      for (const VisibilityCandidate& candidate : bounce.light_samples)
        if (is_same_walk(bounce, candidate.path, i)) nee.push_back(light_sample_item(candidate, i, choices));
      gather_connections(bounce, i, connected);
    }
    Tally weights(WEIGHTS, WEIGHT_BOUND, ALLOWED);
    std::vector<Tally> tallies{check_walks(), pairs, choices};
    tallies.push_back(judge("hit", hit, weights));
    if (!escaped.empty()) tallies.push_back(judge("escape", escaped, weights));
    tallies.push_back(judge("light samples", nee, weights));
    tallies.push_back(judge("connect", connected, weights));
    tallies.push_back(judge("merge", merged, weights));
    tallies.push_back(judge("splats", splats(), weights));
    tallies.push_back(weights);
    tallies.push_back(check_splat_film());
    return tallies;
  }

 private:
  /// Where the device's walks meet surfaces.
  void gather_walks() {
    const auto append = [](const std::vector<Hit>& hits, auto& walks) {
      for (size_t i = 0; i < walks.size(); ++i)
        if (hits[i].triangle != INVALID_INDEX) walks[i].push_back({hits[i].triangle, {hits[i].u, hits[i].v}});
    };
    camera_hits_.resize(size_t{settings_.width} * settings_.height);
    light_hits_.resize(settings_.paths_per_iteration());
    for (const RecordedConnections& bounce : recording_.bounces) append(bounce.hits, camera_hits_);
    for (const std::vector<Hit>& hits : recording_.light_hits) append(hits, light_hits_);
  }

  /// How many of them the reference could follow to their end.
  Tally check_walks() const {
    Tally tally("walks followed", 0, ALLOWED);
    const auto compare = [&](const char* kind, const auto& walks, const auto& given) {
      for (size_t i = 0; i < walks.size(); ++i) {
        if (walks[i].vertices.size() == given[i].size()) {
          tally.add_error(0);
          continue;
        }
        tally.add_difference(Difference::Real);
        tally.describe(
            fmt::format("{} path {}: {} of {} vertices", kind, i, walks[i].vertices.size(), given[i].size()));
      }
    };
    compare("camera", iterations_.front().camera, camera_hits_);
    compare("light", iterations_.front().light.subpaths(), light_hits_);
    return tally;
  }

  Iteration walk(uint32_t pattern) const {
    reference::Settings settings = settings_;
    settings.rounding_pattern = pattern;
    std::vector<reference::CameraSubpath> camera(size_t{settings.width} * settings.height);
    std::vector<reference::LightSubpath> light(settings.paths_per_iteration());
    reference::parallel_ranges(
        static_cast<uint32_t>(camera.size()), 256, 0, [&](uint32_t begin, uint32_t end) {
          for (uint32_t i = begin; i < end; ++i)
            camera[i] =
                walk_from_camera(subject_.world, subject_.camera, settings, i, sample_, &camera_hits_[i]);
        });
    reference::parallel_ranges(
        static_cast<uint32_t>(light.size()), 256, 0, [&](uint32_t begin, uint32_t end) {
          for (uint32_t i = begin; i < end; ++i)
            light[i] = walk_from_light(subject_.world, settings, i, sample_, &light_hits_[i]);
        });
    return {std::move(camera), estimator_->light_cache(std::move(light), sample_)};
  }

  /// True if the reference's walk from that pixel meets the triangle of the device's.
  bool is_same_walk(const RecordedConnections& bounce, uint32_t pixel, uint32_t index) const {
    const auto& vertices = iterations_.front().camera[pixel].vertices;
    return index < vertices.size() &&
           vertices[index].surface.triangle == bounce.camera_vertices[pixel].triangle;
  }

  bool is_same_light_walk(uint32_t vertex) const {
    if (vertex >= owner_.size() || owner_[vertex] == INVALID_INDEX) return false;
    const PathVertex& found = recording_.light_vertices[vertex];
    const auto& vertices = iterations_.front().light.subpaths()[owner_[vertex]].vertices;
    const uint32_t edges = found.edges & PATH_VERTEX_EDGES;
    return edges <= vertices.size() && vertices[edges - 1].surface.triangle == found.triangle;
  }

  // ---- which vertices are connected

  /// The light vertex of a number, by the device's own lists; INVALID_INDEX if these are broken.
  uint32_t numbered(uint32_t number) const {
    const auto after = std::upper_bound(recording_.path_ends.begin(), recording_.path_ends.end(), number);
    if (after == recording_.path_ends.begin()) return INVALID_INDEX;
    const auto path = static_cast<size_t>(after - recording_.path_ends.begin()) - 1;
    uint32_t vertex = recording_.heads[path].last;
    for (uint32_t k = recording_.path_ends[path]; k < number && vertex < recording_.light_vertices.size();
         ++k)
      vertex = recording_.light_vertices[vertex].link;
    return vertex < recording_.light_vertices.size() ? vertex : INVALID_INDEX;
  }

  void check_pairs(const RecordedConnections& bounce, uint32_t index, Tally& tally) const {
    std::vector<std::vector<uint32_t>> found(bounce.camera_vertices.size()), wanted(found.size());
    for (const ConnectionPair& pair : bounce.pairs) found[pair.slot].push_back(pair.vertex);
    const auto cached = static_cast<uint32_t>(recording_.light_vertices.size());
    for (const uint32_t slot : bounce.slots) {
      if (bounce.camera_vertices[slot].edges == 0 || !is_same_walk(bounce, slot, index)) continue;
      for (uint32_t k = 0; cached > 0 && k < settings_.cache_connections; ++k) {
        const uint32_t block = DIMENSION_BLOCK_CACHE + index * 256 + k / 4;
        const double u = random_block(settings_, slot, sample_, block)[static_cast<int>(k % 4)];
        const auto number = static_cast<uint32_t>(static_cast<float>(u) * static_cast<float>(cached));
        const uint32_t vertex = numbered(std::min(number, cached - 1));
        if (vertex == INVALID_INDEX) continue;
        const uint32_t edges = recording_.light_vertices[vertex].edges & PATH_VERTEX_EDGES;
        if (index + 1 + edges + 1 <= settings_.max_depth) wanted[slot].push_back(vertex);
      }
      std::sort(found[slot].begin(), found[slot].end());
      std::sort(wanted[slot].begin(), wanted[slot].end());
      if (found[slot] == wanted[slot]) {
        tally.add_error(0);
        continue;
      }
      tally.add_difference(Difference::Real);
      tally.describe(fmt::format("pixel {} vertex {}: {} pairs against {}", slot, index + 1,
                                 found[slot].size(), wanted[slot].size()));
    }
  }

  /// The pairs with the candidate that each became; none: nothing, which the reference may know better.
  void gather_connections(const RecordedConnections& bounce, uint32_t index, std::vector<Item>& items) const {
    std::vector<std::vector<const VisibilityCandidate*>> candidates(bounce.camera_vertices.size());
    for (const VisibilityCandidate& candidate : bounce.connections)
      candidates[candidate.path].push_back(&candidate);
    for (const ConnectionPair& pair : bounce.pairs) {
      if (!is_same_walk(bounce, pair.slot, index) || !is_same_light_walk(pair.vertex)) continue;
      const PathVertex& light = recording_.light_vertices[pair.vertex];
      Item item{TECHNIQUE_CONNECT, pair.slot, index + 1, owner_[pair.vertex],
                light.edges & PATH_VERTEX_EDGES};
      double nearest = 1e-3 * subject_.world.radius();
      for (const VisibilityCandidate* candidate : candidates[pair.slot]) {
        const dvec3 end = dvec3(candidate->origin) + double{candidate->t_max} * dvec3(candidate->direction);
        const double distance = length(end - dvec3(light.position));
        if (distance >= nearest) continue;
        nearest = distance;
        item.found = dvec3(candidate->contribution);
      }
      items.push_back(item);
    }
  }

  // ---- which light is sampled

  glm::dvec4 light_numbers(uint32_t pixel, size_t bounce) const {
    const auto block = static_cast<uint32_t>(bounce) * DIMENSION_BLOCKS_PER_BOUNCE + DIMENSION_BLOCK_LIGHT;
    return random_block(settings_, pixel, sample_, DIMENSION_BLOCKS_FIRST + block);
  }

  /// The light sample that became a candidate, of the light that the device chose.
  Item light_sample_item(const VisibilityCandidate& candidate, uint32_t bounce, Tally& choices) const {
    const uint32_t pixel = candidate.path;
    const reference::WalkVertex& vertex = iterations_.front().camera[pixel].vertices[bounce];
    const SampledLight sampled =
        sampled_light(subject_.world, receiver_at(subject_.world, vertex.surface, vertex.w_back),
                      light_numbers(pixel, bounce), candidate);
    switch (sampled.choice) {
      case LightChoice::Same:
        choices.add_error(0);
        break;
      case LightChoice::Tie:
        choices.add_difference(Difference::Tie);
        break;
      case LightChoice::Unexplained:
        choices.add_difference(Difference::Real);
        choices.describe(
            fmt::format("pixel {}, {} edges: no light that can be chosen lies there", pixel, bounce + 1));
    }
    return {TECHNIQUE_NEE, pixel, bounce + 1, 0, 0, dvec3(candidate.contribution), sampled.light};
  }

  // ---- splats

  std::vector<Item> splats() const {
    std::vector<const SplatCandidate*> sorted;
    for (const SplatCandidate& splat : recording_.splats) sorted.push_back(&splat);
    const auto before = [](const SplatCandidate* a, const SplatCandidate* b) {
      return a->film.x < b->film.x;
    };
    std::sort(sorted.begin(), sorted.end(), before);
    std::vector<Item> items;
    if ((set_.bits & TECHNIQUE_SPLAT) == 0) return items;
    const auto& subpaths = iterations_.front().light.subpaths();
    for (uint32_t path = 0; path < subpaths.size(); ++path)
      estimator_->light_sample(subpaths[path], path, sample_, [&](const reference::Contribution& found) {
        const dvec2 film = found.sampled.film;
        SplatCandidate low{};
        low.film.x = static_cast<float>(film.x - 1e-3);
        const SplatCandidate* best = nullptr;
        double nearest = 1e-3;
        for (auto at = std::lower_bound(sorted.begin(), sorted.end(), &low, before);
             at != sorted.end() && (*at)->film.x < film.x + 1e-3; ++at) {
          const double distance = length(dvec2((*at)->film) - film);
          if (distance >= nearest) continue;
          nearest = distance;
          best = *at;
        }
        // Off the film nothing is queued; a walk that went another way leaves no splat here.
        if (best == nullptr) return;
        // Of both copies of a technique there is one splat.
        const size_t edges = found.sampled.vertex - 1;
        if (!items.empty() && items.back().light_path == path && items.back().light_edges == edges) return;
        items.push_back({TECHNIQUE_SPLAT, 0, 0, path, edges, dvec3(best->segment.contribution)});
      });
    return items;
  }

  /// Every splat that is not occluded, spread over the pixels whose filter reaches it.
  Tally check_splat_film() const {
    Tally tally("trace_splats", VALUE_BOUND, ALLOWED);
    if (recording_.splat_film.empty()) return tally;
    std::vector<dvec3> expected(recording_.splat_film.size(), dvec3(0));
    std::vector<double> rounding(expected.size(), 0);
    const reference::Filter& filter = settings_.filter;
    for (size_t i = 0; i < recording_.splats.size(); ++i) {
      const SplatCandidate& splat = recording_.splats[i];
      const VisibilityCandidate& segment = splat.segment;
      const reference::Ray ray{dvec3(segment.origin), normalize(dvec3(segment.direction)), 0, segment.t_max};
      reference::Place place;
      if (!recording_.splat_media.empty())
        place = {reference::Media(recording_.splat_media[i].around), recording_.splat_media[i].triangle};
      if (subject_.world.meet(ray, place)) continue;
      const dvec2 film(splat.film);
      const auto reach = static_cast<int>(std::ceil(filter.radius)) + 1;
      const glm::ivec2 at(glm::floor(film));
      for (int y = std::max(at.y - reach, 0);
           y < std::min<int>(at.y + reach + 1, static_cast<int>(settings_.height)); ++y)
        for (int x = std::max(at.x - reach, 0);
             x < std::min<int>(at.x + reach + 1, static_cast<int>(settings_.width)); ++x) {
          const size_t pixel = static_cast<size_t>(y) * settings_.width + static_cast<size_t>(x);
          const dvec2 offset = film - dvec2(x + 0.5, y + 0.5);
          expected[pixel] += filter.value(offset) * dvec3(segment.contribution);
          // A window is a sum of cosines: towards its rim they cancel, to roundings of its peak.
          if (filter.value(offset) > 0)
            rounding[pixel] += WINDOW_ROUNDINGS * largest(dvec3(segment.contribution)) *
                               (filter.value({offset.x, 0}) + filter.value({0, offset.y}));
        }
    }
    double mean = 0;
    for (const dvec3& value : expected) mean += largest(value) / static_cast<double>(expected.size());
    for (size_t i = 0; i < expected.size(); ++i) {
      const double excused = rounding[i] > 0 ? rounding[i] / std::max(largest(expected[i]), 0.01 * mean) : 0;
      const dvec3& found = recording_.splat_film[i];
      if (!tally.add_error(relative(found, expected[i], 0.01 * mean), excused))
        tally.describe(fmt::format("pixel {}: ({:.6g} {:.6g} {:.6g}) against ({:.6g} {:.6g} {:.6g})", i,
                                   found.x, found.y, found.z, expected[i].x, expected[i].y, expected[i].z));
    }
    return tally;
  }

  // ---- values and weights

  static double relative(const dvec3& found, const dvec3& expected, double floor) {
    const double difference = largest(found - expected);
    return difference == 0 ? 0 : difference / std::max(largest(expected), floor);
  }

  static void add(const Expected& more, std::optional<Expected>& sum) {
    sum = sum ? Expected{sum->value() + more.value(), 1, false} : more;
  }

  Expected by_definition(const reference::SampledPath& sampled) const {
    std::optional<Expected> result;
    contribute(sampled, set_, [&](const reference::Contribution& found) {
      add({found.unweighted, found.weight}, result);
    });
    return result.value_or(Expected{});
  }

  /// Nothing if the reference finds no such path, for instance because something is in the way.
  std::optional<Expected> expected(const Iteration& iteration, const Item& item) const {
    const auto& subpaths = iteration.light.subpaths();
    if (item.technique == TECHNIQUE_SPLAT) {
      std::optional<Expected> result;
      estimator_->light_sample(subpaths[item.light_path], item.light_path, sample_,
                               [&](const reference::Contribution& found) {
                                 if (found.sampled.vertex == item.light_edges + 1)
                                   add({found.unweighted, found.weight}, result);
                               });
      return result;
    }
    const reference::CameraSubpath& camera = iteration.camera[item.pixel];
    if (item.technique == TECHNIQUE_HIT) {
      const auto met = item.camera_edges <= camera.vertices.size()
                           ? hit_light(subject_.world, camera, item.camera_edges)
                           : hit_environment(subject_.world, camera);
      return met ? by_definition(*met) : Expected{};
    }
    if (item.camera_edges > camera.vertices.size()) return std::nullopt;
    if (item.technique == TECHNIQUE_MERGE) return merges(iteration, camera, item.camera_edges);
    std::optional<reference::SampledPath> sampled;
    double scale = 1;
    if (item.technique == TECHNIQUE_NEE) {
      sampled = light_sample(camera, item);
    } else {
      const reference::LightSubpath& light = subpaths[item.light_path];
      if (item.light_edges > light.vertices.size()) return std::nullopt;
      sampled = connect_vertices(subject_.world, light, item.light_edges, camera, item.camera_edges);
      scale = static_cast<double>(recording_.light_vertices.size()) / recording_.expected_vertices;
    }
    if (!sampled) return std::nullopt;
    Expected result = by_definition(*sampled);
    result.unweighted *= scale;
    return result;
  }

  std::optional<reference::SampledPath> light_sample(const reference::CameraSubpath& camera,
                                                     const Item& item) const {
    if (item.light == INVALID_INDEX) return std::nullopt;
    const glm::dvec4 u = light_numbers(item.pixel, item.camera_edges - 1);
    const reference::World& world = subject_.world;
    return connect_to_light(world, sample_light_point(world, item.light, {u.z, u.w}), camera,
                            item.camera_edges);
  }

  Expected merges(const Iteration& iteration, const reference::CameraSubpath& camera, size_t edges) const {
    std::vector<Expected> all;
    for (const auto [path, m] : iteration.light.near(camera.vertices[edges - 1].surface.position)) {
      if (edges + m > settings_.max_depth) continue;
      const auto sampled = merge_vertices(iteration.light.subpaths()[path], m, camera, edges);
      if (sampled) all.push_back(by_definition(*sampled));
    }
    if (all.size() == 1) return all.front();
    Expected sum{dvec3(0), 1, false};
    for (const Expected& one : all) sum.unweighted += one.value();
    return sum;
  }

  /// How far rounding moves what the reference finds: the value relative to itself, and the weight.
  std::pair<double, double> spread(const Item& item, const Expected& exact, double floor) {
    for (auto pattern = static_cast<uint32_t>(iterations_.size()); pattern <= ROUNDING_PATTERNS; ++pattern)
      iterations_.push_back(walk(pattern));
    double of_value = 0;
    double of_weight = 0;
    for (uint32_t pattern = 1; pattern <= ROUNDING_PATTERNS; ++pattern) {
      const std::optional<Expected> moved = expected(iterations_[pattern], item);
      const Expected other = moved.value_or(Expected{dvec3(0), 0});
      of_value = std::max(of_value, relative(other.value(), exact.value(), floor));
      of_weight = std::max(of_weight, std::abs(other.weight - exact.weight) +
                                          exact.weight * relative(other.unweighted, exact.unweighted, 0));
    }
    return {of_value, of_weight};
  }

  Tally judge(const char* name, const std::vector<Item>& items, Tally& weights) {
    Tally tally(name, VALUE_BOUND, ALLOWED);
    std::vector<std::optional<Expected>> exact;
    double mean = 0;
    for (const Item& item : items) {
      exact.push_back(expected(iterations_.front(), item));
      if (exact.back()) mean += largest(exact.back()->value()) / static_cast<double>(items.size());
    }
    const double floor = 0.01 * mean;
    for (size_t i = 0; i < items.size(); ++i)
      if (exact[i]) judge_item(items[i], *exact[i], floor, name, tally, weights);
    return tally;
  }

  /// Resolution of the film.
  double film_unit() const {
    return std::ldexp(1.0, subject_.scene.film_exponents.radiance - int{FILM_FRACTION_BITS});
  }

  void judge_item(const Item& item, const Expected& wanted, double floor, const char* name, Tally& tally,
                  Tally& weights) {
    const double error = relative(item.found, wanted.value(), floor);
    // Two points of one plane are connected at cosines that are nothing but rounding.
    const double least = std::max(NOISE * floor, item.technique == TECHNIQUE_MERGE ? 1e6 * film_unit() : 0);
    const bool has_weight = wanted.is_one_path && largest(wanted.value()) > least;
    const double weight =
        has_weight ? reference::luminance(item.found) / reference::luminance(wanted.unweighted) : 0;
    const double weight_error = has_weight ? std::abs(weight - wanted.weight) : 0;
    std::pair<double, double> excused(0, 0);
    if (!(error <= VALUE_BOUND && weight_error <= WEIGHT_BOUND)) excused = spread(item, wanted, floor);
    const auto words = [&] {
      return fmt::format(
          "{}: pixel {}, {} edges; light path {}, {} edges: ({:.6g} {:.6g} {:.6g}) against ({:.6g} "
          "{:.6g} {:.6g}), weight {:.6g} against {:.6g}, of which rounding explains {:.1e}",
          name, item.pixel, item.camera_edges, item.light_path, item.light_edges, item.found.x, item.found.y,
          item.found.z, wanted.value().x, wanted.value().y, wanted.value().z, weight, wanted.weight,
          CONDITIONING * excused.second);
    };
    if (!tally.add_error(error, CONDITIONING * excused.first)) tally.describe(words());
    if (has_weight && !weights.add_error(weight_error, CONDITIONING * excused.second))
      weights.describe(words());
  }

  const Subject& subject_;
  uint32_t sample_;
  const ConnectionRecording& recording_;
  reference::Settings settings_;
  std::vector<uint32_t> owner_;  // light path of each light vertex
  std::unique_ptr<reference::Estimator> estimator_;
  reference::TechniqueSet set_;
  std::vector<std::vector<reference::GivenHit>> camera_hits_, light_hits_;  // by pixel, by light path
  std::vector<Iteration> iterations_;  // exact, then with patterns of roundings
};

}  // namespace

std::vector<Tally> check_connections(const Subject& subject, uint32_t sample,
                                     const ConnectionRecording& recording) {
  return ConnectionChecker(subject, sample, recording).run();
}

}  // namespace regulus::check
