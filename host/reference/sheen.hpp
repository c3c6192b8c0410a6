// Sheen by its definition (KHR_materials_sheen), in double precision; nothing here is shared with the
// shaders.
#pragma once

#include <glm/glm.hpp>
#include <utility>
#include <vector>

namespace regulus::reference {

/// D V of white sheen at a facet whose normal has the cosine cos_h, for directions on one side: 1/sr. alpha:
/// perceptual roughness squared. Estevez and Kulla 2017, section 2 and 3.
double sheen_scattering(double cos_h, double cos_o, double cos_i, double alpha);

/// Share of light that white sheen reflects, more than 1 at grazing: int D V cos_i dw_i by quadrature.
double integrated_sheen(double cos_o, double alpha);

/// The same as the model defines it: linear between the nodes of a table (interface/sheen.h).
class SheenTable {
 public:
  explicit SheenTable(std::vector<float> nodes) : nodes_(std::move(nodes)) {}

  double albedo(double cosine, double roughness) const;

 private:
  std::vector<float> nodes_;
};

/// The roughness with which sheen is evaluated for a material's sheen roughness.
double sheen_roughness(double roughness);

}  // namespace regulus::reference
