// Sheen in a Bsdf (KHR_materials_sheen; SheenTable and sheen_scattering have its formulas).
#include <algorithm>
#include <cmath>

#include "reference/bsdf.hpp"

namespace regulus::reference {

using glm::dvec3;

double Bsdf::largest_sheen(const dvec3& w) const {
  if (parameters_.sheen == nullptr || (refracts() && w.z < 0)) return 0;
  const dvec3& color = parameters_.sheen_color;
  return std::max({color.r, color.g, color.b});
}

double Bsdf::sheen_albedo(const dvec3& w) const {
  return std::min(parameters_.sheen->albedo(std::abs(w.z), parameters_.sheen_roughness), 1.0);
}

double Bsdf::sheen_passage(const dvec3& wo, const dvec3& wi) const {
  if (parameters_.sheen == nullptr) return 1;
  return 1 - std::max(largest_sheen(wo) * sheen_albedo(wo), largest_sheen(wi) * sheen_albedo(wi));
}

/// Where white sheen would reflect more than there is it is scaled down, by the larger of both directions.
dvec3 Bsdf::sheen_value(const dvec3& wo, const dvec3& wi) const {
  if (largest_sheen(wo) == 0 || wo.z * wi.z <= 0 || is_in_relief_shadow_) return dvec3(0);
  const double alpha = parameters_.sheen_roughness * parameters_.sheen_roughness;
  const double most = std::max(parameters_.sheen->albedo(std::abs(wo.z), parameters_.sheen_roughness),
                               parameters_.sheen->albedo(std::abs(wi.z), parameters_.sheen_roughness));
  const double cos_h = std::min(std::abs(reflection_half_vector(wo, wi).z), 1.0);
  return parameters_.sheen_color *
         (sheen_scattering(cos_h, std::abs(wo.z), std::abs(wi.z), alpha) / std::max(most, 1.0));
}

Bsdf::Layers Bsdf::layers(const dvec3& w) const {
  const auto [diffuse, facets] = shares(w);
  if (largest_sheen(w) == 0) return {0, diffuse, facets};
  const double passed = 1 - largest_sheen(w) * sheen_albedo(w);
  return {luminance(parameters_.sheen_color) * sheen_albedo(w), passed * diffuse, passed * facets};
}

/// Of the diffuse lobe's samples.
double Bsdf::sheen_share(const dvec3& w) const {
  const auto [sheen, diffuse, facets] = layers(w);
  return sheen > 0 ? sheen / (sheen + diffuse) : 0;
}

}  // namespace regulus::reference
