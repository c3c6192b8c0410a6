// Glass whose index of refraction depends on the wavelength (KHR_materials_dispersion; docs/mathematics.md 15). An iteration
// has one wavelength, a function of the seed and the sample's index, for its camera and light paths alike: so connections and
// merges join halves that met the same glass. What a path carries that has scattered at a dispersive interface is multiplied by
// the wavelength's response; other paths depend on no wavelength, and as the response has mean 1 they need none.
#ifndef REGULUS_LIB_DISPERSION_GLSL
#define REGULUS_LIB_DISPERSION_GLSL

#include "lib/buffers.glsl"
#include "lib/rng.glsl"
#include "lib/specialization.glsl"

// A macro as in lib/bsdf_parameters.glsl.
#define has_dispersion() ((spec_features & FEATURE_DISPERSION) != 0u)

// Wavelength.bend of the d line, where every index is the material's own.
const float BEND_OF_D_LINE = 0.0;
// Indices stay between these, however much glass disperses.
const float LEAST_DISPERSED_IOR = 1.0, LARGEST_DISPERSED_IOR = 1e6;

Wavelength wavelength_of(Frame frame, uint iteration) {
  uint number = pcg4d(uvec4(WAVELENGTH_STREAM, 0u, 0u, frame.seed)).x + iteration * WAVELENGTH_STEP;
  return LOAD(WavelengthBuffer, frame.wavelengths, number >> (32u - WAVELENGTH_BITS));
}

// Wavelength.bend of an iteration.
float bend_of(Frame frame, uint iteration) {
  return has_dispersion() ? wavelength_of(frame, iteration).bend : BEND_OF_D_LINE;
}

// What a contribution is multiplied by. is_dispersed: its path has scattered at a dispersive interface.
vec3 response_of(Frame frame, uint iteration, bool is_dispersed) {
  if (!has_dispersion() || !is_dispersed) return vec3(1.0);
  return wavelength_of(frame, iteration).response;
}

// Index of refraction where the d line has `ior`, by Cauchy's equation. dispersion: 20 / V_d.
float dispersed_ior(float ior, float dispersion, float bend) {
  return clamp(ior + (ior - 1.0) * (0.05 * dispersion) * bend, LEAST_DISPERSED_IOR, LARGEST_DISPERSED_IOR);
}

bool has_dispersed(Path path) { return has_dispersion() && (path.number & PATH_DISPERSED) != 0u; }

#endif
