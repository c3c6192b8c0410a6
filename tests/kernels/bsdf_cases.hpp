// Inputs of the device tests of the scattering model, and the same inputs for the double-precision reference.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "bsdf_batch.h"
#include "interface/wavefront.h"
#include "reference/bsdf.hpp"
#include "support/device.hpp"
#include "support/random.hpp"

namespace regulus::test {

/// Kinds of material, each with lobes of its own.
enum class Kind { Diffuse, Metal, Plastic, Thin, Solid, Mixed, Coated };
inline constexpr std::array ALL_KINDS = {Kind::Diffuse, Kind::Metal, Kind::Plastic, Kind::Thin,
                                         Kind::Solid,   Kind::Mixed, Kind::Coated};

/// What a kernel is specialized to.
struct Model {
  uint32_t ndf, shadowing, material_class;

  Constants constants() const;
  std::string name() const;
};

uint32_t material_class_of(Kind kind);

/// All distributions and shadowing terms, for one material class.
std::vector<Model> models_of_class(uint32_t material_class);

/// A material of this kind without randomness: white, index 1.5, all weights 1.
interface::Material plain_material(Kind kind, float roughness);

/// A random material of this kind: colours, weights and index vary; roughness is left to the caller.
interface::Material random_material(Kind kind, Random& random);

/// The float directions and material of a case in double precision. In the reference's frame z is the front
/// side; its directions are mirrored when wo is at the back.
struct ReferenceCase {
  reference::Bsdf bsdf;
  glm::dvec3 wo, wi;
  reference::TransportMode mode;
};
ReferenceCase reference_case(const interface::BsdfCase& c, const Model& model);

/// Direction given in the frame of the case (z on wo's side), in the reference's frame, and back.
glm::dvec3 mirrored_if_back(const glm::dvec3& w, const interface::BsdfCase& c);

/// The reference's value and densities of a case.
struct Evaluation {
  glm::dvec3 value;
  double pdf_forward, pdf_reverse;
};
Evaluation evaluate_reference(const interface::BsdfCase& c, const Model& model);

/// The least of the probabilities with which a walk takes the specular lobe, and reflection or transmission
/// in it, in either direction. A walk compares random floats with its complement, so it is known to 2^-24
/// absolute only.
double least_choice(const interface::BsdfCase& c, const Model& model);

/// Change of the reference's evaluation when every input (six direction components, two roughnesses, index)
/// is moved by `ulps` units of float precision, one after the other, summed: what rounding of the inputs
/// alone can do; to the densities what `ulps` units in least_choice() do is added. Channels of the value in
/// x, y, z.
Evaluation conditioning(const interface::BsdfCase& c, const Model& model, double ulps);

/// All kinds of a class where formulas divide by zero: roughness from 0 through 1e-7 to 1, grazing and normal
/// incidence, half vectors at the horizon, indices next to 1 and far from it, the critical angle.
std::vector<interface::BsdfCase> extreme_cases(uint32_t material_class);

/// Covers of diffuse bases for interfaces of index 1.5, from outside and inside: BsdfCase::tables is their
/// address.
gpu::Buffer cover_tables(const Model& model);

/// Error of what a film reflects, as a share of what a mirror would: its colours are sums of waves, whose
/// phases of up to 30 rad are known to six roundings, and red swings by 2 * 1.8.
constexpr double FILM_ERROR = 4e-5;

/// Gives cases whose material has sheen the table of what it reflects.
void use_sheen(interface::BsdfCase& c);

/// The kernel `name` of tests/kernels, specialized.
gpu::Kernel create_kernel(std::string_view name, const Model& model);

}  // namespace regulus::test
