// What stands behind the public types.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gpu/gpu.hpp"
#include "regulus/render.hpp"
#include "regulus/scene.hpp"
#include "session/render_job.hpp"

namespace regulus {

/// As the public types hold vectors.
inline std::array<double, 3> array_of(const glm::dvec3& v) {
  return {v.x, v.y, v.z};
}

struct Scene::Impl {
  std::shared_ptr<const scene::Scene> scene;
  std::vector<scene::SceneCamera> cameras;  ///< instead of the scene's
  bool has_own_cameras = false;
};

struct Device::Impl {
  std::optional<gpu::Device> device;  ///< none: the reference
};

struct Plan::Impl {
  Prepared prepared;
  render::Plan plan;
  session::Job job;  ///< what the settings say of it
  std::vector<std::string> warnings;
};

}  // namespace regulus
