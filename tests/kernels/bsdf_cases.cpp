#include "kernels/bsdf_cases.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "render/energy_tables.hpp"
#include "scene/sheen_table.hpp"

namespace regulus::test_kernels {
std::span<const uint32_t> spirv(std::string_view name);
}

namespace regulus::test {

using glm::dvec2;
using glm::dvec3;
using glm::vec3;
using namespace interface;
using reference::Bsdf;
using reference::BsdfParameters;
using reference::TransportMode;

namespace {

constexpr uint32_t NDFS[] = {NDF_GGX, NDF_BECKMANN, NDF_COSINE};
constexpr uint32_t SHADOWINGS[] = {SHADOWING_SMITH, SHADOWING_SMITH_UNCORRELATED, SHADOWING_V_CAVITY};
const char* const NDF_NAMES[] = {"GGX", "Beckmann", "Cosine"};
const char* const SHADOWING_NAMES[] = {"Smith", "Smith uncorrelated", "V-cavity"};
const char* const CLASS_NAMES[] = {"diffuse", "opaque", "transmissive"};

/// A case in double precision, whose inputs can be moved.
struct Inputs {
  BsdfParameters parameters;
  dvec3 wo, wi;
  TransportMode mode;
};

/// Tables of the reference for interfaces of index 1.5.
const reference::EnergyTables* covers_of(const Model& model) {
  static std::map<std::pair<uint32_t, uint32_t>, reference::EnergyTables> all;
  return &all.try_emplace({model.ndf, model.shadowing}, std::vector<float>{1.5f}, model.ndf, model.shadowing)
              .first->second;
}

Inputs inputs_of(const BsdfCase& c, const Model& model) {
  const Material& m = c.material;
  BsdfParameters p;
  p.base_color = dvec3(m.base_color);
  p.alpha = c.alpha.x >= 0 ? glm::dvec2(c.alpha) : glm::dvec2(double{m.roughness * m.roughness});
  p.ndf = model.ndf;
  p.shadowing = model.shadowing;
  p.metallic = m.metallic;
  p.ior = m.ior;
  p.transmission = m.transmission;
  p.specular = m.specular;
  p.specular_color = dvec3(m.specular_color);
  p.clearcoat = m.clearcoat;
  p.coat_alpha = glm::dvec2(double{m.clearcoat_roughness * m.clearcoat_roughness});
  p.is_volume = (m.flags & MATERIAL_VOLUME) != 0;
  p.film_strength = m.iridescence;
  p.film = {std::max(m.iridescence_ior, 1.0f), m.iridescence_thickness.y};
  if (c.sheen != DeviceAddress(0) && m.sheen_color != vec3(0)) {
    static const reference::SheenTable table(scene::make_sheen_table());
    p.sheen = &table;
    p.sheen_color = dvec3(m.sheen_color);
    p.sheen_roughness = reference::sheen_roughness(m.sheen_roughness);
  }
  if (c.tables != DeviceAddress(0)) p.cover = covers_of(model);
  return {p, mirrored_if_back(dvec3(c.wo), c), mirrored_if_back(dvec3(c.wi), c),
          c.mode == 0 ? TransportMode::Radiance : TransportMode::Importance};
}

Evaluation evaluate(const Inputs& inputs) {
  const Bsdf bsdf(inputs.parameters);
  return {bsdf.value(inputs.wo, inputs.wi, inputs.mode), bsdf.pdf(inputs.wo, inputs.wi),
          bsdf.pdf(inputs.wi, inputs.wo)};
}

/// Probabilities of reflection and of transmission at a facet seen under this cosine.
dvec2 facet_choice(const Bsdf& bsdf, double cosine, double eta) {
  const double reflection = bsdf.reflection_probability(cosine, eta);
  return {reflection, 1 - reflection};
}

}  // namespace

double least_choice(const BsdfCase& c, const Model& model) {
  const Inputs inputs = inputs_of(c, model);
  const Bsdf bsdf(inputs.parameters);
  const dvec3 &wo = inputs.wo, &wi = inputs.wi;
  const bool is_transmitted = wo.z * wi.z < 0, is_refracted = is_transmitted && inputs.parameters.is_volume;
  const double eta = bsdf.relative_index(wo);
  const dvec3 h = is_refracted
                      ? reference::refraction_half_vector(wo, wi, eta)
                      : reference::reflection_half_vector(wo, is_transmitted ? dvec3(wi.x, wi.y, -wi.z) : wi);
  double least = std::min(1 - bsdf.diffuse_probability(wo), 1 - bsdf.diffuse_probability(wi));
  if (inputs.parameters.transmission == 0) return least;
  const dvec2 forward = facet_choice(bsdf, std::abs(dot(wo, h)), eta);
  const dvec2 reverse = facet_choice(bsdf, std::abs(dot(wi, h)), bsdf.relative_index(wi));
  return std::min({least, forward[is_transmitted], reverse[is_transmitted]});
}

Constants Model::constants() const {
  // Every feature bit is set: the kernels under test have no code compiled away.
  return {{SPEC_NDF, ndf},
          {SPEC_SHADOWING, shadowing},
          {SPEC_MATERIAL_CLASS, material_class},
          {SPEC_FEATURES, 0xFFFFFFFFu}};
}

std::string Model::name() const {
  return std::string(NDF_NAMES[ndf]) + ", " + SHADOWING_NAMES[shadowing] + ", " + CLASS_NAMES[material_class];
}

uint32_t material_class_of(Kind kind) {
  switch (kind) {
    case Kind::Diffuse:
      return MATERIAL_CLASS_DIFFUSE;
    case Kind::Metal:
    case Kind::Plastic:
      return MATERIAL_CLASS_OPAQUE;
    default:
      return MATERIAL_CLASS_TRANSMISSIVE;
  }
}

std::vector<Model> models_of_class(uint32_t material_class) {
  if (material_class == MATERIAL_CLASS_DIFFUSE) return {{NDF_GGX, SHADOWING_SMITH, material_class}};
  std::vector<Model> models;
  for (const uint32_t ndf : NDFS)
    for (const uint32_t shadowing : SHADOWINGS) models.push_back({ndf, shadowing, material_class});
  return models;
}

Material plain_material(Kind kind, float roughness) {
  Material material{};
  material.base_color = vec3(1);
  material.metallic = kind == Kind::Metal ? 1.0f : kind == Kind::Mixed || kind == Kind::Coated ? 0.25f : 0.0f;
  material.roughness = roughness;
  material.ior = 1.5f;
  material.specular = kind == Kind::Diffuse ? 0.0f : 1.0f;
  material.specular_color = vec3(1);
  material.transmission = kind == Kind::Thin || kind == Kind::Solid     ? 1.0f
                          : kind == Kind::Mixed || kind == Kind::Coated ? 0.5f
                                                                        : 0.0f;
  material.flags = kind == Kind::Solid || kind == Kind::Mixed || kind == Kind::Coated ? MATERIAL_VOLUME : 0u;
  if (kind == Kind::Coated) {
    material.clearcoat = 1;
    material.clearcoat_roughness = 0.65f;
  }
  material.material_class = material_class_of(kind);
  return material;
}

Material random_material(Kind kind, Random& random) {
  Material material = plain_material(kind, 1);
  const auto number = [&](double low, double high) { return static_cast<float>(random.uniform(low, high)); };
  material.base_color = {number(0.02, 1), number(0.02, 1), number(0.02, 1)};
  if (kind == Kind::Diffuse) return material;
  material.specular = random.uniform() < 0.3 ? number(0, 1) : 1.0f;
  if (random.uniform() < 0.3) material.specular_color = {number(0, 2), number(0, 1), number(0, 1)};
  material.ior = random.uniform() < 0.1 ? number(2.5, 4) : number(1.02, 2.5);
  if (kind == Kind::Plastic) material.metallic = random.uniform() < 0.5 ? 0 : number(0, 1);
  if (kind == Kind::Coated) {
    material.clearcoat = number(0.05, 1);
    material.clearcoat_roughness = number(0.2, 1);
  }
  if (kind != Kind::Metal && random.uniform() < 0.3) {
    material.sheen_color = {number(0, 1), number(0.02, 1), number(0, 1)};
    material.sheen_roughness = number(0, 1);
  }
  if (random.uniform() < 0.3) {
    material.iridescence = random.uniform() < 0.5 ? 1 : number(0, 1);
    material.iridescence_ior = number(1, 3);
    material.iridescence_thickness = glm::vec2(number(0, 1200));
  }
  if (kind == Kind::Mixed || kind == Kind::Coated) {
    material.metallic = number(0, 1);
    material.transmission = number(0.05, 1);
    material.flags = random.uniform() < 0.5 ? MATERIAL_VOLUME : 0u;
  }
  return material;
}

dvec3 mirrored_if_back(const dvec3& w, const BsdfCase& c) {
  return {w.x, w.y, c.is_front != 0 ? w.z : -w.z};
}

ReferenceCase reference_case(const BsdfCase& c, const Model& model) {
  const Inputs inputs = inputs_of(c, model);
  return {Bsdf(inputs.parameters), inputs.wo, inputs.wi, inputs.mode};
}

Evaluation evaluate_reference(const BsdfCase& c, const Model& model) {
  return evaluate(inputs_of(c, model));
}

Evaluation conditioning(const BsdfCase& c, const Model& model, double ulps) {
  const double choice_error = ulps * 0x1p-24 / std::max(least_choice(c, model), 1e-300);
  const Inputs inputs = inputs_of(c, model);
  const Evaluation base = evaluate(inputs);
  Evaluation sum{dvec3(0), 0, 0};
  const auto difference_at = [&](const Inputs& moved) -> Evaluation {
    const Evaluation e = evaluate(moved);
    return {abs(e.value - base.value), std::abs(e.pdf_forward - base.pdf_forward),
            std::abs(e.pdf_reverse - base.pdf_reverse)};
  };
  const auto add_larger = [&](const Evaluation& a, const Evaluation& b) {
    sum.value += max(a.value, b.value);
    sum.pdf_forward += std::max(a.pdf_forward, b.pdf_forward);
    sum.pdf_reverse += std::max(a.pdf_reverse, b.pdf_reverse);
  };
  const auto add_effect = [&](const auto& select) {
    Inputs up = inputs, down = inputs;
    select(up) *= 1 + ulps * 0x1p-23;
    select(down) *= 1 - ulps * 0x1p-23;
    add_larger(difference_at(up), difference_at(down));
  };
  // Directions in floats are unit vectors only up to rounding: all components move together.
  Inputs unit = inputs;
  unit.wo = normalize(unit.wo);
  unit.wi = normalize(unit.wi);
  sum = difference_at(unit);
  for (int axis = 0; axis < 3; ++axis) {
    add_effect([axis](Inputs& i) -> double& { return i.wo[axis]; });
    add_effect([axis](Inputs& i) -> double& { return i.wi[axis]; });
  }
  // Both at once: where both directions are at the critical angle a product stays 0 while either does.
  Inputs rises = inputs, falls = inputs;
  rises.wo.z *= 1 + ulps * 0x1p-23;
  rises.wi.z *= 1 + ulps * 0x1p-23;
  falls.wo.z *= 1 - ulps * 0x1p-23;
  falls.wi.z *= 1 - ulps * 0x1p-23;
  add_larger(difference_at(rises), difference_at(falls));
  add_effect([](Inputs& i) -> double& { return i.parameters.ior; });
  for (int axis = 0; axis < 2; ++axis)
    add_effect([axis](Inputs& i) -> double& { return i.parameters.alpha[axis]; });
  for (int axis = 0; axis < 2; ++axis)
    add_effect([axis](Inputs& i) -> double& { return i.parameters.coat_alpha[axis]; });
  // The density of sheen is a power of up to 1 / .07^2 of a sine that is known to a rounding or two.
  if (c.sheen != DeviceAddress(0)) sum.value += 0x1p-23 / (0.07 * 0.07) * base.value;
  if (c.material.iridescence > 0) {
    add_effect([](Inputs& i) -> double& { return i.parameters.film.ior; });
    add_effect([](Inputs& i) -> double& { return i.parameters.film.thickness; });
    Inputs bare = inputs, mirror = inputs;
    bare.parameters.film_strength = mirror.parameters.film_strength = 0;
    mirror.parameters.base_color = dvec3(1);
    mirror.parameters.metallic = 1;
    sum.value += FILM_ERROR * (evaluate(bare).value + evaluate(mirror).value);
  }
  sum.pdf_forward += choice_error * base.pdf_forward;
  sum.pdf_reverse += choice_error * base.pdf_reverse;
  return sum;
}

namespace {

constexpr double PI = 3.14159265358979;

vec3 direction(double theta, double phi) {
  return glm::dvec3(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
}

/// All combinations of extreme material parameters of one kind.
std::vector<Material> extreme_materials(Kind kind) {
  std::vector<Material> materials;
  for (const float alpha : {0.0f, 1e-12f, 1e-7f, 1e-5f, 1e-3f, 0.05f, 0.5f, 1.0f})
    for (const double ior : {1.0, 1 + 1.2e-7, 1.0001, 1.5, 4.0, 10.0, 1e6}) {
      Material material = plain_material(kind, std::sqrt(alpha));
      material.ior = static_cast<float>(ior);
      materials.push_back(material);
    }
  Material black = plain_material(kind, 0.5f);
  black.base_color = vec3(0);
  black.specular = 0;
  materials.push_back(black);
  Material coloured = plain_material(kind, 0.3f);
  coloured.specular_color = {100, 0, 1};
  coloured.ior = 5;
  materials.push_back(coloured);
  if (kind == Kind::Diffuse) return materials;
  for (const float roughness : {0.0f, 1.0f}) {
    Material cloth = plain_material(kind, 0.3f);
    cloth.sheen_color = vec3(1);
    cloth.sheen_roughness = roughness;
    materials.push_back(cloth);
  }
  for (const auto& [ior, thickness] : {std::pair(1.0f, 300.0f), {1.5f, 0.0f}, {1e6f, 1e5f}})
    for (const float roughness : {0.0f, 0.3f}) {
      Material film = plain_material(kind, roughness);
      film.iridescence = 1;
      film.iridescence_ior = ior;
      film.iridescence_thickness = glm::vec2(thickness);
      materials.push_back(film);
    }
  return materials;
}

/// wi that meet wo in the places where formulas divide by zero.
std::vector<vec3> extreme_partners(const vec3& wo, float ior, bool is_front) {
  std::vector<vec3> partners = {
      {-wo.x, -wo.y, wo.z}, wo, -wo, {wo.x, wo.y, -wo.z}, normalize(vec3(-wo.x, -wo.y, 1e-6f))};
  for (const double theta :
       {0.0, 1e-6, 0.7, PI / 2 - 1e-3, PI / 2 - 1e-6, PI / 2 + 1e-6, PI / 2 + 0.1, PI - 1e-6})
    partners.push_back(direction(theta, 2.0));
  // Refraction at the mean normal, and past the critical angle from the dense side.
  const float eta = is_front ? ior : 1 / ior;
  const float sin2 = (wo.x * wo.x + wo.y * wo.y) / (eta * eta);
  partners.push_back({-wo.x / eta, -wo.y / eta, -std::sqrt(std::max(0.0f, 1 - sin2))});
  return partners;
}

}  // namespace

std::vector<BsdfCase> extreme_cases(uint32_t material_class) {
  std::vector<BsdfCase> cases;
  for (const Kind kind : ALL_KINDS) {
    if (material_class_of(kind) != material_class) continue;
    for (const Material& material : extreme_materials(kind))
      for (const bool is_front : {true, false}) {
        const double critical = std::asin(std::min(1.0, 1.0 / material.ior));
        for (const double theta : {0.0, 1e-6, 1e-3, 0.8, critical, std::nextafter(critical, 2.0),
                                   critical - 1e-6, PI / 2 - 1e-3, PI / 2 - 1e-6, PI / 2 + 1e-3}) {
          const vec3 wo = direction(theta, 0.4);
          size_t partner_index = 0;
          for (const vec3& wi : extreme_partners(wo, material.ior, is_front)) {
            BsdfCase c{};
            c.material = material;
            use_sheen(c);
            c.alpha = vec3(-1);
            c.is_front = is_front;
            c.mode = partner_index & 1;
            c.wo = wo;
            c.wi = wi;
            // Corners and edges of the unit cube of random numbers, and its inside.
            const float levels[] = {0, 0x1p-24f, 0.37f, 1 - 0x1p-24f};
            c.u_lobe = levels[partner_index % 4];
            c.u = {levels[(partner_index / 4) % 4], levels[(partner_index * 7 / 3) % 4]};
            ++partner_index;
            cases.push_back(c);
          }
        }
      }
  }
  return cases;
}

gpu::Buffer cover_tables(const Model& model) {
  render::RenderSettings settings;
  settings.ndf = model.ndf;
  settings.shadowing = model.shadowing;
  return render::make_energy_tables(*device(), {plain_material(Kind::Mixed, 1)}, settings,
                                    {.has_rough_bases = true});
}

void use_sheen(BsdfCase& c) {
  static const gpu::Buffer table = gpu::upload_new(*device(), scene::make_sheen_table(), "sheen table");
  if (c.material.sheen_color != vec3(0)) c.sheen = device_address(table.address());
}

gpu::Kernel create_kernel(std::string_view name, const Model& model) {
  return create_batch_kernel(test_kernels::spirv, name, model.constants());
}

}  // namespace regulus::test
