// Ray queries on the device over a set of triangles, and the exact geometry they are held against.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bench/bench_interface.h"
#include "bvh/bvh.hpp"
#include "gpu/gpu.hpp"
#include "interface/wavefront.h"
#include "render/scene_structure.hpp"
#include "support/random.hpp"

namespace regulus::test {

using Triangles = std::vector<bvh::InputTriangle>;
using Rays = std::vector<interface::BenchRay>;

inline constexpr float UNBOUNDED = 3.0e38f;

/// Ray with a unit direction.
interface::BenchRay make_ray(glm::dvec3 origin, glm::dvec3 direction, float t_max = UNBOUNDED);

/// A soup in [-1, 1]^3 of triangles of sizes from a hundredth to the whole, some of them slivers.
Triangles make_soup(Random& random, uint32_t count);
/// Rays from around and inside of [-1, 1]^3, a quarter of them along axes or with a zero component.
Rays make_rays(Random& random, uint32_t count);
/// Scales both, then shifts them.
void transform(Triangles& triangles, Rays& rays, double scale, glm::dvec3 shift);

/// Triangles on the device, and queries against them through the kernels of shaders/bench.
class RayQueries {
 public:
  /// `rays`: RAYS_SOFTWARE, or RAYS_HARDWARE on a device that has ray queries.
  explicit RayQueries(const Triangles& triangles, uint32_t rays = interface::RAYS_SOFTWARE);

  /// Hit::triangle is the index of the input triangle.
  std::vector<interface::Hit> closest(const Rays& rays);
  std::vector<bool> any(const Rays& rays);
  /// Rays given up so far.
  uint32_t overruns();
  const bvh::Bvh& bvh() const { return bvh_; }

 private:
  template <typename Result>
  std::vector<Result> run(const std::string& kernel, const Rays& rays);

  uint32_t rays_;
  bvh::Bvh bvh_;
  gpu::Buffer nodes_, triangles_, overruns_;
  render::TriangleStructure structure_;  // with RAYS_HARDWARE
};

/// What double precision says of one ray and one triangle, and how far float arithmetic may deviate from it.
struct ExactHit {
  double t = 0;      ///< along the ray, of the triangle's plane
  double inset = 0;  ///< distance of the ray from the nearest edge, seen along the ray; negative outside
  double inset_error = 0;  ///< what rounding may do to `inset`
  double t_error = 0;      ///< and to t
  bool can_hit() const { return inset >= -inset_error; }
  bool must_hit() const { return inset > inset_error; }
};
ExactHit exact_hit(const bvh::InputTriangle& triangle, const interface::BenchRay& ray);

/// Compares a reported hit with every triangle in `candidates` (indices; all that could matter).
/// @returns an empty string if it is right up to rounding, otherwise what is wrong.
std::string check_hit(const Triangles& triangles, std::span<const uint32_t> candidates,
                      const interface::BenchRay& ray, const interface::Hit& hit);

}  // namespace regulus::test
