#include "regulus/scene.hpp"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <glm/glm.hpp>

#include "library/impl.hpp"
#include "prepared/prepared_scene.hpp"
#include "regulus/error.hpp"
#include "scene/placement.hpp"

namespace regulus {

namespace {

glm::dvec3 vector_of(const std::array<double, 3>& v) {
  return {v[0], v[1], v[2]};
}

bool is_finite(const std::array<double, 3>& v) {
  return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}

Camera camera_of(const scene::SceneCamera& own, const glm::dvec3& origin) {
  const glm::dmat4 to_world(own.camera_to_world);
  Camera camera;
  camera.name = own.name;
  camera.position = array_of(origin + glm::dvec3(to_world[3]));
  camera.direction = array_of(-glm::normalize(glm::dvec3(to_world[2])));
  camera.up = array_of(glm::normalize(glm::dvec3(to_world[1])));
  camera.is_orthographic = own.is_orthographic;
  camera.vertical_fov = static_cast<double>(own.y_fov);
  camera.half_height = static_cast<double>(own.y_magnification);
  camera.aspect_ratio = static_cast<double>(own.aspect_ratio);
  camera.lens_radius = static_cast<double>(own.lens_radius);
  camera.focus_distance = static_cast<double>(own.focus_distance);
  return camera;
}

/// What is wrong with a camera; nothing if it can be used.
const char* fault_of(const Camera& camera) {
  const auto is_positive = [](double value) { return std::isfinite(value) && static_cast<float>(value) > 0; };
  if (!is_finite(camera.position)) return "its position is not finite";
  if (!is_finite(camera.direction) || !(glm::length(vector_of(camera.direction)) > 0))
    return "its direction has no length";
  const glm::dvec3 forward = glm::normalize(vector_of(camera.direction));
  if (!is_finite(camera.up) ||
      !(glm::length(glm::cross(forward, vector_of(camera.up))) > 1e-6 * glm::length(vector_of(camera.up))))
    return "up lies along its direction";
  if (camera.is_orthographic && !is_positive(camera.half_height)) return "half_height must be above 0";
  if (!camera.is_orthographic && !(is_positive(camera.vertical_fov) && camera.vertical_fov < 3.1415))
    return "vertical_fov must be above 0 and below pi";
  if (camera.aspect_ratio != 0 && !is_positive(camera.aspect_ratio))
    return "aspect_ratio must not be negative";
  if (camera.lens_radius != 0 && !is_positive(camera.lens_radius)) return "lens_radius must not be negative";
  if (!is_positive(camera.focus_distance)) return "focus_distance must be above 0";
  return nullptr;
}

/// `own` with what `camera` says of it.
scene::SceneCamera scene_camera_of(const Camera& camera, scene::SceneCamera own, const glm::dvec3& origin) {
  const glm::dvec3 forward = glm::normalize(vector_of(camera.direction));
  const glm::dvec3 right = glm::normalize(glm::cross(forward, vector_of(camera.up)));
  own.name = camera.name;
  own.is_orthographic = camera.is_orthographic;
  own.camera_to_world =
      glm::mat4(glm::dmat4(glm::dvec4(right, 0), glm::dvec4(glm::cross(right, forward), 0),
                           glm::dvec4(-forward, 0), glm::dvec4(vector_of(camera.position) - origin, 1)));
  own.y_fov = static_cast<float>(camera.vertical_fov);
  own.aspect_ratio = static_cast<float>(camera.aspect_ratio);
  own.y_magnification = static_cast<float>(camera.half_height);
  own.x_magnification =
      static_cast<float>(camera.half_height * (camera.aspect_ratio > 0 ? camera.aspect_ratio : 1));
  own.lens_radius = static_cast<float>(camera.lens_radius);
  own.focus_distance = static_cast<float>(camera.focus_distance);
  return own;
}

/// A scene seen by other cameras is another one for those who join its samples (FNV-1a).
uint64_t hash_with(uint64_t hash, const std::vector<scene::SceneCamera>& cameras) {
  const auto add = [&](float value) { hash = (hash ^ std::bit_cast<uint32_t>(value)) * 0x100000001b3u; };
  for (const scene::SceneCamera& camera : cameras) {
    for (int column = 0; column < 4; ++column)
      for (int row = 0; row < 3; ++row) add(camera.camera_to_world[column][row]);
    for (const float value : {camera.is_orthographic ? 1.0f : 0.0f, camera.y_fov, camera.aspect_ratio,
                              camera.y_magnification, camera.lens_radius, camera.focus_distance})
      add(value);
  }
  return hash;
}

}  // namespace

Camera look_at(Camera camera, const std::array<double, 3>& position, const std::array<double, 3>& target,
               const std::array<double, 3>& up) {
  camera.position = position;
  camera.direction = array_of(vector_of(target) - vector_of(position));
  camera.up = up;
  return camera;
}

std::filesystem::path Scene::path() const {
  return impl_->scene->path;
}

std::vector<std::string> Scene::edits() const {
  return impl_->scene->edits;
}

std::vector<std::string> Scene::warnings() const {
  return impl_->scene->warnings;
}

std::map<std::string, std::string> Scene::settings() const {
  return impl_->scene->settings;
}

std::vector<Camera> Scene::cameras() const {
  std::vector<Camera> result;
  for (const scene::SceneCamera& camera : impl_->cameras)
    result.push_back(camera_of(camera, impl_->scene->origin));
  return result;
}

void Scene::set_camera(size_t index, const Camera& camera) {
  if (index > impl_->cameras.size())
    throw Error(ErrorCode::BadUsage,
                fmt::format("camera {}: {} has {}; the next one is {}", index, path().string(),
                            impl_->cameras.size(), impl_->cameras.size()));
  if (const char* fault = fault_of(camera))
    throw Error(ErrorCode::BadUsage, fmt::format("camera {}: {}", index, fault));
  Impl changed = *impl_;
  if (index == changed.cameras.size()) changed.cameras.emplace_back();
  changed.cameras[index] = scene_camera_of(camera, changed.cameras[index], changed.scene->origin);
  changed.has_own_cameras = true;
  impl_ = std::make_shared<const Impl>(std::move(changed));
}

std::array<double, 3> Scene::bounds_min() const {
  return array_of(impl_->scene->origin + glm::dvec3(impl_->scene->bounds_min));
}

std::array<double, 3> Scene::bounds_max() const {
  return array_of(impl_->scene->origin + glm::dvec3(impl_->scene->bounds_max));
}

uint64_t Scene::triangle_count() const {
  return scene::placed_triangle_count(*impl_->scene);
}

size_t Scene::material_count() const {
  return impl_->scene->materials.size();
}

std::vector<std::string> Scene::material_names() const {
  return impl_->scene->material_names;
}

Scene load(const std::filesystem::path& path, const LoadOptions& options) {
  auto loaded = std::make_shared<const scene::Scene>(scene::load(
      path, {.scene = options.scene,
             .allow_external = options.allow_external,
             .is_strict = options.is_strict,
             .environment = {options.environment, options.environment_rotation, options.environment_scale},
             .variant = options.variant,
             .memory_bytes = options.memory_bytes,
             .animation = options.animation,
             .time = options.time,
             .edits = options.edits}));
  return Scene(std::make_shared<const Scene::Impl>(Scene::Impl{loaded, loaded->cameras, false}));
}

Prepared prepare(const Scene& scene) {
  scene::Scene copy = *scene.impl().scene;
  if (scene.impl().has_own_cameras) {
    copy.cameras = scene.impl().cameras;
    copy.hash = hash_with(copy.hash, copy.cameras);
  }
  return std::make_shared<const PreparedScene>(prepare(std::move(copy)));
}

}  // namespace regulus
