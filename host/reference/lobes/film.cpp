// The thin film on the interface in a Bsdf (KHR_materials_iridescence; ThinFilm has its formulas).
#include <cmath>

#include "base/components.hpp"
#include "reference/bsdf.hpp"

namespace regulus::reference {

using glm::dvec3;

dvec3 Bsdf::film_over(const dvec3& plain, double thin_cosine, const dvec3& metal_gain,
                      double dielectric_gain) const {
  if (parameters_.film_strength == 0) return plain;
  const ThinFilm& film = parameters_.film;
  const dvec3 covered =
      parameters_.metallic * metal_gain * film.reflectance(parameters_.base_color, thin_cosine) +
      (1 - parameters_.metallic) * dielectric_gain * film.reflectance(dielectric_.f0, thin_cosine);
  return glm::mix(plain, covered, parameters_.film_strength);
}

double Bsdf::chosen_reflection(double cosine, double position) const {
  const BsdfParameters& p = parameters_;
  const double schlick = std::pow(1 - cosine, 5);
  const dvec3 of_metal = p.film.mean_reflectance(p.base_color, 1);
  const dvec3 of_dielectric = p.film.mean_reflectance(dielectric_.f0, 1);
  const dvec3 metal =
      glm::mix(fresnel_metal(p.base_color, cosine), glm::mix(of_metal, dvec3(1), schlick), p.film_strength);
  const dvec3 dielectric = glm::mix(dielectric_.at_position(position),
                                    glm::mix(of_dielectric, dvec3(1), position), p.film_strength);
  return luminance(p.metallic * metal + (1 - p.metallic) * dielectric);
}

double Bsdf::chosen_base(const dvec3& color, double position) const {
  const double covered =
      (1 - largest_component(parameters_.film.mean_reflectance(dielectric_.f0, 1))) * (1 - position);
  return luminance(
      color * glm::mix(1.0 - dielectric_.at_position(position), dvec3(covered), parameters_.film_strength));
}

}  // namespace regulus::reference
