#include "scene/interfaces.hpp"

#include <algorithm>

namespace regulus::scene {

using interface::INVALID_INDEX;

bool bounds_solids(const interface::Material& material) {
  return material.material_class == interface::MATERIAL_CLASS_TRANSMISSIVE &&
         (material.flags & interface::MATERIAL_VOLUME) != 0;
}

bool may_show_base_inside(const interface::Material& material) {
  return bounds_solids(material) &&
         (material.metallic < 1 || material.metallic_roughness_texture != INVALID_INDEX) &&
         (material.transmission < 1 || material.transmission_texture != INVALID_INDEX);
}

std::vector<float> interface_indices(const std::vector<interface::Material>& materials, bool has_contacts) {
  std::vector<float> indices;
  indices.reserve(materials.size());
  for (const interface::Material& material : materials) indices.push_back(material.ior);
  if (has_contacts)
    for (const interface::Material& behind : materials)
      for (const interface::Material& in_front : materials)
        if (bounds_solids(behind) && bounds_solids(in_front))
          indices.push_back(std::max(behind.ior / in_front.ior, in_front.ior / behind.ior));
  std::ranges::sort(indices);
  indices.erase(std::unique(indices.begin(), indices.end()), indices.end());
  return indices;
}

}  // namespace regulus::scene
