#include "reference/first_hits.hpp"

#include <limits>
#include <optional>

namespace regulus::reference {

using glm::dvec2;
using glm::dvec3;
using namespace interface;

namespace {

/// Depth and indices of a pixel that meets nothing.
AovPixel empty_pixel() {
  AovPixel pixel{};
  pixel.depth = std::numeric_limits<float>::infinity();
  pixel.material = pixel.instance = INVALID_INDEX;
  return pixel;
}

std::optional<Surface> first_surface(const World& world, const CameraRay& ray) {
  const auto hit = world.traversal().closest(
      {.origin = ray.origin, .direction = ray.direction, .t_min = ray.nearest, .t_max = ray.farthest});
  if (!hit) return std::nullopt;
  return world.surface_at(hit->triangle, hit->barycentrics);
}

/// Ray `i` of a pixel.
CameraRay aov_ray(const Camera& camera, const Settings& settings, uint32_t pixel, uint32_t i) {
  const dvec2 middle = dvec2(pixel % settings.width, pixel / settings.width) + 0.5;
  const glm::dvec4 u = random_block(settings, pixel, i, DIMENSION_BLOCK_CAMERA);
  return camera.ray(middle + settings.filter.sample({u.x, u.y}), {u.z, u.w});
}

uint32_t instance_of(const World& world, const Surface& surface) {
  return scene::placed_triangle(world.scene(), surface.triangle).triangle.instance;
}

/// Base colour; unlit surfaces show their emission.
dvec3 albedo_of(const World& world, const Surface& surface) {
  const bool is_unlit = (world.scene().materials[surface.material].flags & MATERIAL_UNLIT) != 0;
  return is_unlit ? world.emission_at(surface) : world.bsdf_at(surface).parameters().base_color;
}

AovPixel pixel_of(const World& world, const Camera& camera, const Settings& settings, uint32_t pixel) {
  AovPixel result = empty_pixel();
  const dvec2 middle = dvec2(pixel % settings.width, pixel / settings.width) + 0.5;
  dvec3 albedo(0), shading(0), geometric(0);
  for (uint32_t i = 0; i < AOV_RAYS; ++i) {
    const CameraRay ray = aov_ray(camera, settings, pixel, i);
    const std::optional<Surface> surface = first_surface(world, ray);
    if (!surface) continue;
    const double side = dot(ray.direction, surface->geometric_normal) < 0 ? 1 : -1;
    albedo += albedo_of(world, *surface);
    shading += side * surface->shading_normal;
    geometric += side * surface->geometric_normal;
  }
  result.albedo = glm::vec3(albedo / double{AOV_RAYS});
  result.shading_normal = glm::vec3(shading / double{AOV_RAYS});
  result.geometric_normal = glm::vec3(geometric / double{AOV_RAYS});
  const CameraRay central = camera.ray(middle, dvec2(0.5));
  if (const std::optional<Surface> surface = first_surface(world, central)) {
    result.position = glm::vec3(surface->position);
    result.depth = static_cast<float>(camera.depth(surface->position));
    result.material = surface->material;
    result.instance = instance_of(world, *surface);
  }
  return result;
}

}  // namespace

std::vector<AovPixel> first_hits(const World& world, const Camera& camera, const Settings& settings) {
  std::vector<AovPixel> pixels;
  for (uint32_t i = 0; i < settings.window().pixels(); ++i)
    pixels.push_back(pixel_of(world, camera, settings, settings.window().pixel_of(i, settings.width)));
  return pixels;
}

std::vector<glm::uvec2> first_ids(const World& world, const Camera& camera, const Settings& settings) {
  std::vector<glm::uvec2> ids;
  for (uint32_t i = 0; i < settings.window().pixels(); ++i)
    for (uint32_t k = 0; k < AOV_RAYS; ++k) {
      const CameraRay ray = aov_ray(camera, settings, settings.window().pixel_of(i, settings.width), k);
      const std::optional<Surface> surface = first_surface(world, ray);
      ids.push_back(surface ? glm::uvec2(instance_of(world, *surface), surface->material)
                            : glm::uvec2(INVALID_INDEX));
    }
  return ids;
}

}  // namespace regulus::reference
