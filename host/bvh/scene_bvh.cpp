#include "bvh/scene_bvh.hpp"

namespace regulus::bvh {

Bvh build_for_scene(scene::Scene& scene) {
  std::vector<InputTriangle> input;
  input.reserve(scene.triangles.size());
  for (const interface::Triangle& triangle : scene.triangles)
    input.push_back({{scene.vertices[triangle.v0].position, scene.vertices[triangle.v1].position,
                      scene.vertices[triangle.v2].position},
                     scene.materials[triangle.material].material_class});
  Bvh bvh = build(input);
  scene::reorder_triangles(scene, bvh.order);
  scene::build_lights(scene);
  return bvh;
}

}  // namespace regulus::bvh
