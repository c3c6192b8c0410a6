#include "reference/estimator.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "reference/light_choice.hpp"
#include "reference/rng.hpp"

namespace regulus::reference {

using glm::dvec2;
using glm::dvec3;
using namespace interface;

namespace {

/// Numbers for the lens point of a splat from the light walk's vertex after `edges` edges.
dvec2 lens_sample(const Settings& settings, uint32_t index, uint32_t iteration, size_t edges) {
  if (edges == 0) {
    const glm::dvec4 u = random_block(settings, index, iteration, DIMENSION_BLOCK_EMISSION_DIRECTION);
    return {u.z, u.w};
  }
  const auto block = DIMENSION_BLOCK_SPLAT + static_cast<uint32_t>(edges) - 1;
  const glm::dvec4 u = random_block(settings, index, iteration, block);
  return {u.x, u.y};
}

/// Contributes the path with its value and weight of one system of weights, times `share`.
void contribute_share(SampledPath sampled, const TechniqueSet& set, double share,
                      const ContributionSink& sink) {
  if (!(share > 0)) return;
  Contribution contribution;
  contribution.techniques = list_techniques(sampled.path, set);
  contribution.sampled = std::move(sampled);
  const SampledPath& found = contribution.sampled;
  for (const Technique& used : contribution.techniques) {
    if (used.kind != found.technique || used.vertex != found.vertex) continue;
    contribution.weight = share * mis_weight(contribution.techniques, used);
    contribution.unweighted = unweighted_contribution(found.path, used) / found.survival;
    sink(contribution);
  }
}

}  // namespace

void contribute(SampledPath sampled, const TechniqueSet& set, const ContributionSink& sink) {
  // A path of one edge has nothing to regularize, and only one technique.
  const double share = sampled.path.length() == 1 ? 1 : regularized_share(sampled.path, set);
  if (share < 1) {
    SampledPath plain = sampled;
    for (VertexScattering& vertex : plain.path.vertices) vertex.raised.reset();
    TechniqueSet once = set;
    once.is_both = false;
    contribute_share(std::move(plain), once, 1 - share, sink);
  }
  contribute_share(std::move(sampled), set, share, sink);
}

Tracing play_shadow_roulette(const Settings& settings, const dvec3& value, const ShadowRay& ray) {
  const double ratio = std::max({value.r, value.g, value.b}) / settings.shadow_roulette;
  if (!(ratio < 1)) return {};
  constexpr double STEPS = SHADOW_ROULETTE_STEPS;
  const double probability = std::max(std::ceil(ratio * STEPS), double{SHADOW_ROULETTE_LEAST}) / STEPS;
  const RandomBits base = hash_bits(settings.seed, ray.stream, ray.sample, DIMENSION_BLOCK_SHADOW_ROULETTE);
  // PCG4D of (x, y, z, w): its arguments are w, x, y, z.
  const RandomBits bits = hash_bits(base[3], base[0] + static_cast<uint32_t>(ray.camera_edges),
                                    base[1] + static_cast<uint32_t>(ray.light_edges),
                                    base[2] + (ray.light_path & LIGHT_VERTEX_STREAM_MASK));
  return {probability, unit_interval(bits[0]) < probability};
}

LightCache::LightCache(std::vector<LightSubpath> subpaths, double radius, bool is_regularized)
    : subpaths_(std::move(subpaths)), radius_(radius) {
  for (uint32_t i = 0; i < subpaths_.size(); ++i)
    for (auto m = static_cast<uint32_t>(subpaths_[i].vertices.size()); m >= 1; --m) {
      const WalkVertex& vertex = subpaths_[i].vertices[m - 1];
      // The side is that of the surface itself: a merge may see what the shading normal does not.
      const dvec3 side(0, 0, dot(vertex.w_back, vertex.surface.geometric_normal));
      if (!is_regularized && !vertex.bsdf.has_finite_lobe(side)) continue;
      numbered_.push_back({i, m});
      if (radius > 0) cells_[key_of(cell_of(vertex.surface.position))].push_back({i, m});
    }
}

glm::ivec3 LightCache::cell_of(const dvec3& point) const {
  return glm::ivec3(glm::floor(point / radius_));
}

uint64_t LightCache::key_of(const glm::ivec3& cell) {
  // 21 bits an axis: far cells may share a key, which costs a distance test and nothing else.
  const auto bits = [](int coordinate) { return static_cast<uint64_t>(coordinate) & 0x1FFFFF; };
  return bits(cell.x) | bits(cell.y) << 21 | bits(cell.z) << 42;
}

std::vector<LightCache::Reference> LightCache::near(const dvec3& point) const {
  std::vector<Reference> found;
  const glm::ivec3 center = cell_of(point);
  for (int i = 0; i < 27; ++i) {
    const auto cell = cells_.find(key_of(center + glm::ivec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1)));
    if (cell == cells_.end()) continue;
    for (const Reference& reference : cell->second) {
      const dvec3& position = subpaths_[reference.subpath].vertices[reference.edges - 1].surface.position;
      if (length(position - point) < radius_) found.push_back(reference);
    }
  }
  std::sort(found.begin(), found.end(), [](const Reference& a, const Reference& b) {
    return std::pair(a.subpath, a.edges) < std::pair(b.subpath, b.edges);
  });
  return found;
}

