// Rays for `regulus bench kernels`, and Embree's answers to them: the yardstick.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "bench/bench_interface.h"
#include "cli/bench_geometry.hpp"
#include "interface/bvh.h"

namespace regulus::cli {

/// Embree's own structure over the triangles of a scene, with its default settings.
class EmbreeScene {
 public:
  /// @throws regulus::Error (Failed) if memory runs out.
  explicit EmbreeScene(std::span<const bvh::InputTriangle> triangles);
  ~EmbreeScene();
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  /// One ray per call (rtcIntersect1), on all cores. Hit::triangle is the index of the input triangle.
  void trace_closest(std::span<const interface::BenchRay> rays, std::span<interface::Hit> hits) const;
  /// One ray per call (rtcOccluded1), on all cores; 1 where something is hit.
  void trace_any(std::span<const interface::BenchRay> rays, std::span<uint32_t> is_hit) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The kinds of rays that are measured, each in scattered but repeatable order of directions.
struct BenchRays {
  std::vector<interface::BenchRay> primary;  ///< one per pixel, row by row
  std::vector<interface::BenchRay>
      diffuse;                              ///< from primary hits, cosine-distributed about the facing normal
  std::vector<interface::BenchRay> shadow;  ///< from primary hits to the light
};

/// Rays of a film of width x height pixels. Where a primary ray misses, there is no diffuse or shadow ray.
BenchRays make_bench_rays(const BenchScene& scene, const EmbreeScene& embree, uint32_t width,
                          uint32_t height);

}  // namespace regulus::cli
