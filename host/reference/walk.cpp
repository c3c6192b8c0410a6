#include "reference/walk.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/components.hpp"
#include "reference/rng.hpp"
#include "reference/rounding.hpp"
#include "reference/sampling.hpp"

namespace regulus::reference {

using glm::dvec2;
using glm::dvec3;
using glm::dvec4;
using namespace interface;

namespace {

/// Relative index n(other side) / n(side of w_back).
double index_ahead(const WalkVertex& vertex) {
  return vertex.bsdf.relative_index(to_material(vertex.surface, as_seen(vertex.surface, vertex.w_back)));
}

/// The direction that a guided camera walk takes in place of one of the diffuse lobe, if `u` says so: invalid
/// where no light of that lobe comes from there.
std::optional<BsdfSample> guided_sample(const WalkVertex& vertex, const dvec4& u) {
  const Surface& surface = vertex.surface;
  const GuideCell cell = cell_towards(surface, vertex.w_back);
  if (!(cell.share > 0)) return std::nullopt;
  const dvec3 wo = to_material(surface, as_seen(surface, vertex.w_back));
  const double p_coat = vertex.bsdf.coat_probability(wo);
  // Of the numbers that choose a lobe, the diffuse one has those from p_coat on.
  const double left = (u.x - p_coat) / ((1 - p_coat) * vertex.bsdf.diffuse_probability(wo));
  if (!(left >= 0 && left < cell.share)) return std::nullopt;
  BsdfSample sample;
  sample.is_diffuse = true;
  sample.wi = guided_direction(*surface.walk_guide, cell, {u.y, u.z});
  const Lit lit = lit_from(surface, sample.wi, vertex.w_back);
  sample.is_valid = !lit.is_dark && !lit.is_in_relief_shadow && to_material(surface, lit.w).z * wo.z > 0;
  return sample;
}

/// Samples the bsdf in the frame that device and reference share: Basis on the shading normal of the side on
/// which w_back is. Returns the sample with its wi in world space; invalid where no light goes that way.
BsdfSample sample_direction(const WalkVertex& vertex, const dvec4& u, TransportMode transport) {
  const Surface& surface = vertex.surface;
  const SamplingFrame frame(surface, vertex.w_back);
  BsdfSample sample =
      frame.bsdf_of(surface, vertex.bsdf)
          .sample(frame.to_local(as_seen(surface, vertex.w_back)), u.x, {u.y, u.z}, transport);
  if (!sample.is_valid) return {};
  sample.wi = normalize(frame.to_world(sample.wi));
  if (transport == TransportMode::Importance) {
    sample.wi = as_seen(surface, sample.wi);
    const Lit lit = lit_from(surface, vertex.w_back, sample.wi);
    return lit.is_dark || (lit.is_in_relief_shadow && sample.is_diffuse) ? BsdfSample{} : sample;
  }
  const Lit lit = lit_from(surface, sample.wi, vertex.w_back);
  if (lit.is_dark || (lit.is_in_relief_shadow && sample.is_diffuse)) return {};
  if (lit.is_turned) sample.wi = lit.w;  // the half-turn is its own inverse
  return sample;
}

/// True if the walk's next ray starts on the curved surface that the facet stands for.
bool leaves_beyond(const WalkVertex& vertex, TransportMode transport) {
  return transport == TransportMode::Radiance && vertex.scattering.is_beyond;
}

// Places of a walk's rays in Rounding, which must differ from those of its random blocks.
constexpr uint32_t ROUNDING_CAMERA = 1u << 30;
constexpr uint32_t ROUNDING_LIGHT = 3u << 30;

// A direction leads to a given point if it passes within this distance of it, relative to the distance and to
// the size of the scene, plus how far off its surface a ray may have started. Single precision stays far
// within this, another lobe does not.
constexpr double GIVEN_ANGLE = 1e-3;
constexpr double GIVEN_OFFSET = 1e-5;

/// Where a ray from one of a walk's vertices arrives.
struct Arrival {
  Surface surface;
  double distance;
};

std::optional<Arrival> trace(const World& world, const Ray& ray, Place& place) {
  const std::optional<Intersection> hit = world.meet(ray, place);
  if (!hit) return std::nullopt;
  return Arrival{world.surface_at(hit->triangle, hit->barycentrics), hit->t};
}

/// The given hit, if the ray leads there. `start`: surface of its origin, or null.
std::optional<Arrival> follow(const World& world, const Ray& ray, const Surface* start, const GivenHit& hit,
                              Place& place) {
  const Surface surface = world.surface_at(hit.triangle, hit.barycentrics);
  const double distance = length(surface.position - ray.origin);
  const double miss = length(ray.origin + distance * ray.direction - surface.position);
  const double off_surface = start == nullptr ? 0 : clearance(world, *start);
  if (!(miss <= GIVEN_ANGLE * distance + GIVEN_OFFSET * world.radius() + off_surface)) return std::nullopt;
  if (world.has_contacts()) {
    // The solids around the point are found by meeting everything that lies before it.
    Ray shorter = ray;
    shorter.t_max = distance - GIVEN_OFFSET * (world.radius() + distance);
    world.meet(shorter, place);
  }
  return Arrival{surface, distance};
}

// Difference between the tables of rough interfaces of device and reference
// (RoughBase.TablesOfDeviceAndReferenceAgree).
constexpr double COVER_TABLE_ERROR = 6e-6;
// Error of the device's fit of a smooth interface's mean reflectance (fresnel_mean_position).
constexpr double FRESNEL_FIT_ERROR = 1e-5;

/// How far single precision moves a given hit: b0 v0 + b1 v1 + b2 v2 with b0 = 1 - b1 - b2 is four roundings
/// of the vertices' size.
double given_hit_error(const World& world, const Surface& surface) {
  double size = 0;
  for (const glm::vec3& vertex : placed_positions(world.scene(), surface.triangle))
    size = std::max(size, largest_component(glm::abs(dvec3(vertex))));
  return 4 * UNIT_ROUNDOFF * size;
}

/// A surface point as single precision has it.
void round_surface(const World& world, Surface& surface, bool is_given, Rounding& rounding) {
  const auto move = [&](double& value) {
    value = rounding.moved(value, 2 * UNIT_ROUNDOFF * std::abs(value));
  };
  move(surface.uv.own.x);
  move(surface.uv.own.y);
  move(surface.uv.weights.x);
  move(surface.uv.weights.y);
  for (int axis = 0; axis < 3; ++axis)
    surface.shading_normal[axis] = rounding.moved(surface.shading_normal[axis], 2 * UNIT_ROUNDOFF);
  surface.shading_normal = normalize(surface.shading_normal);
  if (surface.coat_normal != dvec3(0)) {
    for (int axis = 0; axis < 3; ++axis)
      surface.coat_normal[axis] = rounding.moved(surface.coat_normal[axis], 2 * UNIT_ROUNDOFF);
    surface.coat_normal = normalize(surface.coat_normal);
  }
  const std::array<glm::vec3, 3> vertices = placed_positions(world.scene(), surface.triangle);
  // The terms of the cross product of two edges, twice the area, nearly cancel in needles.
  const double terms =
      length(dvec3(vertices[1]) - dvec3(vertices[0])) * length(dvec3(vertices[2]) - dvec3(vertices[0]));
  for (int axis = 0; axis < 3; ++axis)
    surface.geometric_normal[axis] =
        rounding.moved(surface.geometric_normal[axis], 2 * UNIT_ROUNDOFF * terms / (2 * surface.area));
  surface.geometric_normal = normalize(surface.geometric_normal);
  if (is_given) {  // otherwise the rounding of its ray has moved it
    const double error = given_hit_error(world, surface);
    for (int axis = 0; axis < 3; ++axis)
      surface.position[axis] = rounding.moved(surface.position[axis], error);
  }
  surface.cover_error = rounding.moved(0, COVER_TABLE_ERROR);
  surface.fresnel_error = rounding.moved(0, FRESNEL_FIT_ERROR);
}

/// A walk on its way.
struct Walk {
  const World& world;
  const Settings& settings;
  uint32_t stream, sample;
  const std::vector<GivenHit>* given;

