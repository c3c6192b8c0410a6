#include "scene/punctual.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace regulus::scene {
namespace {

// Least difference of the cone's cosines: keeps the falloff's quotient finite in single precision.
constexpr float MIN_CONE_WIDTH = 1e-5f;

/// Direction of a node's local axis in the world; local -z where the transform collapses it.
glm::vec3 world_direction(const glm::dmat4& to_world, const glm::dvec3& axis) {
  const glm::dvec3 direction = glm::dmat3(to_world) * axis;
  const double length = glm::length(direction);
  return length > 0 ? glm::vec3(direction / length) : glm::vec3(0, 0, -1);
}

void set_cone(Document& document, const tinygltf::Light& source, const std::string& name,
              interface::Light& light) {
  double outer = source.spot.outerConeAngle;
  double inner = source.spot.innerConeAngle;
  if (!(outer > 0 && outer <= glm::half_pi<double>() * (1 + 1e-6) && inner >= 0 && inner < outer)) {
    document.warn(fmt::format("{}: cone angles {:g} and {:g} are clamped to 0 <= inner < outer <= pi/2", name,
                              inner, outer));
    outer = std::clamp(outer, 0.0, glm::half_pi<double>());
    inner = std::clamp(inner, 0.0, outer);
  }
  light.cos_outer = static_cast<float>(std::cos(std::min(outer, glm::half_pi<double>())));
  light.cos_inner = std::max(static_cast<float>(std::cos(inner)), light.cos_outer + MIN_CONE_WIDTH);
}

void add_light(Document& document, const PlacedNode& placed, size_t index, Scene& scene) {
  const tinygltf::Light& source = document.model.lights[index];
  const std::string name = element_name("light", index, source.name);
  interface::Light light {};
  if (source.type == "point") {
    light.kind = interface::LIGHT_POINT;
  } else if (source.type == "spot") {
    light.kind = interface::LIGHT_SPOT;
    set_cone(document, source, name, light);
  } else if (source.type == "directional") {
    light.kind = interface::LIGHT_DIRECTIONAL;
  } else {
    document.warn(fmt::format("{}: type '{}' is unknown; the light is skipped", name, source.type));
    return;
  }
  if (source.range > 0)
    document.warn(fmt::format("{}: range is ignored: light falls off by distance alone", name));
  light.triangle = interface::INVALID_INDEX;
  light.material = interface::INVALID_INDEX;
  light.position = glm::vec3(placed.to_world[3]);
  light.direction = world_direction(placed.to_world, {0, 0, -1});
  for (int i = 0; i < 3; ++i) {
    const double color = source.color.empty() ? 1.0 : source.color[static_cast<size_t>(i)];
    const double value = color * source.intensity;
    if (value < 0) document.fail(name + ": its intensity is negative; correct it");
    light.intensity[i] = finite_float(document, value, name + ": intensity");
  }
  scene.lights.push_back(light);
}

double positive(const Document& document, double value, const std::string& element) {
  if (!(value > 0) || !std::isfinite(static_cast<float>(value)))
    document.fail(fmt::format("{} is {:g} and must be greater than 0; correct it", element, value));
  return value;
}

/// Thin lens of a camera: cameras[].extras.regulus.{lens_radius, focus_distance}, in metres.
void set_lens(Document& document, size_t index, const std::string& name, SceneCamera& camera) {
  const auto& source = document.json["cameras"][index];
  const auto extras = source.find("extras");
  if (extras == source.end() || !extras->is_object()) return;
  const auto settings = extras->find("regulus");
  if (settings == extras->end() || !settings->is_object()) return;
  for (const auto& [key, value] : settings->items()) {
    if ((key != "lens_radius" && key != "focus_distance") || !value.is_number()) {
      document.warn(fmt::format("{}: extras.regulus.{} is not a setting of cameras", name, key));
      continue;
    }
    const float number = finite_float(document, value.get<double>(), fmt::format("{}: {}", name, key));
    if (number < 0 || (number == 0 && key == "focus_distance"))
      document.fail(fmt::format("{}: {} must be greater than 0; correct it", name, key));
    (key == "lens_radius" ? camera.lens_radius : camera.focus_distance) = number;
  }
}

SceneCamera make_scene_camera(Document& document, const PlacedNode& placed, size_t index) {
  const tinygltf::Camera& source = document.model.cameras[index];
  const std::string name = element_name("camera", index, source.name);
  SceneCamera camera;
  camera.name = source.name.empty() ? document.model.nodes[placed.node].name : source.name;
  camera.camera_to_world = glm::mat4(placed.to_world);
  camera.is_orthographic = source.type == "orthographic";
  if (camera.is_orthographic) {
    camera.x_magnification =
        static_cast<float>(positive(document, std::fabs(source.orthographic.xmag), name + ": xmag"));
    camera.y_magnification =
        static_cast<float>(positive(document, std::fabs(source.orthographic.ymag), name + ": ymag"));
    camera.aspect_ratio = camera.x_magnification / camera.y_magnification;
  } else {
    camera.y_fov = static_cast<float>(positive(document, source.perspective.yfov, name + ": yfov"));
    if (camera.y_fov >= glm::pi<float>() * 0.999f)
      document.fail(fmt::format("{}: yfov {:g} is not below pi; correct it", name, camera.y_fov));
    if (source.perspective.aspectRatio > 0)
      camera.aspect_ratio = finite_float(document, source.perspective.aspectRatio, name + ": aspectRatio");
  }
  set_lens(document, index, name, camera);
  return camera;
}

}  // namespace

void add_punctual_lights(Document& document, const std::vector<PlacedNode>& nodes, Scene& scene) {
  for (const PlacedNode& placed : nodes) {
    if (!placed.is_visible) continue;
    const auto& extensions = document.model.nodes[placed.node].extensions;
    const auto found = extensions.find("KHR_lights_punctual");
    if (found != extensions.end() && found->second.Has("light"))
      add_light(document, placed, static_cast<size_t>(found->second.Get("light").GetNumberAsInt()), scene);
  }
}

void add_cameras(Document& document, const std::vector<PlacedNode>& nodes, Scene& scene) {
  for (const PlacedNode& placed : nodes) {
    const int camera = document.model.nodes[placed.node].camera;
    if (camera >= 0)
      scene.cameras.push_back(make_scene_camera(document, placed, static_cast<size_t>(camera)));
  }
}

SceneCamera frame_bounds(const glm::vec3& bounds_min, const glm::vec3& bounds_max) {
  SceneCamera camera;
  camera.name = "framed";
  const glm::vec3 center = 0.5f * (bounds_min + bounds_max);
  const float radius = std::max(0.5f * glm::length(bounds_max - bounds_min), FLT_MIN);
  // glTF assets face +z. The sphere around the bounds fills the height of the picture.
  const glm::vec3 towards_camera = glm::normalize(glm::vec3(0.5f, 0.35f, 1.0f));
  const float distance = radius / std::sin(0.5f * camera.y_fov);
  camera.camera_to_world =
      glm::inverse(glm::lookAt(center + distance * towards_camera, center, glm::vec3(0, 1, 0)));
  camera.focus_distance = distance;
  return camera;
}

}  // namespace regulus::scene
