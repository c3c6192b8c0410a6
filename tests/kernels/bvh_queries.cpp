#include "bvh_queries.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "interface/wavefront.h"
#include "support/device.hpp"

namespace regulus::bench_shaders {
std::span<const uint32_t> spirv(std::string_view name);
}

namespace regulus::test {

namespace {

constexpr double ROUNDOFF = 0x1p-24;
// Roundings on the way of a vertex coordinate to the sheared frame: difference to the origin, slope of the
// ray, product, difference; a division may take 2.5 ulp (5 roundoffs) on a Vulkan device.
constexpr double VERTEX_ROUNDINGS = 3 + 5;

double cross(glm::dvec2 a, glm::dvec2 b) {
  return a.x * b.y - a.y * b.x;
}

/// Distance of the origin from the segment ab.
double distance_to_segment(glm::dvec2 a, glm::dvec2 b) {
  const glm::dvec2 along = b - a;
  const double length_squared = glm::dot(along, along);
  const double s = length_squared > 0 ? std::clamp(-glm::dot(a, along) / length_squared, 0.0, 1.0) : 0;
  return glm::length(a + s * along);
}

}  // namespace

interface::BenchRay make_ray(glm::dvec3 origin, glm::dvec3 direction, float t_max) {
  return {glm::vec3(origin), t_max, glm::vec3(glm::normalize(direction)), 0};
}

RayQueries::RayQueries(const Triangles& triangles, uint32_t rays)
    : rays_(rays),
      bvh_(bvh::build(triangles)),
      nodes_(gpu::upload_new(*device(), bvh_.nodes, "nodes")),
      triangles_(gpu::upload_new(*device(), bvh_.triangles, "triangles")),
      overruns_(device()->create_buffer(sizeof(uint32_t), "overruns")) {
  if (rays == interface::RAYS_HARDWARE) structure_ = render::TriangleStructure(*device(), bvh_.triangles);
}

template <typename Result>
std::vector<Result> RayQueries::run(const std::string& kernel_name, const Rays& rays) {
  const auto address = [](const gpu::Buffer& buffer) { return interface::device_address(buffer.address()); };
  const bool is_hardware = rays_ == interface::RAYS_HARDWARE;
  const gpu::Kernel kernel =
      is_hardware ? device()->create_kernel({kernel_name, bench_shaders::spirv(kernel_name + ".rays"), {}})
                  : create_batch_kernel(bench_shaders::spirv, kernel_name, {});
  const gpu::Buffer ray_buffer = gpu::upload_new(*device(), rays, "rays");
  const gpu::Buffer results = device()->create_buffer(rays.size() * sizeof(Result), "results");
  const interface::BenchArguments arguments {
    is_hardware ? interface::device_address(structure_.address()) : address(nodes_), address(triangles_),
        address(ray_buffer), address(results), address(overruns_), static_cast<uint32_t>(rays.size())
  };
  gpu::CommandList commands(*device());
  commands.dispatch(kernel, gpu::bytes_of(arguments),
                    (arguments.ray_count + interface::WORKGROUP_SIZE - 1) / interface::WORKGROUP_SIZE);
  gpu::Submission submission = device()->submit(std::move(commands));
  device()->wait(submission);
  return gpu::download_all<Result>(*device(), results, rays.size());
}

std::vector<interface::Hit> RayQueries::closest(const Rays& rays) {
  std::vector<interface::Hit> hits = run<interface::Hit>("bench_closest", rays);
  for (interface::Hit& hit : hits)
    if (hit.triangle != interface::INVALID_INDEX) hit.triangle = bvh_.order.at(hit.triangle);
  return hits;
}

std::vector<bool> RayQueries::any(const Rays& rays) {
  const std::vector<uint32_t> words = run<uint32_t>("bench_any", rays);
  return {words.begin(), words.end()};
}

uint32_t RayQueries::overruns() {
  return gpu::download_all<uint32_t>(*device(), overruns_, 1)[0];
}

ExactHit exact_hit(const bvh::InputTriangle& triangle, const interface::BenchRay& ray) {
  const glm::dvec3 direction(ray.direction);
  const int z = std::abs(direction.x) > std::abs(direction.y)
                    ? (std::abs(direction.x) > std::abs(direction.z) ? 0 : 2)
                    : (std::abs(direction.y) > std::abs(direction.z) ? 1 : 2);
  const int x = (z + 1) % 3;
  const int y = (z + 2) % 3;
  glm::dvec2 p[3];
  double depth[3];
  double reach = 0;
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3 v = glm::dvec3(triangle.vertices[i]) - glm::dvec3(ray.origin);
    depth[i] = v[z] / direction[z];
    p[i] = {v[x] - depth[i] * direction[x], v[y] - depth[i] * direction[y]};
    reach = std::max({reach, std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  }
  const glm::dvec3 edges(cross(p[2], p[1]), cross(p[0], p[2]), cross(p[1], p[0]));
  const double determinant = edges.x + edges.y + edges.z;
  const bool is_inside =
      (edges.x >= 0 && edges.y >= 0 && edges.z >= 0) || (edges.x <= 0 && edges.y <= 0 && edges.z <= 0);
  const double edge_distance = std::min(
      {distance_to_segment(p[0], p[1]), distance_to_segment(p[1], p[2]), distance_to_segment(p[2], p[0])});

  const double size = std::max({glm::length(p[0]), glm::length(p[1]), glm::length(p[2])});
  // Without area, as far as double precision can tell, the signs of the edge functions mean nothing.
  const bool has_area = std::abs(determinant) > 1e-13 * size * size;

  ExactHit exact;
  exact.inset = is_inside && has_area ? edge_distance : -edge_distance;
  // Both sheared coordinates of a vertex may move; edge functions have the exact sign of the moved vertices.
  exact.inset_error = std::sqrt(2.0) * VERTEX_ROUNDINGS * ROUNDOFF * reach;
  const double depth_range =
      std::max({depth[0], depth[1], depth[2]}) - std::min({depth[0], depth[1], depth[2]});
  const double edge_error = 2 * size * exact.inset_error + 3 * ROUNDOFF * size * size;
  exact.t = (edges.x * depth[0] + edges.y * depth[1] + edges.z * depth[2]) / determinant;
  // Rounding of the depths, weights and their sum, relative to the reach; and of the weights through edge
  // errors.
  const double scale = reach / std::abs(direction[z]);
  const double weight_error = 3 * edge_error / std::abs(determinant);
  exact.t_error = (VERTEX_ROUNDINGS + 8) * ROUNDOFF * scale + std::min(weight_error, 1.0) * depth_range;
  if (!std::isfinite(exact.t) || weight_error >= 0.5) {
    // Seen edge-on: any depth of the triangle may be reported.
    exact.t = 0.5 * (std::max({depth[0], depth[1], depth[2]}) + std::min({depth[0], depth[1], depth[2]}));
    exact.t_error = depth_range + (VERTEX_ROUNDINGS + 8) * ROUNDOFF * scale;
  }
  return exact;
}

std::string check_hit(const Triangles& triangles, std::span<const uint32_t> candidates,
                      const interface::BenchRay& ray, const interface::Hit& hit) {
  const bool is_hit = hit.triangle != interface::INVALID_INDEX;
  if (is_hit) {
    const ExactHit exact = exact_hit(triangles.at(hit.triangle), ray);
    if (!exact.can_hit())
      return fmt::format("triangle {} is missed by {:g} (rounding explains {:g})", hit.triangle, -exact.inset,
                         exact.inset_error);
    if (!(std::abs(hit.t - exact.t) <= exact.t_error))
      return fmt::format("t is {:.9g} and should be {:.9g} within {:g}", hit.t, exact.t, exact.t_error);
    if (!(hit.t > 0 && hit.t <= ray.t_max)) return fmt::format("t is {:g}, out of range", hit.t);
    if (!(hit.u >= 0 && hit.v >= 0 && hit.u + hit.v <= 1 + 4 * ROUNDOFF))
      return fmt::format("barycentrics {:.9g}, {:.9g} lie outside", hit.u, hit.v);
  }
  const double t = is_hit ? hit.t : double{ray.t_max};
  for (uint32_t candidate : candidates) {
    const ExactHit exact = exact_hit(triangles[candidate], ray);
    if (exact.must_hit() && exact.t > exact.t_error && exact.t + exact.t_error < t)
      return fmt::format("triangle {} at t = {:.9g} was missed by a hit at {:.9g}", candidate, exact.t, t);
  }
  return {};
}

Triangles make_soup(Random& random, uint32_t count) {
  Triangles triangles;
  for (uint32_t i = 0; i < count; ++i) {
    const glm::dvec3 center = 2.0 * random.cube() - 1.0;
    const double size = random.log_uniform(0.01, 1);
    const glm::dvec3 along = size * random.direction();
    const double width = random.uniform() < 0.3 ? random.log_uniform(1e-6, 1e-2) : 1;
    const glm::dvec3 across = width * size * random.direction();
    triangles.push_back({{glm::vec3(center), glm::vec3(center + along), glm::vec3(center + across)}, i});
  }
  return triangles;
}

Rays make_rays(Random& random, uint32_t count) {
  Rays rays;
  for (uint32_t i = 0; i < count; ++i) {
    const glm::dvec3 origin = random.uniform(0.5, 3) * (2.0 * random.cube() - 1.0);
    glm::dvec3 direction = (2.0 * random.cube() - 1.0) - origin;
    if (i % 8 == 0) direction[static_cast<int>(random.index(3))] = 0;
    if (i % 8 == 1) direction = random.uniform() < 0.5 ? glm::dvec3(0, -1, 0) : glm::dvec3(0, 0, 1);
    const float t_max = i % 4 == 0 ? static_cast<float>(random.uniform(0.1, 3)) : UNBOUNDED;
    rays.push_back(make_ray(origin, direction, t_max));
  }
  return rays;
}

void transform(Triangles& triangles, Rays& rays, double scale, glm::dvec3 shift) {
  const auto moved = [&](glm::vec3 p) { return glm::vec3(scale * glm::dvec3(p) + shift); };
  for (bvh::InputTriangle& triangle : triangles)
    for (glm::vec3& vertex : triangle.vertices) vertex = moved(vertex);
  for (interface::BenchRay& ray : rays) {
    ray.origin = moved(ray.origin);
    if (ray.t_max < UNBOUNDED) ray.t_max *= static_cast<float>(scale);
  }
}

}  // namespace regulus::test