Estimator::Estimator(const World& world, const Camera& camera, const Settings& settings)
    : world_(world), camera_(camera), settings_(settings) {
  if (settings.cache_connections == 0 || (settings.techniques & TECHNIQUE_CONNECT) == 0 ||
      !needs_light_subpaths())
    return;
  if (settings.expected_light_vertices != 0) {
    expected_cache_ = settings.expected_light_vertices;
    return;
  }
  // The size of the cache is not known before it is filled, but weights have to agree on a sample count from
  // the start. Any count will do that is the same for all; that of the first iteration is a good guess.
  Settings exact = settings;
  exact.rounding_pattern = 0;
  std::vector<LightSubpath> subpaths;
  for (uint32_t i = 0; i < settings.paths_per_iteration(); ++i)
    subpaths.push_back(walk_from_light(world, exact, i, 0));
  expected_cache_ = std::max(1.0, static_cast<double>(light_cache(std::move(subpaths), 0).size()));
}

LightCache Estimator::light_cache(std::vector<LightSubpath> subpaths, uint32_t sample) const {
  const bool has_merges = (settings_.techniques & TECHNIQUE_MERGE) != 0;
  return {std::move(subpaths), has_merges ? merge_radius(sample) : 0,
          regularization_of(settings_, sample).is_on};
}

double Estimator::merge_radius(uint32_t sample) const {
  return settings_.merge_radius * std::pow(sample + 1.0, -settings_.merge_reduction);
}

TechniqueSet Estimator::techniques(uint32_t sample) const {
  const double radius = merge_radius(sample);
  const double light_paths = settings_.paths_per_iteration();
  const uint32_t drawn = settings_.cache_connections;
  TechniqueSet set{settings_.techniques, light_paths, drawn == 0 ? 1 : drawn * light_paths / expected_cache_,
                   std::numbers::pi * radius * radius};
  const Regularization regularization = regularization_of(settings_, sample);
  if (!regularization.is_on) return set;
  set.is_both = (settings_.regularization & REGULARIZATION_BOTH) != 0;
  set.quality = settings_.sampler_quality;
  // Where alpha_tau shrinks by the schedule, tau grows like the bound: like 1 / alpha_tau^2, under `smith` 1
  // / alpha_tau^4.
  const bool is_smith = settings_.bound == BOUND_SMITH && settings_.shadowing != SHADOWING_V_CAVITY;
  // A raised lobe keeps its light, so it exceeds tau by what it would lose.
  const double alpha = alpha_at_normal(regularization, settings_.ndf, settings_.shadowing);
  const double kept = world_.energy_tables().reflected(1, std::sqrt(alpha));
  set.enough_quality =
      std::pow(regularization.tau / (std::pow(regularization.alpha_scale, is_smith ? 4 : 2) * kept), 2);
  return set;
}

bool Estimator::needs_light_subpaths() const {
  return (settings_.techniques & (TECHNIQUE_SPLAT | TECHNIQUE_CONNECT | TECHNIQUE_MERGE)) != 0 &&
         !world_.scene().lights.empty();
}

void Estimator::emit(std::optional<SampledPath> sampled, const TechniqueSet& set,
                     const ContributionSink& sink) const {
  if (sampled) contribute(std::move(*sampled), set, sink);
}

/// A path that is there only if a shadow ray is free. (That it is, has been found out already: the reference
/// saves nothing by roulette.)
void Estimator::emit_traced(std::optional<SampledPath> sampled, const ShadowRay& ray, const TechniqueSet& set,
                            const ContributionSink& sink) const {
  if (!sampled) return;
  if (!(settings_.shadow_roulette > 0)) return contribute(std::move(*sampled), set, sink);
  std::vector<Contribution> all;  // of both copies of the technique, which share the ray
  dvec3 value(0);
  contribute(std::move(*sampled), set, [&](const Contribution& found) {
    all.push_back(found);
    value += found.value();
  });
  const Tracing tracing = play_shadow_roulette(settings_, value, ray);
  if (!tracing.is_traced) return;
  for (Contribution& found : all) {
    found.unweighted /= tracing.probability;
    sink(found);
  }
}

