#include "bvh/scene_bvh.hpp"

#include "bvh/two_level.hpp"

namespace regulus::bvh {
namespace {

/// What traversal knows of a triangle.
uint32_t tag_of(const scene::Scene& scene, size_t triangle) {
  using namespace interface;
  const Material& material = scene.materials[scene.triangles[triangle].material];
  uint32_t tag = material.material_class;
  if ((material.flags & (MATERIAL_ALPHA_MASK | MATERIAL_ALPHA_BLEND)) != 0) tag |= TRIANGLE_TAG_ALPHA;
  if ((material.flags & MATERIAL_EMISSIVE) != 0)
    tag |=
        TRIANGLE_TAG_EMITS | ((material.flags & MATERIAL_DOUBLE_SIDED) != 0 ? TRIANGLE_TAG_EMITS_BACK : 0u);
  if (scene.solids.of_triangle.empty()) return tag;
  const uint32_t solid = scene.solids.of_triangle[triangle];
  if (solid == INVALID_INDEX) return tag;
  if (scene.solids.ranked[solid].is_closed) tag |= TRIANGLE_TAG_CLOSED;
  return tag | (solid + 1) << TRIANGLE_TAG_SOLID_SHIFT;
}

}  // namespace

Bvh build_for_scene(scene::Scene& scene) {
  scene::find_solids(scene);
  std::vector<InputTriangle> input;
  input.reserve(scene.triangles.size());
  for (const interface::Triangle& triangle : scene.triangles)
    input.push_back({{scene.vertices[triangle.v0].position, scene.vertices[triangle.v1].position,
                      scene.vertices[triangle.v2].position},
                     tag_of(scene, input.size())});
  Bvh bvh = scene.shared_meshes.empty() ? build(input) : build_two_levels(input, scene);
  scene::reorder_triangles(scene, bvh.order);
  scene::build_lights(scene);
  scene::find_contacts(scene);
  return bvh;
}

}  // namespace regulus::bvh
