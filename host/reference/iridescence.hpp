// Thin films by their definition (KHR_materials_iridescence), in double precision; nothing here is shared
// with the shaders.
#pragma once

#include <glm/glm.hpp>

namespace regulus::reference {

/// A film on an interface. Cosines are those on the thin side of the interface; base_f0 is what the interface
/// reflects at normal incidence without the film.
struct ThinFilm {
  double ior = 1.3;      ///< at least 1
  double thickness = 0;  ///< nm

  /// Share of light that it reflects, in linear Rec. 709: the appendix of the extension, held within [0, 1].
  glm::dvec3 reflectance(const glm::dvec3& base_f0, double cosine) const;

  /// The same without interference.
  glm::dvec3 mean_reflectance(const glm::dvec3& base_f0, double cosine) const;

  /// Share of light that a surface with these facets leaves to a diffuse base (docs/mathematics.md 14).
  /// is_inside: the light comes from inside a solid.
  double passage(const glm::dvec3& base_f0, double cosine, const glm::dvec2& alpha, bool is_inside) const;

 private:
  struct Channel;
  Channel channel(double base_f0, double cosine) const;
};

}  // namespace regulus::reference
