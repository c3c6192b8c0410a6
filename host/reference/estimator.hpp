// The estimators: every path that one camera walk and the iteration's light walks find, each with its full
// contribution f_k / (n p) and its weight by definition. Brute force, for any set of techniques.
#pragma once

#include <functional>
#include <optional>
#include <unordered_map>
#include <vector>

#include "reference/subpaths.hpp"
#include "reference/techniques.hpp"

namespace regulus::reference {

/// A path that was found, and what it is worth.
struct Contribution {
  SampledPath sampled;
  std::vector<Technique> techniques;  ///< all that can find the path
  double weight = 0;                  ///< of the one that did
  glm::dvec3 unweighted{0};           ///< f_k / (n p), roulette divided out

  glm::dvec3 value() const { return weight * unweighted; }
};

using ContributionSink = std::function<void(const Contribution&)>;

/// A shadow ray among all of a render: the walk that makes it (pixel and sample, or light path and
/// iteration), the edges of its path on both sides of it, 0 for a light point or the lens, and of a
/// connection the light path.
struct ShadowRay {
  uint32_t stream = 0, sample = 0;
  size_t camera_edges = 0, light_edges = 0;
  uint32_t light_path = 0;
};

/// Whether roulette spares a shadow ray, and how probable that was.
struct Tracing {
  double probability = 1;
  bool is_traced = true;
};

/// Roulette of a shadow ray that would carry `value` (docs/mathematics.md 17).
/// @pre settings.shadow_roulette is not 0
Tracing play_shadow_roulette(const Settings& settings, const glm::dvec3& value, const ShadowRay& ray);

/// All that a found path contributes by the technique that found it: once, or twice where that exists with
/// and without regularization, or where sampler quality gives it a share of both.
void contribute(SampledPath sampled, const TechniqueSet& set, const ContributionSink& sink);

/// Light walks of one iteration, and their vertices by place.
class LightCache {
 public:
  /// `radius` > 0: vertices can be looked up by place. `is_regularized`: surfaces without any lobe but deltas
  /// can be connected, too.
  LightCache(std::vector<LightSubpath> subpaths, double radius, bool is_regularized = false);

  struct Reference {
    uint32_t subpath;
    uint32_t edges;  ///< the vertex is subpaths()[subpath].vertices[edges - 1]
  };

  const std::vector<LightSubpath>& subpaths() const { return subpaths_; }

  /// Vertices within the radius of a point, in the order of their walks.
  std::vector<Reference> near(const glm::dvec3& point) const;

  /// Number of vertices that can be connected, and the one of that number: walk by walk, the last one of each
  /// first.
  uint32_t size() const { return static_cast<uint32_t>(numbered_.size()); }
  Reference numbered(uint32_t number) const { return numbered_[number]; }

 private:
  glm::ivec3 cell_of(const glm::dvec3& point) const;
  static uint64_t key_of(const glm::ivec3& cell);

  std::vector<LightSubpath> subpaths_;
  double radius_;
  std::vector<Reference> numbered_;
  std::unordered_map<uint64_t, std::vector<Reference>> cells_;
};

/// The paths of one sample of a pixel or of one light walk.
class Estimator {
 public:
  Estimator(const World& world, const Camera& camera, const Settings& settings);

  /// The light walks of the iteration of a sample, for camera_sample().
  LightCache light_cache(std::vector<LightSubpath> subpaths, uint32_t sample) const;

  /// Radius of merges in the iteration of a sample: merge_radius (i + 1)^-merge_reduction.
  double merge_radius(uint32_t sample) const;

  /// The techniques with the sample counts of that iteration.
  TechniqueSet techniques(uint32_t sample) const;

  /// Hits, light samples, connections and merges of a camera walk. `cache` may be null if nothing needs it.
  void camera_sample(uint32_t pixel, uint32_t sample, const LightCache* cache,
                     const ContributionSink& sink) const;

  /// Splats of the light walk `index` of the iteration of `sample`.
  void light_sample(const LightSubpath& light, uint32_t index, uint32_t sample,
                    const ContributionSink& sink) const;

  /// True if some technique needs paths from lights.
  bool needs_light_subpaths() const;

 private:
  void emit(std::optional<SampledPath> sampled, const TechniqueSet& set, const ContributionSink& sink) const;
  void emit_traced(std::optional<SampledPath> sampled, const ShadowRay& ray, const TechniqueSet& set,
                   const ContributionSink& sink) const;
  void connect(const CameraSubpath& camera, size_t edges, uint32_t pixel, uint32_t sample,
               const LightCache& cache, const TechniqueSet& set, const ContributionSink& sink) const;

  const World& world_;
  const Camera& camera_;
  const Settings& settings_;
  double expected_cache_ = 1;  // light vertices of the very first iteration
};

}  // namespace regulus::reference
