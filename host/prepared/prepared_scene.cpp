#include "prepared/prepared_scene.hpp"

#include <utility>

#include "bvh/scene_bvh.hpp"
#include "interface/wavefront.h"
#include "scene/sheen_table.hpp"
#include "scene/wavelengths.hpp"

namespace regulus {

PreparedScene prepare(scene::Scene scene) {
  PreparedScene prepared{std::move(scene), {}, {}, {}, {}};
  prepared.bvh = bvh::build_for_scene(prepared.scene);
  prepared.features = scene::find_features(prepared.scene);
  if ((prepared.features.bits & interface::FEATURE_SHEEN) != 0)
    prepared.sheen_table = scene::make_sheen_table();
  if ((prepared.features.bits & interface::FEATURE_DISPERSION) != 0)
    prepared.wavelengths = scene::make_wavelengths();
  return prepared;
}

}  // namespace regulus
