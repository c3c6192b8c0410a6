// What dispersion needs to know of light and of eyes: colour matching, the wavelengths of iterations, and
// indices of refraction at them (docs/mathematics.md 15).
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "interface/scene.h"
#include "interface/wavelengths.h"

namespace regulus::scene {

/// Wavelengths are taken from this range, nm: beyond it the fits below mean nothing, and nobody sees.
constexpr double SHORTEST_WAVELENGTH = 360, LONGEST_WAVELENGTH = 830;

/// Colour matching functions of the CIE's standard observer of 1931 at a wavelength (nm), X, Y, Z, by the fit
/// of Wyman, Sloan and Shirley, "Simple Analytic Approximations to the CIE XYZ Color Matching Functions",
/// JCGT 2013.
glm::dvec3 color_matching(double wavelength);

/// The same in linear Rec. 709, without what is negative: colours beyond its gamut are shown as a display
/// would.
glm::dvec3 clipped_color_matching(double wavelength);

/// The table of the device: WAVELENGTH_COUNT wavelengths, longest last. They are drawn in proportion to the
/// mean of the three responses, each of integral 1; each stands for the range of its share, whose mean
/// response it has.
std::vector<interface::Wavelength> make_wavelengths();

/// True if the index of refraction of what the material bounds depends on the wavelength.
bool is_dispersive(const interface::Material& material);

/// Wavelength.bend from the longest wavelength to the shortest, evenly: what tables by index are made for.
std::vector<float> sampled_bends();

/// Index of refraction of the material at such a bend, by Cauchy's equation as in KHR_materials_dispersion.
double dispersed_ior(const interface::Material& material, double bend);

}  // namespace regulus::scene
