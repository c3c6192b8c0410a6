// The scene in device memory.
#pragma once

#include "bvh/bvh.hpp"
#include "gpu/gpu.hpp"
#include "interface/wavefront.h"
#include "render/settings.hpp"
#include "scene/scene.hpp"

namespace regulus::render {

/// Device copies of everything kernels read of a scene.
class DeviceScene {
 public:
  /// `settings` (resolved) say whether lights are chosen by the tree and energy is compensated.
  /// @throws Error (Failed) with both numbers if the device has not the memory.
  DeviceScene(gpu::Device& device, const scene::Scene& scene, const bvh::Bvh& bvh,
              const RenderSettings& settings);

  /// Writes the addresses of the arrays, the light count and the bounds into a frame.
  void fill(interface::Frame& frame) const;

  /// True if rays that leave the scene meet light.
  bool has_environment() const { return has_environment_; }

  /// FEATURE_CONTACTS
  bool has_contacts() const { return has_contacts_; }

 private:
  gpu::Buffer bvh_nodes_, bvh_triangles_, vertices_, vertex_colors_, vertex_uvs_, vertex_tangents_,
      triangles_, instances_, instance_blocks_, materials_;
  std::vector<gpu::Buffer> images_;
  gpu::Buffer textures_, lights_, light_aliases_, light_pairs_, light_trails_, environment_texels_,
      environment_cdf_, energy_tables_, solids_, media_sets_, light_media_;
  interface::Environment environment_;
  interface::LightTreeRoot light_tree_;
  bool has_environment_;
  uint32_t light_count_, vertex_uv_sets_, stored_triangles_, instance_block_shift_;
  glm::vec3 center_;
  float radius_;
  bool has_contacts_;
  uint32_t camera_media_;
};

}  // namespace regulus::render
