// Rays against triangles: the device's traversal and the reference's against planes intersected in extended
// precision, and whether rays slip between the triangles of a closed surface.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "bench/bench_interface.h"
#include "bvh/bvh.hpp"
#include "reference/traversal.hpp"
#include "stability/batch.hpp"
#include "stability/families.hpp"

namespace regulus::stability {

using glm::dvec3;
using glm::vec3;
using namespace interface;

namespace {

using Vertices = std::array<vec3, 3>;

/// Triangles, and rays of which each has a triangle to meet.
struct Field {
  std::vector<bvh::InputTriangle> triangles;
  std::vector<BenchRay> rays;
  std::vector<uint32_t> targets;  ///< of each ray; copies in one place have its tag
};

/// A tree on the device.
class Tree {
 public:
  Tree(gpu::Device& device, const std::vector<bvh::InputTriangle>& triangles)
      : device_(device),
        bvh_(bvh::build(triangles)),
        nodes_(gpu::upload_new(device, bvh_.nodes, "nodes")),
        triangles_(gpu::upload_new(device, bvh_.triangles, "triangles")),
        overruns_(device.create_buffer(sizeof(uint32_t), "overruns")) {}

  std::vector<Hit> trace(const gpu::Kernel& kernel, const std::vector<BenchRay>& rays) {
    const gpu::Buffer in = gpu::upload_new(device_, rays, "rays");
    const gpu::Buffer out = device_.create_buffer(rays.size() * sizeof(Hit), "hits");
    const BenchArguments arguments{device_address(nodes_.address()),    device_address(triangles_.address()),
                                   device_address(in.address()),        device_address(out.address()),
                                   device_address(overruns_.address()), static_cast<uint32_t>(rays.size())};
    dispatch_and_wait(device_, kernel, gpu::bytes_of(arguments), rays.size());
    return gpu::download_all<Hit>(device_, out, rays.size());
  }

  const bvh::Bvh& bvh() const { return bvh_; }

 private:
  gpu::Device& device_;
  bvh::Bvh bvh_;
  gpu::Buffer nodes_, triangles_, overruns_;
};

double uniform(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1p-53;
}

dvec3 uniform_direction(std::mt19937_64& random) {
  const double z = 2 * uniform(random) - 1;
  const double phi = 2 * std::numbers::pi * uniform(random);
  return {std::sqrt(1 - z * z) * std::cos(phi), std::sqrt(1 - z * z) * std::sin(phi), z};
}

/// How the triangles of one point of a sweep lie.
struct FieldKind {
  double scale = 1;      ///< of everything, m
  double offset = 0;     ///< of everything from the origin, in scales
  double aspect = 1;     ///< length over width of a triangle
  double elevation = 0;  ///< of rays above their triangle, rad; 0: any
  double tilt = -1;      ///< slope of rays off an axis; negative: any direction
  double stretch = 1;    ///< along x; along z it is as much less, and mirrored, if it is not 1
  int copies = 1;        ///< of each triangle, in one place
};

/// Triangles far enough from each other that a ray to one meets it first: rays come from nearby.
Field make_field(const FieldKind& kind, int count, uint64_t seed) {
  std::mt19937_64 random(seed);
  Field field;
  const int row = static_cast<int>(std::ceil(std::cbrt(count)));
  for (int i = 0; i < count; ++i) {
    const dvec3 centre = 8.0 * dvec3(i % row, i / row % row, i / row / row) + kind.offset;
    const dvec3 along = uniform_direction(random);
    const dvec3 across = normalize(cross(along, uniform_direction(random)));
    const dvec3 normal = cross(along, across);
    const std::array<dvec3, 3> corners = {centre + along, centre - 0.5 * along + 0.8 * across / kind.aspect,
                                          centre - 0.5 * along - 0.8 * across / kind.aspect};
    const dvec3 stretch(kind.scale * kind.stretch, kind.scale,
                        kind.stretch == 1 ? kind.scale : -kind.scale / kind.stretch);
    bvh::InputTriangle triangle;
    triangle.tag = static_cast<uint32_t>(i);
    for (size_t k = 0; k < 3; ++k) triangle.vertices[k] = vec3(stretch * corners[k]);
    // Well inside: rounding must not decide whether it is met.
    const double u = 0.2 + 0.4 * uniform(random);
    const double v = 0.2 + (0.6 - u) * uniform(random);
    const dvec3 target = (1 - u - v) * corners[0] + u * corners[1] + v * corners[2];
    dvec3 direction = uniform_direction(random);
    if (kind.elevation > 0) {
      const double phi = 2 * std::numbers::pi * uniform(random);
      direction = std::cos(kind.elevation) * (std::cos(phi) * along + std::sin(phi) * across) -
                  std::sin(kind.elevation) * normal;
    }
    if (kind.tilt >= 0) {
      direction = dvec3(kind.tilt, kind.tilt, kind.tilt);
      direction[i % 3] = i % 2 == 0 ? 1 : -1;
    }
    direction = stretch * normalize(direction);
    const vec3 rounded = vec3(normalize(direction));
    const dvec3 origin = stretch * target - (0.5 + uniform(random)) * length(direction) * dvec3(rounded);
    for (int copy = 0; copy < kind.copies; ++copy) field.triangles.push_back(triangle);
    field.rays.push_back({vec3(origin), std::numeric_limits<float>::infinity(), rounded, 0});
    field.targets.push_back(static_cast<uint32_t>(field.triangles.size() - 1));
  }
  return field;
}

using Numbers = std::array<Exact, 15>;  // three vertices, origin, direction

Numbers numbers_of(const Vertices& vertices, const BenchRay& ray) {
  Numbers numbers{};
  for (size_t k = 0; k < 3; ++k)
    for (int axis = 0; axis < 3; ++axis) numbers[3 * k + axis] = vertices[k][axis];
  for (int axis = 0; axis < 3; ++axis) {
    numbers[9 + axis] = ray.origin[axis];
    numbers[12 + axis] = ray.direction[axis];
  }
  return numbers;
}

/// Where a ray meets a triangle's plane; p = (1 - u - v) p0 + u p1 + v p2.
struct PlaneHit {
  Exact distance, u, v;

