// The scene in device memory.
#pragma once

#include <memory>

#include "gpu/gpu.hpp"
#include "interface/wavefront.h"
#include "prepared/prepared_scene.hpp"
#include "render/plan.hpp"
#include "render/scene_structure.hpp"

namespace regulus::render {

/// Device copies of everything kernels read of a scene.
class DeviceScene {
 public:
  /// The plan says which camera looks, whether lights are chosen by the tree and energy is compensated; rays
  /// are traced by `rays`: RAYS_SOFTWARE, RAYS_HARDWARE or RAYS_HOST.
  /// @throws Error (Failed) with both numbers if the device has not the memory.
  DeviceScene(gpu::Device& device, const PreparedScene& prepared, const Plan& plan, uint32_t rays);

  /// Writes the addresses of the arrays, the light count and the bounds into a frame.
  void fill(interface::Frame& frame) const;

 private:
  DeviceScene(gpu::Device& device, const PreparedScene& prepared, const scene::Scene& scene, const Plan& plan,
              uint32_t rays);

  gpu::Buffer bvh_nodes_, bvh_triangles_, vertices_, vertex_colors_, vertex_uvs_, vertex_tangents_,
      triangles_, instances_, instance_blocks_, materials_;
  std::vector<gpu::Buffer> images_;
  gpu::Buffer textures_, lights_, light_aliases_, light_pairs_, light_trails_, guided_lights_,
      guided_light_aliases_, guide_nodes_, walk_guide_nodes_, environment_texels_, environment_cdf_,
      energy_tables_, sheen_table_, wavelengths_, solids_, media_sets_, light_media_;
  interface::Environment environment_;
  interface::LightTreeRoot light_tree_;
  uint32_t light_count_, vertex_uv_sets_, stored_triangles_, instance_block_shift_;
  glm::vec3 center_;
  float radius_;
  glm::vec3 walk_guide_corner_, walk_guide_scale_;
  uint32_t camera_media_;                      ///< index of a media set, or MEDIA_VARY
  uint32_t lens_medium_;                       ///< material index, or INVALID_INDEX
  std::unique_ptr<SceneStructure> structure_;  ///< with RAYS_HARDWARE, in place of the tree's nodes
};

}  // namespace regulus::render
