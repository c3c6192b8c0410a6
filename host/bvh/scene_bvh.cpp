#include "bvh/scene_bvh.hpp"

#include "bvh/two_level.hpp"

namespace regulus::bvh {
namespace {

/// What traversal knows of a material.
uint32_t tag_of(const interface::Material& material) {
  constexpr uint32_t ALPHA = interface::MATERIAL_ALPHA_MASK | interface::MATERIAL_ALPHA_BLEND;
  return material.material_class | ((material.flags & ALPHA) != 0 ? interface::TRIANGLE_TAG_ALPHA : 0u);
}

}  // namespace

Bvh build_for_scene(scene::Scene& scene) {
  std::vector<InputTriangle> input;
  input.reserve(scene.triangles.size());
  for (const interface::Triangle& triangle : scene.triangles)
    input.push_back({{scene.vertices[triangle.v0].position, scene.vertices[triangle.v1].position,
                      scene.vertices[triangle.v2].position},
                     tag_of(scene.materials[triangle.material])});
  Bvh bvh = scene.shared_meshes.empty() ? build(input) : build_two_levels(input, scene);
  scene::reorder_triangles(scene, bvh.order);
  scene::build_lights(scene);
  return bvh;
}

}  // namespace regulus::bvh