  glm::dvec4 block(uint32_t index) const { return random_block(settings, stream, sample, index); }

  /// The vertex that a ray reaches from surface `start` (null: from none).
  std::optional<WalkVertex> next_vertex(uint32_t bounce, Ray ray, const Surface* start, WalkState& state,
                                        double cos_start, bool is_from_camera) const {
    if (given != nullptr && bounce >= given->size()) return std::nullopt;
    Rounding rounding(settings.rounding_pattern, stream, sample,
                      (is_from_camera ? ROUNDING_CAMERA : ROUNDING_LIGHT) + bounce);
    if (rounding.is_on()) {
      ray = rounded(world, ray, start, rounding);
      state.direction = ray.direction;
    }
    std::optional<Arrival> at = given == nullptr ? trace(world, ray, state.place)
                                                 : follow(world, ray, start, (*given)[bounce], state.place);
    if (!at) return std::nullopt;
    // The way lies between the surfaces themselves, although rays start off them. Rays that start beyond a
    // facet's horizon leave no surface.
    constexpr double NO_WAY = 1e-15;  // m; densities divide by it
    const double from_origin = at->distance;
    if (world.has_contacts() && start != nullptr && state.place.triangle != INVALID_INDEX)
      at->distance = std::max(length(at->surface.position - start->position), NO_WAY);
    if (rounding.is_on()) round_surface(world, at->surface, given != nullptr, rounding);
    WalkVertex vertex = arrive(world, at->surface, at->distance, state, cos_start, is_from_camera);
    // Media are measured between surfaces, but the weights of single precision take the ray's own length,
    // which knows nothing of how well the hit says where it is.
    if (rounding.is_on())
      vertex.edge.distance =
          given == nullptr
              ? from_origin
              : std::max(rounding.moved(from_origin, given_hit_error(world, at->surface)), NO_WAY);
    return vertex;
  }
};

/// Samples the next direction at a vertex and plays roulette with `survival` (a function of the step's
/// weight). False if the walk ends there.
template <typename Survival>
bool continue_walk(const World& world, WalkVertex& vertex, WalkState& state, const dvec4& u,
                   TransportMode transport, const Regularization& regularization,
                   const Survival& survival_of) {
  const bool is_radiance = transport == TransportMode::Radiance;
  const std::optional<BsdfSample> guided = is_radiance ? guided_sample(vertex, u) : std::nullopt;
  const BsdfSample sample = guided ? *guided : sample_direction(vertex, u, transport);
  if (!sample.is_valid) return false;
  vertex.sample = sample;
  const dvec3& w_light = is_radiance ? sample.wi : vertex.w_back;
  const dvec3& w_camera = is_radiance ? vertex.w_back : sample.wi;
  vertex.scattering =
      scattering_of_sample(vertex.surface, vertex.bsdf, w_light, w_camera, sample, transport, regularization);
  // f cos / p with the path's own factors, which correct for shading normals in light walks.
  const double pdf = is_radiance ? vertex.scattering.reverse : vertex.scattering.forward;
  const dvec3 weight =
      vertex.scattering.value * std::abs(dot(sample.wi, vertex.surface.geometric_normal)) / pdf;
  const double survival = survival_of(weight, sample);
  if (!(u.w < survival)) return false;
  state.throughput *= weight / survival;
  state.survival *= survival;
  const bool is_beyond = leaves_beyond(vertex, transport);
  state.medium =
      world.medium_towards(vertex.surface, vertex.medium, vertex.around, vertex.w_back, sample.wi, is_beyond);
  state.place = world.place_towards(vertex.surface, vertex.around, vertex.w_back, sample.wi, is_beyond);
  state.position = vertex.surface.position;
  if (is_beyond) state.position += vertex.surface.rise;
  state.direction = sample.wi;
  return true;
}

}  // namespace

Regularization regularization_of(const Settings& settings, uint32_t sample) {
  Regularization regularization;
  regularization.is_on = (settings.regularization & REGULARIZATION_ROUGHNESS) != 0;
  regularization.has_diffusion = (settings.regularization & REGULARIZATION_DIFFUSION) != 0;
  regularization.tau = regularization.full_tau = settings.tau;
  regularization.is_virtual = (settings.regularization & REGULARIZATION_VIRTUAL_MERGE) != 0;
  regularization.has_bounds = regularization.is_on && settings.sampler_quality != SAMPLER_QUALITY_OFF;
  regularization.bound = settings.bound;
  regularization.mis = settings.mis;
  if ((settings.regularization & REGULARIZATION_CONSISTENT) != 0)
    regularization.alpha_scale = std::pow(sample + 1.0, -1.0 / 6);
  return regularization;
}

Regularization regularization_at(const Settings& settings, uint32_t sample, const Footprint& footprint) {
  // A bundle with less diffusion counts as sharp, whatever tau is.
  constexpr double MIN_DIFFUSION = 1e-6;
  Regularization regularization = regularization_of(settings, sample);
  constexpr uint32_t PATH_TRACING = TECHNIQUE_HIT | TECHNIQUE_NEE;
  if (!regularization.has_diffusion || (settings.techniques & ~PATH_TRACING) != 0) return regularization;
  const double sigma = diffusion(footprint);
  regularization.has_diffusion = false;  // no levels: the vertex has a tau of its own
  regularization.has_bundle = true;
  regularization.tau /= std::max(sigma, MIN_DIFFUSION);
  if (sigma <= MIN_DIFFUSION) regularization.is_on = false;
  return regularization;
}

dvec4 random_block(const Settings& settings, uint32_t stream, uint32_t sample, uint32_t block) {
  const RandomBits bits = settings.sampler == SAMPLER_SOBOL ? sobol_bits(settings.seed, stream, sample, block)
                                                            : hash_bits(settings.seed, stream, sample, block);
  Rounding rounding(settings.rounding_pattern, stream, sample, block);
  dvec4 numbers;
  for (int i = 0; i < 4; ++i)
    numbers[i] = std::clamp(rounding.moved(unit_interval(bits[static_cast<size_t>(i)]), UNIT_ROUNDOFF), 0.0,
                            1 - UNIT_ROUNDOFF);
  return numbers;
}

VirtualTries virtual_tries(const Stream& stream, uint32_t end, size_t camera_edges, size_t light_edges,
                           uint32_t light_path) {
  const RandomBits base =
      hash_bits(stream.seed, stream.index, stream.sample, DIMENSION_BLOCK_VIRTUAL_MERGE + end);
  // PCG4D of (x, y, z, w): its arguments are w, x, y, z.
  const RandomBits key = hash_bits(base[3], base[0] + static_cast<uint32_t>(camera_edges),
                                   base[1] + static_cast<uint32_t>(light_edges),
                                   base[2] + (light_path & LIGHT_VERTEX_STREAM_MASK));
  VirtualTries tries;
  tries.is_from_light = end == VIRTUAL_MERGE_AT_LIGHT;
  for (uint32_t i = 0; i < 2 * VIRTUAL_MERGE_TRIES; ++i) {
    const RandomBits bits = hash_bits(key[3] + i, key[0] + i, key[1] + i, key[2] + i);
    const auto event =
        (static_cast<float>(unit_interval(bits[0])) + static_cast<float>(i % VIRTUAL_MERGE_TRIES)) /
        static_cast<float>(VIRTUAL_MERGE_TRIES);
    std::vector<glm::dvec3>& numbers = i < VIRTUAL_MERGE_TRIES ? tries.of_base : tries.of_coat;
    numbers.emplace_back(std::min(double{event}, 1 - UNIT_ROUNDOFF), unit_interval(bits[1]),
                         unit_interval(bits[2]));
  }
  return tries;
}

WalkVertex arrive(const World& world, const Surface& surface, double distance, WalkState& state,
                  double cos_start, bool is_from_camera) {
  WalkVertex vertex{surface, world.bsdf_at(surface, state.place.around, state.wavelength), -state.direction};
  const double cos_arrival = std::abs(dot(state.direction, surface.geometric_normal));
  vertex.edge.distance = distance;
  vertex.edge.cos_light_end = is_from_camera ? cos_arrival : cos_start;
  vertex.edge.cos_camera_end = is_from_camera ? cos_start : cos_arrival;
  vertex.edge.transmittance = world.transmittance(state.medium, distance - state.cut) *
                              world.transmittance(state.cut_medium, state.cut);
  state.cut = 0;
  vertex.medium = state.medium;
  vertex.around = state.place.around;
  vertex.survival = state.survival;
  state.throughput *= vertex.edge.transmittance;
  vertex.throughput = state.throughput;
  return vertex;
}

bool end_by_range(const World& world, const LightPoint& point, WalkVertex& vertex, WalkState& state) {
  const double share = range_share(world, point, vertex.edge.distance);
  vertex.edge.transmittance *= share;
  vertex.throughput *= share;
  state.throughput *= share;
  return share > 0;
}

bool scatter_from_camera(const World& world, WalkVertex& vertex, WalkState& state, uint32_t bounce,
                         const dvec4& u, const Regularization& regularization) {
  const auto survival = [&](const dvec3& weight, const BsdfSample& step) {
    if (step.is_transmitted && vertex.bsdf.parameters().is_volume) {
      const double eta = index_ahead(vertex);
      state.eta_scale *= eta * eta;
    }
    // A guide that is sure of a direction makes throughput small, and nothing that follows less bright.
    state.eta_scale *= vertex.scattering.guiding;
    return bounce < ROULETTE_FIRST_BOUNCE
               ? 1.0
               : std::min(1.0, largest_component(state.throughput * weight) * state.eta_scale);
  };
  return continue_walk(world, vertex, state, u, TransportMode::Radiance, regularization, survival);
}

bool scatter_from_light(const World& world, WalkVertex& vertex, WalkState& state, uint32_t bounce,
                        const dvec4& u, const Regularization& regularization) {
  const auto survival = [&](const dvec3& weight, const BsdfSample&) {
    return bounce < ROULETTE_FIRST_BOUNCE ? 1.0 : std::min(1.0, largest_component(weight));
  };
  return continue_walk(world, vertex, state, u, TransportMode::Importance, regularization, survival);
}

CameraSubpath walk_from_camera(const World& world, const Camera& camera, const Settings& settings,
                               uint32_t pixel, uint32_t sample, const std::vector<GivenHit>* given) {
  const Walk walk{world, settings, pixel, sample, given};
  const dvec4 u_camera = walk.block(DIMENSION_BLOCK_CAMERA);
  const dvec2 centre = dvec2(pixel % camera.width(), pixel / camera.width()) + 0.5;

  CameraSubpath subpath;
  subpath.stream = {settings.seed, pixel, sample};
  subpath.longest_edge = 2 * world.radius();
  subpath.bound = camera_bound(camera, subpath.longest_edge);
  subpath.film = centre + settings.filter.sample({u_camera.x, u_camera.y});
  subpath.ray = camera.ray(subpath.film, {u_camera.z, u_camera.w});
  subpath.density = camera.density(subpath.ray.direction);

  WalkState state{subpath.ray.origin, subpath.ray.direction};
  if (world.has_dispersion()) state.wavelength = wavelength_of(settings.seed, sample);
  subpath.response = state.wavelength.response;
  state.place.around = world.media_of_camera(settings.camera, subpath.ray.start());
  state.medium = world.medium_of(state.place.around);
  if (world.has_contacts()) state.cut = subpath.ray.nearest;
  state.cut_medium = world.medium_of_lens(settings.camera);
  Footprint footprint = footprint_at_lens(camera);
  Ray ray{state.position, state.direction, subpath.ray.nearest, subpath.ray.farthest};
  Surface start_surface;
  const Surface* start = nullptr;
  double cos_start = 1;
  for (uint32_t bounce = 0; bounce < settings.max_depth; ++bounce) {
    const std::optional<WalkVertex> vertex = walk.next_vertex(bounce, ray, start, state, cos_start, true);
    if (!vertex) {
      subpath.escape = Escape{state.direction, cos_start, state.survival};
      break;
    }
    subpath.vertices.push_back(*vertex);
    WalkVertex& reached = subpath.vertices.back();
    footprint = travelled(footprint, reached.edge.distance);
    reached.regularization = regularization_at(settings, sample, footprint);
    if (bounce + 2 > settings.max_depth) break;
    const dvec4 u =
        walk.block(DIMENSION_BLOCKS_FIRST + bounce * DIMENSION_BLOCKS_PER_BOUNCE + DIMENSION_BLOCK_BSDF);
    if (!scatter_from_camera(world, reached, state, bounce, u, reached.regularization)) break;
    const double side = dot(reached.w_back, reached.surface.geometric_normal) < 0 ? -1 : 1;
    footprint = scattered(footprint, reached.sample, side * world.mean_curvature(reached.surface.triangle),
                          index_ahead(reached));
    cos_start = std::abs(dot(state.direction, reached.surface.geometric_normal));
    ray = world.ray_from(reached.surface, state.direction, leaves_beyond(reached, TransportMode::Radiance));
    start_surface = reached.surface;
    start = &start_surface;
  }
  return subpath;
}

LightSubpath walk_from_light(const World& world, const Settings& settings, uint32_t index, uint32_t iteration,
                             const std::vector<GivenHit>* given) {
  const Walk walk{world, settings, index, iteration, given};
  const dvec4 u_point = walk.block(DIMENSION_BLOCK_EMISSION);
  const dvec4 u_direction = walk.block(DIMENSION_BLOCK_EMISSION_DIRECTION);

  LightSubpath subpath;
  subpath.stream = {settings.seed, index, iteration};
  subpath.regularization = regularization_of(settings, iteration);
  const LightStart start_of_path = start_light_path(world, u_point, {u_direction.x, u_direction.y});
  subpath.point = start_of_path.point;
  subpath.ray = start_of_path.ray;
  subpath.end = light_end(world, subpath.point, subpath.ray.direction, subpath.ray.origin);
  if (!(largest_component(subpath.end.emitted) > 0)) return subpath;

  WalkState state{subpath.ray.origin, subpath.ray.direction};
  if (world.has_dispersion()) state.wavelength = wavelength_of(settings.seed, iteration);
  subpath.response = state.wavelength.response;
  const bool is_surface = subpath.point.is_triangle();
  Ray ray = is_surface ? world.ray_from(subpath.point.surface, state.direction)
                       : Ray{state.position, state.direction};
  Surface start_surface = subpath.point.surface;
  const Surface* start = is_surface ? &start_surface : nullptr;
  state.place = place_of_light(world, subpath.point, ray);
  state.medium = world.medium_of(state.place.around);
  double cos_start = is_surface ? std::abs(dot(state.direction, subpath.point.surface.geometric_normal)) : 1;
  state.throughput = subpath.end.emitted * cos_start / (subpath.end.point_pdf * subpath.end.density.value);
  for (uint32_t bounce = 0; bounce + 1 < settings.max_depth; ++bounce) {
    const std::optional<WalkVertex> vertex = walk.next_vertex(bounce, ray, start, state, cos_start, false);
    if (!vertex) break;
    subpath.vertices.push_back(*vertex);
    WalkVertex& reached = subpath.vertices.back();
    if (bounce == 0 && !end_by_range(world, subpath.point, reached, state)) {
      subpath.vertices.pop_back();
      break;
    }
    if (bounce == 0)
      subpath.end.connect_pdf = connection_pdf(world, subpath.point, reached.surface, reached.w_back);
    if (bounce + 2 == settings.max_depth) break;
    const dvec4 u = walk.block(DIMENSION_BLOCK_LIGHT_BSDF + bounce);
    if (!scatter_from_light(world, reached, state, bounce, u, subpath.regularization)) break;
    cos_start = std::abs(dot(state.direction, reached.surface.geometric_normal));
    ray = world.ray_from(reached.surface, state.direction);
    start_surface = reached.surface;
    start = &start_surface;
  }
  return subpath;
}

}  // namespace regulus::reference
