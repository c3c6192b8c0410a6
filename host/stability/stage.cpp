#include "stability/stage.hpp"

#include <cmath>
#include <limits>

#include "check/reference_render.hpp"

namespace regulus::stability {

using glm::dvec3;
using glm::vec3;
using namespace interface;

Material diffuse(double albedo, double radiance) {
  Material material = scene::untextured_material();
  material.base_color = vec3(static_cast<float>(albedo));
  material.roughness = 1;
  material.ior = 1.5f;
  material.alpha = 1;
  material.emission = vec3(static_cast<float>(radiance));
  material.flags = radiance > 0 ? MATERIAL_EMISSIVE : 0;
  material.material_class = MATERIAL_CLASS_DIFFUSE;
  return material;
}

void Stage::add_quad(const dvec3& corner, const dvec3& u, const dvec3& v, const Material& material) {
  const auto first = static_cast<uint32_t>(scene_.vertices.size());
  for (const dvec3& position : {corner, corner + u, corner + u + v, corner + v}) {
    scene_.vertices.push_back({vec3(position), vec3(normalize(cross(u, v))), glm::vec2(0)});
    scene_.bounds_min =
        first == 0 && scene_.vertices.size() == 1 ? vec3(position) : min(scene_.bounds_min, vec3(position));
    scene_.bounds_max = scene_.vertices.size() == 1 ? vec3(position) : max(scene_.bounds_max, vec3(position));
  }
  const auto number = static_cast<uint32_t>(scene_.materials.size());
  scene_.materials.push_back(material);
  scene_.material_names.emplace_back();
  scene_.material_priorities.push_back(0);
  for (const uint32_t k : {1u, 2u})
    scene_.triangles.push_back({first, first + k, first + k + 1, number, INVALID_INDEX, number});
}

void Stage::add_point_light(const dvec3& position, double intensity) {
  Light light{};
  light.kind = LIGHT_POINT;
  light.triangle = light.material = INVALID_INDEX;
  light.position = vec3(position);
  light.intensity = vec3(static_cast<float>(intensity));
  scene_.lights.push_back(light);
}

void Stage::add_sun(double irradiance) {
  Light light{};
  light.kind = LIGHT_DIRECTIONAL;
  light.triangle = light.material = INVALID_INDEX;
  light.direction = {0, 0, -1};
  light.intensity = vec3(static_cast<float>(irradiance));
  scene_.lights.push_back(light);
}

void Stage::set_environment(scene::Environment environment) {
  scene_.environment = std::move(environment);
}

PreparedScene Stage::seen_from(const dvec3& eye, double half_extent) {
  scene::SceneCamera camera;
  camera.is_orthographic = true;
  camera.camera_to_world = glm::mat4(1);
  camera.camera_to_world[3] = glm::vec4(vec3(eye), 1);
  camera.x_magnification = camera.y_magnification = static_cast<float>(half_extent);
  scene_.cameras.push_back(camera);
  return prepare(std::move(scene_));
}

render::RenderSettings settings_of(uint32_t techniques, uint32_t size, uint32_t samples, uint32_t depth) {
  render::RenderSettings settings;
  settings.width = settings.height = size;
  settings.samples = samples;
  settings.max_depth = depth;
  settings.techniques = techniques;
  settings.filter = FILTER_BOX;
  settings.filter_radius = 0;
  settings.keeps_merge_radius = true;
  return settings;
}

namespace {

Mean mean_of(const image::Image& image) {
  double sum = 0;
  double squares = 0;
  const size_t pixels = image.rgb.size() / 3;
  for (size_t i = 0; i < pixels; ++i) {
    const double value = image.rgb[3 * i + 1];
    sum += value;
    squares += value * value;
  }
  const double n = static_cast<double>(pixels);
  const double mean = sum / n;
  return {mean, std::sqrt(std::max(squares / n - mean * mean, 0.0) / (n - 1))};
}

}  // namespace

Mean by_device(gpu::Device& device, const PreparedScene& prepared, const render::RenderSettings& settings) {
  render::Renderer renderer(device, prepared, make_plan(prepared, settings));
  renderer.render([](uint64_t, uint64_t) { return true; });
  if (renderer.statistics().non_finite != 0) return {std::numeric_limits<double>::quiet_NaN(), 0};
  return mean_of(resolve(renderer.film()));
}

Mean by_reference(const PreparedScene& prepared, const render::RenderSettings& settings) {
  return mean_of(
      check::render_with_reference(prepared, make_plan(prepared, settings), [](uint64_t, uint64_t) {
        return true;
      }).image);
}

}  // namespace regulus::stability
