#include "prepared/prepared_scene.hpp"

#include <utility>

#include "bvh/scene_bvh.hpp"

namespace regulus {

PreparedScene prepare(scene::Scene scene) {
  PreparedScene prepared{std::move(scene), {}, {}};
  prepared.bvh = bvh::build_for_scene(prepared.scene);
  prepared.features = scene::find_features(prepared.scene);
  return prepared;
}

}  // namespace regulus
