// Tables, in double precision, of the light that a rough interface keeps in single scattering, at nodes of
// roughness and direction and bilinear between them: for energy compensation (Turquin 2019; the model stands
// in shaders/lib/energy.glsl) and for diffuse bases (shaders/lib/cover.glsl).
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "interface/energy.h"
#include "reference/microfacet.hpp"

namespace regulus::reference {

/// The tables of one microfacet model. Nodes are integrated when they are first asked for; safe for threads.
/// The integral over visible normals is part of the model: a mean over NODE_POINTS points of the R3 sequence
/// (Roberts 2018), of refracted() over REFRACTED_POINTS.
class EnergyTables {
 public:
  static constexpr uint32_t NODE_POINTS = 2048;
  static constexpr uint32_t REFRACTED_POINTS = 1024;

  /// Tables for interfaces of these indices of refraction, or if there are more than ENERGY_MAX_INDICES
  /// different ones, for an even choice of them.
  EnergyTables(std::vector<float> indices, uint32_t ndf, uint32_t shadowing);

  /// Number of the tables with the index nearest to `ior`.
  uint32_t nearest(double ior) const;

  /// E: share of even light from a direction that a perfectly reflecting surface reflects. `roughness`:
  /// perceptual.
  double reflected(double cosine, double roughness) const;
  /// 2 int E(c) c dc
  double reflected_mean(double roughness) const;
  /// E': share that a clear solid of the `index`-th index reflects or transmits, from outside or from inside.
  double scattered(uint32_t index, double cosine, double roughness, bool is_inside) const;
  /// How much further than at a smooth surface the mean Fresnel position of facets lies, from outside, and
  /// its mean over directions as E's.
  double fresnel(uint32_t index, double cosine, double roughness) const;
  double fresnel_mean(uint32_t index, double roughness) const;

  /// What an interface of the `index`-th index reflects of even light from a direction, if it reflects F_0 +
  /// s (F_90 - F_0) at Fresnel position s: x F_0 + y (F_90 - F_0). And its mean over directions.
  glm::dvec2 cover(uint32_t index, double cosine, double roughness, bool is_inside) const;
  glm::dvec2 cover_mean(uint32_t index, double roughness, bool is_inside) const;

  /// T: share that a clear interface of the `index`-th index refracts, from outside or from inside.
  double refracted(uint32_t index, double cosine, double roughness, bool is_inside) const;

  /// One node of a plane, `quantity` ENERGY_*, but not of a cover or of refracted().
  double node(uint32_t index, uint32_t quantity, uint32_t direction, uint32_t roughness) const;

 private:
  double plane(uint32_t index, uint32_t quantity, double x, double roughness) const;
  double mean(uint32_t index, uint32_t quantity, double roughness) const;
  double row_mean(uint32_t index, uint32_t quantity, uint32_t row) const;
  double integrate_node(double ior, uint32_t quantity, uint32_t direction, uint32_t row) const;
  glm::dvec2 cover_node(uint32_t index, bool is_inside, uint32_t direction, uint32_t row) const;
  glm::dvec2 cover_row_mean(uint32_t index, bool is_inside, uint32_t row) const;
  double refracted_node(uint32_t index, bool is_inside, uint32_t direction, uint32_t row) const;

  std::vector<float> indices_;
  uint32_t ndf_, shadowing_;
  // By index, plane and node, and by index, plane and row; of covers by index, side, node and coordinate; of
  // refracted() by index, side and node.
  // NaN: not known yet; threads that race store the same number.
  std::unique_ptr<std::atomic<double>[]> nodes_, means_, cover_nodes_, cover_means_, refracted_nodes_;
};

/// Weight of the tables, against the reflectance of a smooth interface, for the base under an interface of
/// this roughness seen from outside.
double cover_share(double roughness);

}  // namespace regulus::reference
