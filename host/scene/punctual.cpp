#include "scene/punctual.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace regulus::scene {
namespace {

// Least difference of the heights 1 - cos of a cone's two angles, as a share of the outer one: keeps the
// falloff's quotient finite in single precision.
constexpr double MIN_CONE_WIDTH = 1e-5;
// Least height of a cone: of 1.4e-6 radians, which directions in single precision tell apart from none.
constexpr double MIN_CONE_HEIGHT = 1e-12;

/// Direction of a node's local axis in the world; local -z where the transform collapses it.
glm::vec3 world_direction(const glm::dmat4& to_world, const glm::dvec3& axis) {
  const glm::dvec3 direction = glm::dmat3(to_world) * axis;
  const double length = glm::length(direction);
  return length > 0 ? glm::vec3(direction / length) : glm::vec3(0, 0, -1);
}

/// `otherwise`, with a warning, for values that are not positive numbers of single precision.
double positive_or(Document& document, double value, double otherwise, const std::string& element) {
  if (static_cast<float>(value) > 0 && std::isfinite(static_cast<float>(value))) return value;
  document.mend(fmt::format("{} is {:g} and must be greater than 0; correct it", element, value),
                otherwise > 0 ? fmt::format("taken as {:g}", otherwise) : "ignored");
  return otherwise;
}

void set_cone(Document& document, const tinygltf::Light& source, const std::string& name,
              interface::Light& light) {
  double outer = source.spot.outerConeAngle;
  double inner = source.spot.innerConeAngle;
  if (!(outer > 0 && outer <= glm::half_pi<double>() * (1 + 1e-6) && inner >= 0 && inner < outer)) {
    document.mend(
        fmt::format("{}: cone angles {:g} and {:g} are not 0 <= inner < outer <= pi/2; correct them", name,
                    inner, outer),
        "clamped");
    outer = std::clamp(outer, 0.0, glm::half_pi<double>());
    inner = std::clamp(inner, 0.0, outer);
  }
  const auto height = [](double angle) { return 2 * std::sin(angle / 2) * std::sin(angle / 2); };
  const double outer_height = std::clamp(height(outer), MIN_CONE_HEIGHT, 1.0);
  if (outer > 0 && height(outer) < MIN_CONE_HEIGHT)
    document.warn(fmt::format("{}: a cone of {:g} radians is taken as one of {:.2g}; widen it", name, outer,
                              std::sqrt(2 * MIN_CONE_HEIGHT)));
  light.outer_height = static_cast<float>(outer_height);
  light.inner_height = static_cast<float>(std::min(height(inner), outer_height * (1 - MIN_CONE_WIDTH)));
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
    document.mend(fmt::format("{}: type '{}' is unknown; correct it", name, source.type), "left out");
    return;
  }
  if (light.kind != interface::LIGHT_DIRECTIONAL && source.range != 0)
    light.area = static_cast<float>(positive_or(document, source.range, 0, name + ": range"));
  light.triangle = interface::INVALID_INDEX;
  light.material = interface::INVALID_INDEX;
  light.position = glm::vec3(placed.to_world[3]);
  light.direction = world_direction(placed.to_world, {0, 0, -1});
  for (int i = 0; i < 3; ++i) {
    const double color = source.color.empty() ? 1.0 : source.color[static_cast<size_t>(i)];
    const double value = color * source.intensity;
    if (value < 0) document.mend(name + ": its intensity is negative; correct it", "dark");
    light.intensity[i] = finite_float(document, std::max(value, 0.0), name + ": intensity");
  }
  scene.lights.push_back(light);
  scene.light_nodes.push_back(static_cast<uint32_t>(placed.node));
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
    if (number < 0 || (number == 0 && key == "focus_distance")) {
      document.mend(fmt::format("{}: {} must be greater than 0; correct it", name, key), "ignored");
      continue;
    }
    (key == "lens_radius" ? camera.lens_radius : camera.focus_distance) = number;
  }
}

/// znear and zfar. A plane at 0 is none.
void set_planes(Document& document, const tinygltf::Camera& source, const std::string& name,
                SceneCamera& camera) {
  const bool is_orthographic = source.type == "orthographic";
  const double nearest = is_orthographic ? source.orthographic.znear : source.perspective.znear;
  const double farthest = is_orthographic ? source.orthographic.zfar : source.perspective.zfar;
  if (!(nearest >= 0 && (farthest == 0 || farthest > nearest) && nearest < double{NO_FAR_PLANE}))
    return document.mend(fmt::format("{}: znear {:g} and zfar {:g} are not 0 <= znear < zfar; correct them",
                                     name, nearest, farthest),
                         "nothing is clipped");
  camera.z_near = static_cast<float>(nearest);
  if (farthest != 0) camera.z_far = static_cast<float>(std::min(farthest, double{NO_FAR_PLANE}));
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
        static_cast<float>(positive_or(document, std::fabs(source.orthographic.xmag), 1, name + ": xmag"));
    camera.y_magnification =
        static_cast<float>(positive_or(document, std::fabs(source.orthographic.ymag), 1, name + ": ymag"));
    camera.aspect_ratio = camera.x_magnification / camera.y_magnification;
  } else {
    const float usual = camera.y_fov;
    camera.y_fov = static_cast<float>(positive_or(document, source.perspective.yfov, usual, name + ": yfov"));
    if (camera.y_fov >= glm::pi<float>() * 0.999f) {
      document.mend(fmt::format("{}: yfov {:g} is not below pi; correct it", name, camera.y_fov),
                    fmt::format("taken as {:g}", usual));
      camera.y_fov = usual;
    }
    if (source.perspective.aspectRatio != 0)
      camera.aspect_ratio = static_cast<float>(
          positive_or(document, source.perspective.aspectRatio, 0, name + ": aspectRatio"));
  }
  set_planes(document, source, name, camera);
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
