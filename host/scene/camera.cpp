// make_camera: the scene's camera for a film size.
#include <algorithm>
#include <cmath>

#include "scene/film_limits.hpp"
#include "scene/scene.hpp"

namespace regulus::scene {
namespace {

/// Unit vector, or `otherwise` where a degenerate transform leaves no direction.
glm::dvec3 unit_or(const glm::dvec3& vector, const glm::dvec3& otherwise) {
  const double length = glm::length(vector);
  return length > 1e-30 ? vector / length : otherwise;
}

constexpr float DEFAULT_WIDTH = 1280;

}  // namespace

glm::uvec2 default_film_size(const Scene& scene, uint32_t camera) {
  if (scene.resolution) return *scene.resolution;
  const float aspect = scene.cameras[camera].aspect_ratio;
  if (!(aspect > 0)) return {1280, 720};
  return {1280, static_cast<uint32_t>(
                    std::clamp(std::round(DEFAULT_WIDTH / aspect), 1.0f, static_cast<float>(MAX_FILM_SIDE)))};
}

interface::Camera make_camera(const SceneCamera& camera, uint32_t width, uint32_t height) {
  // The rigid part of the transform: forward exactly, up as near as possible, right completing them.
  const glm::dmat4 to_world(camera.camera_to_world);
  const glm::dvec3 forward = unit_or(-glm::dvec3(to_world[2]), {0, 0, -1});
  const glm::dvec3 given_up(to_world[1]);
  const glm::dvec3 fallback = std::abs(forward.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1);
  glm::dvec3 right = glm::cross(forward, unit_or(given_up, fallback));
  right = unit_or(right, glm::normalize(glm::cross(forward, fallback)));
  const glm::dvec3 up = glm::cross(right, forward);

  const double aspect = static_cast<double>(width) / static_cast<double>(height);
  // The frame is never cut (glTF 2.0, 3.10.3): where the film is narrower, it sees more above and below.
  const double widening = std::max(camera.aspect_ratio / aspect, 1.0);
  const double half_height =
      widening * (camera.is_orthographic ? camera.y_magnification : std::tan(0.5 * camera.y_fov));
  interface::Camera result {};
  result.position = glm::vec3(to_world[3]);
  result.kind = camera.is_orthographic ? interface::CAMERA_ORTHOGRAPHIC : interface::CAMERA_PERSPECTIVE;
  result.forward = glm::vec3(forward);
  result.lens_radius = camera.lens_radius;
  result.right = glm::vec3(right * half_height * aspect);
  result.focus_distance = camera.focus_distance;
  result.up = glm::vec3(up * half_height);
  result.z_near = camera.z_near;
  result.z_far = camera.z_far;
  return result;
}

}  // namespace regulus::scene
