// The wavelength of an iteration, from its definition (docs/mathematics.md 15). With the device it shares the
// colour matching functions and nothing else.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "interface/scene.h"

namespace regulus::reference {

/// What dispersion makes of light.
struct Wavelength {
  double nanometres = 587.56;  ///< the d line, where indices are those of the materials
  glm::dvec3 response{1};      ///< factor on paths that scatter at dispersive interfaces
};

/// That of an iteration of a render with this seed.
Wavelength wavelength_of(uint32_t seed, uint32_t iteration);

/// The `number`-th of WAVELENGTH_COUNT equally likely wavelengths.
Wavelength numbered_wavelength(uint32_t number);

/// Index of refraction of what the material bounds, by n = A + B / lambda^2 through n_d with the Abbe number
/// V_d = 20 / dispersion. At the d line, and without dispersion, the material's own.
double index_at(const interface::Material& material, const Wavelength& wavelength);

}  // namespace regulus::reference
