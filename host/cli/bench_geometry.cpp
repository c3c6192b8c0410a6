#include "cli/bench_geometry.hpp"

#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "scene/scene.hpp"

namespace regulus::cli {

namespace {

using Triangles = std::vector<bvh::InputTriangle>;
using Surface = std::function<glm::vec3(float, float)>;

/// Appends surface(u, v) over the unit square as columns x rows quads.
void append_surface(Triangles& triangles, uint32_t columns, uint32_t rows, const Surface& surface) {
  std::vector<glm::vec3> points;
  for (uint32_t row = 0; row <= rows; ++row)
    for (uint32_t column = 0; column <= columns; ++column)
      points.push_back(surface(static_cast<float>(column) / static_cast<float>(columns),
                               static_cast<float>(row) / static_cast<float>(rows)));
  for (uint32_t row = 0; row < rows; ++row) {
    for (uint32_t column = 0; column < columns; ++column) {
      const uint32_t i = row * (columns + 1) + column;
      triangles.push_back({{points[i], points[i + 1], points[i + columns + 2]}});
      triangles.push_back({{points[i], points[i + columns + 2], points[i + columns + 1]}});
    }
  }
}

/// Appends a closed room, its six walls divided into 8 x 8 quads.
void append_room(Triangles& triangles, glm::vec3 lower, glm::vec3 upper) {
  for (int axis = 0; axis < 3; ++axis) {
    for (float side : {lower[axis], upper[axis]}) {
      append_surface(triangles, 8, 8, [=](float u, float v) {
        glm::vec3 point;
        point[axis] = side;
        point[(axis + 1) % 3] = glm::mix(lower[(axis + 1) % 3], upper[(axis + 1) % 3], u);
        point[(axis + 2) % 3] = glm::mix(lower[(axis + 2) % 3], upper[(axis + 2) % 3], v);
        return point;
      });
    }
  }
}

glm::vec3 sphere_direction(float u, float v) {
  const float phi = 2 * std::numbers::pi_v<float> * u;
  const float theta = std::numbers::pi_v<float> * v;
  return {std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)};
}

/// Sum of sine waves of falling length and height in skewed directions: smooth hills down to pebbles.
float roughness_at(glm::vec3 p) {
  float height = 0;
  float amplitude = 0.5f;
  for (int octave = 0; octave < 6; ++octave) {
    height += amplitude * std::sin(p.x) * std::sin(p.y + 1.3f) * std::sin(p.z + 2.1f);
    p = 2.1f * glm::vec3(0.8f * p.x + 0.6f * p.y, 0.8f * p.y - 0.6f * p.x + 0.3f * p.z, p.z + 0.2f * p.x);
    amplitude *= 0.45f;
  }
  return height;
}

/// A camera of 53 degrees horizontal field of view for a film of twice the width of its height.
interface::Camera look_at(glm::vec3 position, glm::vec3 target) {
  const glm::vec3 forward = glm::normalize(target - position);
  const glm::vec3 right = glm::normalize(glm::cross(forward, glm::vec3(0, 1, 0)));
  interface::Camera camera {};
  camera.position = position;
  camera.forward = forward;
  camera.right = 0.5f * right;
  camera.up = 0.25f * glm::cross(right, forward);
  return camera;
}

BenchScene hall() {
  BenchScene scene{"hall", {}, look_at({-0.9f, 1.2f, -0.7f}, {8, 4, 8}), {4.0f, 7.9f, 4.2f}};
  append_room(scene.triangles, glm::vec3(-1), glm::vec3(8));
  for (int x = 0; x < 8; ++x)
    for (int y = 0; y < 8; ++y)
      for (int z = 0; z < 8; ++z) {
        const glm::vec3 center(static_cast<float>(x) - 0.1f, static_cast<float>(y) - 0.2f,
                               static_cast<float>(z) - 0.3f);
        const float radius = 0.2f + 0.15f * std::sin(static_cast<float>(3 * x + 5 * y + 7 * z));
        append_surface(scene.triangles, 30, 16,
                       [=](float u, float v) { return center + radius * sphere_direction(u, v); });
      }
  return scene;
}

BenchScene boulder() {
  BenchScene scene{"boulder", {}, look_at({-2.4f, 0.9f, -2.2f}, {0, -0.3f, 0}), {1.1f, 1.9f, -1.3f}};
  append_room(scene.triangles, {-2.6f, -1.1f, -2.6f}, {2.6f, 2, 2.6f});
  append_surface(scene.triangles, 1000, 500, [](float u, float v) {
    const glm::vec3 direction = sphere_direction(u, v);
    return (1 + 0.3f * roughness_at(5.0f * direction)) * direction;
  });
  return scene;
}

BenchScene terrain() {
  BenchScene scene{"terrain", {}, look_at({-5, 1.8f, -5}, {1, -0.6f, 1}), {30, 12, -20}};
  append_surface(scene.triangles, 500, 500, [](float u, float v) {
    const glm::vec3 p(12 * u - 6, 0, 12 * v - 6);
    return p + glm::vec3(0, 1.5f * roughness_at(1.7f * p + glm::vec3(0, 1, 0)), 0);
  });
  return scene;
}

}  // namespace

std::vector<BenchScene> procedural_bench_scenes() {
  return {hall(), boulder(), terrain()};
}

BenchScene load_bench_scene(const std::filesystem::path& path) {
  // All triangles in one tree, as Embree gets them.
  scene::LoadOptions options;
  options.sharing_gain = scene::NEVER_SHARE;
  const scene::Scene loaded = scene::load(path, options);
  BenchScene result;
  result.name = path.stem().string();
  for (const interface::Triangle& triangle : loaded.triangles)
    result.triangles.push_back({{loaded.vertices[triangle.v0].position, loaded.vertices[triangle.v1].position,
                                 loaded.vertices[triangle.v2].position}});
  result.camera = scene::make_camera(loaded.cameras.front(), 2, 1);
  const glm::vec3 extent = loaded.bounds_max - loaded.bounds_min;
  result.light = loaded.bounds_min + glm::vec3(0.45f, 0.95f, 0.55f) * extent;
  return result;
}

}  // namespace regulus::cli