  /// Least barycentric coordinate: negative outside the triangle.
  Exact inside() const { return std::min({u, v, 1 - u - v}); }
};

PlaneHit plane_hit(const Numbers& n) {
  using Vector = glm::vec<3, Exact>;
  const auto at = [&](size_t k) { return Vector(n[3 * k], n[3 * k + 1], n[3 * k + 2]); };
  const Vector a = at(1) - at(0), b = at(2) - at(0), from = at(3) - at(0), along = at(4);
  // Cramer's rule (Moeller and Trumbore 1997).
  const Vector p = cross(along, b), q = cross(from, a);
  const Exact scale = 1 / dot(a, p);
  const Exact u = dot(from, p) * scale, v = dot(along, q) * scale;
  return {dot(b, q) * scale, u, v};
}

/// How far each moves when the numbers are rounded one after the other: positions as the largest of their
/// coordinates is, because rays are sheared across axes.
PlaneHit moved_hit(const Numbers& numbers, const PlaneHit& hit) {
  PlaneHit sum{0, 0, 0};
  Exact largest = 0;
  for (size_t k = 0; k < 12; ++k) largest = std::max(largest, std::abs(numbers[k]));
  for (size_t k = 0; k < numbers.size(); ++k) {
    PlaneHit most{0, 0, 0};
    for (const Exact sign : {-1.0L, 1.0L}) {
      Numbers moved = numbers;
      moved[k] += sign * static_cast<Exact>(ROUNDING_OF_INPUTS) * (k < 12 ? largest : std::abs(numbers[k]));
      const PlaneHit there = plane_hit(moved);
      most.distance = std::max(most.distance, std::abs(there.distance - hit.distance));
      most.u = std::max(most.u, std::abs(there.u - hit.u));
      most.v = std::max(most.v, std::abs(there.v - hit.v));
    }
    sum.distance += most.distance;
    sum.u += most.u;
    sum.v += most.v;
  }
  return sum;
}

Exact longest_edge(const Vertices& v) {
  return std::max({length(dvec3(v[1]) - dvec3(v[0])), length(dvec3(v[2]) - dvec3(v[1])),
                   length(dvec3(v[0]) - dvec3(v[2]))});
}

constexpr double OWN_ERROR = 40 * 0x1p-24;
constexpr double OWN_REFERENCE_ERROR = 40 * 0x1p-53;

SweepText distance_text(const char* name, const char* parameter) {
  return {
      "geometry",
      fmt::format("distance {}", name),
      parameter,
      fmt::format(
          "{:.1e} for 40 roundings; what moving each coordinate by 2 ulp of the largest does to the plane's "
          "distance in extended "
          "precision; and, as distances are interpolated between vertices, what it does to "
          "barycentrics, times the "
          "longest edge",
          OWN_ERROR),
      OWN_ERROR,
      OWN_REFERENCE_ERROR};
}

void add_field(Sweep& sweep, double parameter, gpu::Device& device, const gpu::Kernel& kernel,
               const Field& field) {
  Tree tree(device, field.triangles);
  const std::vector<Hit> hits = tree.trace(kernel, field.rays);
  const reference::Traversal traversal(tree.bvh());
  for (size_t i = 0; i < hits.size(); ++i) {
    const BenchRay& ray = field.rays[i];
    const Vertices& vertices = field.triangles[field.targets[i]].vertices;
    const Numbers numbers = numbers_of(vertices, ray);
    const PlaneHit truth = plane_hit(numbers);
    const PlaneHit moved = moved_hit(numbers, truth);
    const auto met = traversal.closest({dvec3(ray.origin), dvec3(ray.direction)});
    // Hits number triangles by their place in the tree.
    const std::vector<uint32_t>& order = tree.bvh().order;
    const auto is_target = [&](uint32_t triangle) {
      return field.triangles[order[triangle]].tag == field.triangles[field.targets[i]].tag;
    };
    const bool is_met = hits[i].triangle != INVALID_INDEX && is_target(hits[i].triangle);
    const bool is_met_by_reference = met && is_target(met->triangle);
    const Exact shift = moved.u + moved.v;  // of any barycentric coordinate, at most
    if (truth.inside() < shift) {           // rounding decides whether it is met
      sweep.lose();
      continue;
    }
    sweep.add({parameter, is_met ? double{hits[i].t} : 0.0, is_met_by_reference ? met->t : 0.0,
               truth.distance, moved.distance + shift * longest_edge(vertices)},
              [&] {
                return fmt::format(
                    "triangle ({:.9g} {:.9g} {:.9g}) ({:.9g} {:.9g} {:.9g}) ({:.9g} {:.9g} {:.9g}), ray from "
                    "({:.9g} {:.9g} {:.9g}) along ({:.9g} {:.9g} {:.9g}): {}",
                    vertices[0].x, vertices[0].y, vertices[0].z, vertices[1].x, vertices[1].y, vertices[1].z,
                    vertices[2].x, vertices[2].y, vertices[2].z, ray.origin.x, ray.origin.y, ray.origin.z,
                    ray.direction.x, ray.direction.y, ray.direction.z, is_met ? "met" : "missed");
              });
  }
}

/// A sphere of triangles around the origin, closed: neighbours share the bits of their vertices.
std::vector<bvh::InputTriangle> closed_sphere(double scale, double offset, int rings) {
  const auto vertex = [&](int ring, int sector) {
    const double theta = std::numbers::pi * ring / rings;
    const double phi = std::numbers::pi * (sector % (2 * rings)) / rings;
    const double radius = ring % rings == 0 ? 0 : std::sin(theta);
    return vec3(scale * (dvec3(radius * std::cos(phi), radius * std::sin(phi), std::cos(theta)) + offset));
  };
  std::vector<bvh::InputTriangle> triangles;
  const auto add = [&](const vec3& a, const vec3& b, const vec3& c) {
    triangles.push_back({{a, b, c}, static_cast<uint32_t>(triangles.size())});
  };
  for (int ring = 0; ring < rings; ++ring)
    for (int sector = 0; sector < 2 * rings; ++sector) {
      add(vertex(ring, sector), vertex(ring + 1, sector), vertex(ring + 1, sector + 1));
      add(vertex(ring, sector), vertex(ring + 1, sector + 1), vertex(ring, sector + 1));
    }
  return triangles;
}

/// Rays from within, at vertices and edges, as nearly as floats can.
std::vector<BenchRay> rays_at_edges(const std::vector<bvh::InputTriangle>& triangles, double scale,
                                    double offset, int count, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<BenchRay> rays;
  for (int i = 0; i < count; ++i) {
    const auto& corners = triangles[random() % triangles.size()].vertices;
    const size_t k = random() % 3;
    const double along = i % 3 == 0 ? 0 : i % 3 == 1 ? 0.5 : uniform(random);
    const dvec3 target = glm::mix(dvec3(corners[k]), dvec3(corners[(k + 1) % 3]), along);
    const vec3 origin = vec3(scale * (0.3 * uniform_direction(random) + offset));
    rays.push_back(
        {origin, std::numeric_limits<float>::infinity(), vec3(normalize(target - dvec3(origin))), 0});
  }
  return rays;
}

void add_leaks(Sweep& sweep, double parameter, gpu::Device& device, const gpu::Kernel& kernel, double scale,
               double offset, int count, int batches) {
  const std::vector<bvh::InputTriangle> triangles = closed_sphere(scale, offset, 16);
  Tree tree(device, triangles);
  const reference::Traversal traversal(tree.bvh());
  for (int batch = 0; batch < batches; ++batch) {
    const std::vector<BenchRay> rays =
        rays_at_edges(triangles, scale, offset, count, 99 + static_cast<uint64_t>(batch));
    const std::vector<Hit> hits = tree.trace(kernel, rays);
    constexpr size_t REFERENCE_RAYS = 1000;
    for (size_t i = 0; i < rays.size(); ++i) {
      const bool is_met = hits[i].triangle != INVALID_INDEX;
      const bool is_met_by_reference =
          batch > 0 || i >= REFERENCE_RAYS ||
          traversal.closest({dvec3(rays[i].origin), dvec3(rays[i].direction)}).has_value();
      sweep.add({parameter, is_met ? 1.0 : 0.0, is_met_by_reference ? 1.0 : 0.0, 1, 0}, [&] {
        return fmt::format("from ({:.9g} {:.9g} {:.9g}) along ({:.9g} {:.9g} {:.9g}) in a sphere of {:g} m",
                           rays[i].origin.x, rays[i].origin.y, rays[i].origin.z, rays[i].direction.x,
                           rays[i].direction.y, rays[i].direction.z, scale);
      });
    }
  }
}

SweepText leak_text(const char* name, const char* parameter) {
  return {"geometry", fmt::format("rays kept {}", name), parameter, "no ray leaves a closed surface", 1e-9,
          1e-9};
}

struct DistanceSweep {
  const char* name;
  const char* parameter;
  double low, high;
  FieldKind (*kind)(double);
};

constexpr DistanceSweep DISTANCE_SWEEPS[] = {
    {"over scale", "scale, m", 1e-6, 1e6, [](double x) { return FieldKind{.scale = x}; }},
    {"far from the origin", "offset in sizes of a triangle", 1e-2, 1e8,
     [](double x) { return FieldKind{.offset = x}; }},
    {"of slivers", "length over width", 1, 1e6, [](double x) { return FieldKind{.aspect = x}; }},
    {"at grazing angles", "angle above the plane, rad", 1e-6, 1,
     [](double x) { return FieldKind{.elevation = x}; }},
    {"of copies in one place", "copies of each triangle", 1, 64,
     [](double x) { return FieldKind{.copies = static_cast<int>(x)}; }},
    {"stretched and mirrored", "scale along x, and one over that along -z", 1, 1e3,
     [](double x) { return FieldKind{.stretch = x}; }},
    {"along axes", "slope off the axis", 1e-30, 1, [](double x) { return FieldKind{.tilt = x}; }},
};

}  // namespace

std::vector<Sweep> sweep_geometry(gpu::Device& device, Extent extent) {
  const bool is_quick = extent == Extent::Quick;
  const gpu::Kernel kernel = create_bench_kernel(device, "bench_closest");
  std::vector<Sweep> all;
  for (const DistanceSweep& text : DISTANCE_SWEEPS) {
    Sweep& sweep = all.emplace_back(distance_text(text.name, text.parameter));
    for (const double value : in_equal_ratios(text.low, text.high, is_quick ? 7 : 37))
      add_field(sweep, value, device, kernel, make_field(text.kind(value), is_quick ? 100 : 2000, 7));
  }
  const int rays = is_quick ? 6000 : 1 << 20;
  Sweep& scales = all.emplace_back(leak_text("over scale", "scale, m"));
  const int scale_batches = is_quick ? 1 : 8;  // of the full run: 10^8 rays, with those below
  for (const double scale : in_equal_ratios(1e-6, 1e6, is_quick ? 3 : 7))
    add_leaks(scales, scale, device, kernel, scale, 0, rays, scale_batches);
  Sweep& offsets = all.emplace_back(leak_text("far from the origin", "offset in radii"));
  for (const double offset : in_equal_ratios(1e-2, 1e5, is_quick ? 3 : 8))
    add_leaks(offsets, offset, device, kernel, 1, offset, rays, is_quick ? 1 : 6);
  return all;
}

}  // namespace regulus::stability
