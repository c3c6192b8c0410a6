#include "scene/interfaces.hpp"

#include <algorithm>

#include "scene/wavelengths.hpp"

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

namespace {

/// Adds the indices of interfaces of dispersive materials at wavelengths from the longest to the shortest.
void add_dispersed(const std::vector<interface::Material>& materials, bool has_contacts,
                   std::vector<float>& indices) {
  if (std::ranges::none_of(materials, is_dispersive)) return;
  const auto add = [&](const interface::Material& behind, const interface::Material* in_front) {
    for (const float bend : sampled_bends()) {
      const double ratio =
          dispersed_ior(behind, bend) / (in_front == nullptr ? 1 : dispersed_ior(*in_front, bend));
      indices.push_back(static_cast<float>(std::max(ratio, 1 / ratio)));
    }
  };
  for (const interface::Material& behind : materials) {
    if (is_dispersive(behind)) add(behind, nullptr);
    for (const interface::Material& in_front : materials)
      if (has_contacts && bounds_solids(behind) && bounds_solids(in_front) &&
          (is_dispersive(behind) || is_dispersive(in_front)))
        add(behind, &in_front);
  }
}

}  // namespace

std::vector<float> interface_indices(const std::vector<interface::Material>& materials, bool has_contacts) {
  std::vector<float> indices;
  indices.reserve(materials.size());
  for (const interface::Material& material : materials) indices.push_back(material.ior);
  if (has_contacts)
    for (const interface::Material& behind : materials)
      for (const interface::Material& in_front : materials)
        if (bounds_solids(behind) && bounds_solids(in_front))
          indices.push_back(std::max(behind.ior / in_front.ior, in_front.ior / behind.ior));
  add_dispersed(materials, has_contacts, indices);
  std::ranges::sort(indices);
  indices.erase(std::unique(indices.begin(), indices.end()), indices.end());
  return indices;
}

}  // namespace regulus::scene