/// The camera walk's vertex after `edges` edges to those of its own light path, or to some drawn from all.
void Estimator::connect(const CameraSubpath& camera, size_t edges, uint32_t pixel, uint32_t sample,
                        const LightCache& cache, const TechniqueSet& set,
                        const ContributionSink& sink) const {
  const auto connect_to = [&](const LightSubpath& light, size_t m, const ContributionSink& to) {
    if (edges + m + 1 <= settings_.max_depth)
      emit_traced(connect_vertices(world_, light, m, camera, edges),
                  {pixel, sample, edges, m, light.stream.index}, set, to);
  };
  if (settings_.cache_connections == 0) {
    const LightSubpath& light = cache.subpaths()[pixel % cache.subpaths().size()];
    for (size_t m = 1; m <= light.vertices.size(); ++m) connect_to(light, m, sink);
    return;
  }
  if (cache.size() == 0) return;
  // If the cache has another size than expected, weights assume another number of samples than there is.
  const double scale = cache.size() / expected_cache_;
  const ContributionSink scaled = [&](Contribution found) {
    found.unweighted *= scale;
    sink(found);
  };
  for (uint32_t k = 0; k < settings_.cache_connections; ++k) {
    const uint32_t block = DIMENSION_BLOCK_CACHE + static_cast<uint32_t>(edges - 1) * 256 + k / 4;
    const double u = random_block(settings_, pixel, sample, block)[static_cast<int>(k % 4)];
    // In single precision, like every decision.
    const auto number = static_cast<uint32_t>(static_cast<float>(u) * static_cast<float>(cache.size()));
    const auto [subpath, m] = cache.numbered(std::min(number, cache.size() - 1));
    connect_to(cache.subpaths()[subpath], m, scaled);
  }
}

void Estimator::camera_sample(uint32_t pixel, uint32_t sample, const LightCache* cache,
                              const ContributionSink& sink) const {
  const TechniqueSet set = techniques(sample);
  const bool has_lights = !world_.scene().lights.empty();
  const CameraSubpath camera = walk_from_camera(world_, camera_, settings_, pixel, sample);
  for (size_t edges = 1; edges <= camera.vertices.size(); ++edges) {
    if ((set.bits & TECHNIQUE_HIT) != 0) emit(hit_light(world_, camera, edges), set, sink);
    const size_t light_edges_left = settings_.max_depth - edges;  // of a connection, plus its own
    if ((set.bits & TECHNIQUE_NEE) != 0 && has_lights && light_edges_left >= 1) {
      const auto bounce = static_cast<uint32_t>(edges - 1);
      const glm::dvec4 u =
          random_block(settings_, pixel, sample,
                       DIMENSION_BLOCKS_FIRST + bounce * DIMENSION_BLOCKS_PER_BOUNCE + DIMENSION_BLOCK_LIGHT);
      const WalkVertex& vertex = camera.vertices[edges - 1];
      const std::optional<uint32_t> light =
          choose_light(world_, receiver_at(world_, vertex.surface, vertex.w_back), {u.x, u.y});
      if (light)
        emit_traced(connect_to_light(world_, sample_light_point(world_, *light, {u.z, u.w}), camera, edges),
                    {pixel, sample, edges, 0, 0}, set, sink);
    }
    if (cache == nullptr) continue;
    if ((set.bits & TECHNIQUE_CONNECT) != 0) connect(camera, edges, pixel, sample, *cache, set, sink);
    if ((set.bits & TECHNIQUE_MERGE) != 0) {
      for (const auto [subpath, m] : cache->near(camera.vertices[edges - 1].surface.position))
        if (m <= light_edges_left)
          emit(merge_vertices(cache->subpaths()[subpath], m, camera, edges), set, sink);
    }
  }
  if ((set.bits & TECHNIQUE_HIT) != 0) emit(hit_environment(world_, camera), set, sink);
}

void Estimator::light_sample(const LightSubpath& light, uint32_t index, uint32_t sample,
                             const ContributionSink& sink) const {
  if ((settings_.techniques & TECHNIQUE_SPLAT) == 0) return;
  const TechniqueSet set = techniques(sample);
  for (size_t edges = 0; edges <= light.vertices.size() && edges + 1 <= settings_.max_depth; ++edges) {
    const dvec2 u_lens = lens_sample(settings_, index, sample, edges);
    std::optional<SampledPath> found =
        connect_to_lens(world_, camera_, world_.medium_of_lens(settings_.camera), light, edges, u_lens);
    // Emitters that the camera sees are shown as they are.
    if (edges == 0)
      emit(std::move(found), set, sink);
    else
      emit_traced(std::move(found), {index, sample, 0, edges, 0}, set, sink);
  }
}

}  // namespace regulus::reference
