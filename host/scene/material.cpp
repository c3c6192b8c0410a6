#include "scene/material.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <glm/gtc/packing.hpp>
#include <string>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "scene/specular_glossiness.hpp"
#include "scene/texture.hpp"
#include "scene/uv_mapping.hpp"

namespace regulus::scene {
namespace {

using interface::INVALID_INDEX;
using tinygltf::Value;

constexpr double USUAL_IOR = 1.5;
constexpr double INFINITE_IOR = 1e6;
// From here on an index stands for an infinite one (glTF-Transform writes 1000).
constexpr double LEAST_INFINITE_IOR = 100;
// nm: thicker films have no colours left at any index, and look like this one.
constexpr float THICKEST_FILM = 1e5f;
constexpr uint32_t ALPHA_FLAGS = interface::MATERIAL_ALPHA_MASK | interface::MATERIAL_ALPHA_BLEND;

bool is_unlit(const tinygltf::Material& material) {
  return material.extensions.count("KHR_materials_unlit") != 0;
}

/// Which lobes the material can have: without dielectric reflection (see shaders/lib/bsdf.glsl: F_d = 0
/// when specular is 0 or ior is 1), metal and transmission, Lambert is all.
uint32_t classify(const interface::Material& material) {
  if (material.transmission > 0) return interface::MATERIAL_CLASS_TRANSMISSIVE;
  const bool can_be_metal = material.metallic > 0;  // the texture only scales it
  const bool reflects = material.specular > 0 && material.ior != 1.0f;
  return can_be_metal || reflects || material.clearcoat > 0 || material.sheen_color != glm::vec3(0) ||
                 material.iridescence > 0
             ? interface::MATERIAL_CLASS_OPAQUE
             : interface::MATERIAL_CLASS_DIFFUSE;
}

/// Says what follows from the rest: which lobes the material has, and that only solids disperse.
void finish_material(interface::Material& material) {
  material.material_class = classify(material);
  const bool refracts = material.material_class == interface::MATERIAL_CLASS_TRANSMISSIVE &&
                        (material.flags & interface::MATERIAL_VOLUME) != 0 && material.ior > 1;
  if (!refracts) material.dispersion = 0;
}

/// Converts one material; holds what all its steps need.
class MaterialBuilder {
 public:
  MaterialBuilder(Document& document, const tinygltf::Material& source, std::string name)
      : document_(document), source_(source), name_(std::move(name)) {}

  interface::Material build() {
    interface::Material material = untextured_material();
    const auto& pbr = source_.pbrMetallicRoughness;
    material.base_color = {factor(pbr.baseColorFactor[0], "baseColorFactor"),
                           factor(pbr.baseColorFactor[1], "baseColorFactor"),
                           factor(pbr.baseColorFactor[2], "baseColorFactor")};
    material.metallic = factor(pbr.metallicFactor, "metallicFactor");
    material.roughness = factor(pbr.roughnessFactor, "roughnessFactor");
    set_alpha(material);
    material.normal_scale = in_range(source_.normalTexture.scale, -FLT_MAX, FLT_MAX, "normalTexture scale");
    if (source_.doubleSided) material.flags |= interface::MATERIAL_DOUBLE_SIDED;
    set_dielectric(material);
    set_transmission(material);
    set_dispersion(material);
    set_emission(material);
    set_coat_and_anisotropy(material);
    set_sheen(material);
    set_iridescence(material);
    if (is_unlit(source_)) make_unlit(material);
    return material;
  }

 private:
  const Value* extension(const char* name) const {
    const auto found = source_.extensions.find(name);
    return found != source_.extensions.end() && found->second.IsObject() ? &found->second : nullptr;
  }

  static double number(const Value* extension, const char* member, double otherwise) {
    return extension != nullptr && extension->Has(member) ? extension->Get(member).GetNumberAsDouble()
                                                          : otherwise;
  }

  glm::dvec3 color(const Value* extension, const char* member) const {
    if (extension == nullptr || !extension->Has(member)) return glm::dvec3(1.0);
    const Value& value = extension->Get(member);
    return {value.Get(0).GetNumberAsDouble(), value.Get(1).GetNumberAsDouble(),
            value.Get(2).GetNumberAsDouble()};
  }

  /// Clamps to [low, high] with a warning.
  float in_range(double value, double low, double high, const char* member) {
    const double clamped = std::clamp(value, low, high);
    if (clamped != value)
      document_.mend(fmt::format("{}: {} {:g} is out of range; correct it", name_, member, value),
                     fmt::format("clamped to {:g}", clamped));
    return finite_float(document_, clamped, name_ + ": " + member);
  }

  float factor(double value, const char* member) { return in_range(value, 0, 1, member); }

  void set_dielectric(interface::Material& material) {
    const double ior = number(extension("KHR_materials_ior"), "ior", USUAL_IOR);
    material.ior = ior == 0 ? static_cast<float>(INFINITE_IOR) : in_range(ior, 1, INFINITE_IOR, "ior");
    const Value* specular = extension("KHR_materials_specular");
    material.specular = factor(number(specular, "specularFactor", 1), "specularFactor");
    const glm::dvec3 tint = color(specular, "specularColorFactor");
    for (int i = 0; i < 3; ++i)
      material.specular_color[i] = in_range(tint[i], 0, FLT_MAX, "specularColorFactor");
    if (material.ior >= LEAST_INFINITE_IOR) give_usual_ior(material);
  }

  /// The exact reflectance of an infinite index is 1 in all directions, so it cannot say how the specular
  /// colour, which is then the reflectance at normal incidence, grows towards grazing. Schlick's curve, which
  /// the extensions have there, is close to that of the usual index. Nothing gets through either way, but
  /// what transmits keeps its index.
  void give_usual_ior(interface::Material& material) {
    if (number(extension("KHR_materials_transmission"), "transmissionFactor", 0) > 0) return;
    const auto reflectance = [](double ior) { return (ior - 1) * (ior - 1) / ((ior + 1) * (ior + 1)); };
    const double scale = reflectance(material.ior) / reflectance(USUAL_IOR);
    for (int i = 0; i < 3; ++i)
      material.specular_color[i] =
          in_range(scale * material.specular_color[i], 0, FLT_MAX, "specular colour");
    material.ior = static_cast<float>(USUAL_IOR);
  }

  void set_transmission(interface::Material& material) {
    material.transmission = factor(number(extension("KHR_materials_transmission"), "transmissionFactor", 0),
                                   "transmissionFactor");
    const Value* volume = extension("KHR_materials_volume");
    if (volume == nullptr) return;
    if (volume->Has("thicknessTexture")) ignored("thicknessTexture");
    if (!(number(volume, "thicknessFactor", 0) > 0)) return;
    material.flags |= interface::MATERIAL_VOLUME;
    if (!volume->Has("attenuationDistance")) return;
    const double distance = number(volume, "attenuationDistance", 0);
    if (!(distance > 0))
      return document_.mend(name_ + ": attenuationDistance must be greater than 0; correct it",
                            "no absorption");
    const glm::dvec3 tint = color(volume, "attenuationColor");
    for (int i = 0; i < 3; ++i) {
      // A component of 0 would absorb infinitely fast; the smallest float is as black.
      const double transmitted = std::max<double>(factor(tint[i], "attenuationColor"), FLT_MIN);
      material.absorption[i] =
          finite_float(document_, -std::log(transmitted) / distance, name_ + ": absorption");
    }
  }

  /// 20 over Abbe's number. It concerns solids alone (KHR_materials_dispersion builds upon
  /// KHR_materials_volume).
  void set_dispersion(interface::Material& material) {
    constexpr double LARGEST = 1e6;
    material.dispersion =
        in_range(number(extension("KHR_materials_dispersion"), "dispersion", 0), 0, LARGEST, "dispersion");
  }

  void set_coat_and_anisotropy(interface::Material& material) {
    const Value* coat = extension("KHR_materials_clearcoat");
    material.clearcoat = factor(number(coat, "clearcoatFactor", 0), "clearcoatFactor");
    material.clearcoat_roughness =
        factor(number(coat, "clearcoatRoughnessFactor", 0), "clearcoatRoughnessFactor");
    const bool has_normals = coat != nullptr && coat->Has("clearcoatNormalTexture");
    material.clearcoat_normal_scale =
        in_range(number(has_normals ? &coat->Get("clearcoatNormalTexture") : nullptr, "scale", 1), -FLT_MAX,
                 FLT_MAX, "clearcoatNormalTexture scale");
    const Value* anisotropy = extension("KHR_materials_anisotropy");
    material.anisotropy = factor(number(anisotropy, "anisotropyStrength", 0), "anisotropyStrength");
    const double rotation = number(anisotropy, "anisotropyRotation", 0);
    material.anisotropy_direction = {
        finite_float(document_, std::cos(rotation), name_ + ": anisotropyRotation"),
        finite_float(document_, std::sin(rotation), name_ + ": anisotropyRotation")};
  }

  void set_sheen(interface::Material& material) {
    const Value* sheen = extension("KHR_materials_sheen");
    material.sheen_roughness = factor(number(sheen, "sheenRoughnessFactor", 0), "sheenRoughnessFactor");
    if (sheen == nullptr || !sheen->Has("sheenColorFactor")) return;  // black
    const glm::dvec3 tint = color(sheen, "sheenColorFactor");
    for (int i = 0; i < 3; ++i) material.sheen_color[i] = factor(tint[i], "sheenColorFactor");
  }

  void set_iridescence(interface::Material& material) {
    const Value* film = extension("KHR_materials_iridescence");
    material.iridescence = factor(number(film, "iridescenceFactor", 0), "iridescenceFactor");
    material.iridescence_ior =
        in_range(number(film, "iridescenceIor", 1.3), 1, INFINITE_IOR, "iridescenceIor");
    const auto thickness = [&](const char* member, double otherwise) {
      const float whole = in_range(number(film, member, otherwise), 0, FLT_MAX, member);
      return std::min(whole, THICKEST_FILM);
    };
    material.iridescence_thickness = {thickness("iridescenceThicknessMinimum", 100),
                                      thickness("iridescenceThicknessMaximum", 400)};
  }

  /// The flags say what the file asks for; add_materials clears them where nothing is less than whole.
  void set_alpha(interface::Material& material) {
    material.alpha = factor(source_.pbrMetallicRoughness.baseColorFactor[3], "baseColorFactor alpha");
    material.alpha_cutoff = in_range(source_.alphaCutoff, 0, FLT_MAX, "alphaCutoff");
    if (source_.alphaMode == "MASK") material.flags |= interface::MATERIAL_ALPHA_MASK;
    if (source_.alphaMode == "BLEND") material.flags |= interface::MATERIAL_ALPHA_BLEND;
    if (source_.alphaMode != "MASK" && source_.alphaMode != "BLEND" && source_.alphaMode != "OPAQUE" &&
        !source_.alphaMode.empty())
      document_.mend(fmt::format("{}: alphaMode '{}' is not known; correct it", name_, source_.alphaMode),
                     "opaque");
  }

  void set_emission(interface::Material& material) {
    const double strength = number(extension("KHR_materials_emissive_strength"), "emissiveStrength", 1);
    for (int i = 0; i < 3; ++i)
      material.emission[i] =
          in_range(source_.emissiveFactor[static_cast<size_t>(i)] * strength, 0, FLT_MAX, "emission");
    if (material.emission != glm::vec3(0)) material.flags |= interface::MATERIAL_EMISSIVE;
  }

  /// KHR_materials_unlit: seen in its base colour from both sides whatever the light, that is, black and
  /// glowing. So it lights what is near it, like anything that is seen without being lit.
  static void make_unlit(interface::Material& material) {
    material.emission = material.base_color;
    material.base_color = material.specular_color = glm::vec3(0);
    material.metallic = material.specular = material.transmission = 0;
    material.clearcoat = material.anisotropy = material.iridescence = 0;
    material.sheen_color = glm::vec3(0);
    material.absorption = glm::vec3(0);
    material.flags &= ALPHA_FLAGS;
    material.flags |= interface::MATERIAL_DOUBLE_SIDED | interface::MATERIAL_UNLIT;
    if (material.emission != glm::vec3(0)) material.flags |= interface::MATERIAL_EMISSIVE;
  }

  void ignored(const char* what) { document_.warn(fmt::format("{}: {} is not read", name_, what)); }

  Document& document_;
  const tinygltf::Material& source_;
  std::string name_;
};

/// Attaches the textures of one material. Where one cannot be read, its factor alone stands for base colour,
/// roughness and specular reflection; a texture that says where something is that most surfaces have nowhere
/// (metal, light, transmission, a coat, anisotropy) leaves it out, since factors beside such textures are 1.
class TextureSlots {
 public:
  TextureSlots(Document& document, TextureLoader& loader, const tinygltf::Material& source,
               const MaterialUvs& uvs)
      : document_(document), loader_(loader), source_(source), uvs_(uvs) {}

  void attach(interface::Material& material) {
    const auto& pbr = source_.pbrMetallicRoughness;
    const TextureUse base_color = texture_use(pbr.baseColorTexture);
    if ((material.flags & ALPHA_FLAGS) != 0)
      material.alpha_texture =
          load(base_color, TextureContent::Color, "base colour and alpha by their factors");
    if (is_unlit(source_)) {
      if ((material.flags & interface::MATERIAL_EMISSIVE) != 0)
        material.emissive_texture = load(base_color, TextureContent::Color, "base colour by its factor");
      return;
    }
    material.base_color_texture = load(base_color, TextureContent::Color, "base colour by its factor");
    material.metallic_roughness_texture =
        load(texture_use(pbr.metallicRoughnessTexture), {false, texture_glossiness(source_)},
             "roughness by its factor, no metal", &material.metallic);
    material.normal_texture = load(texture_use(source_.normalTexture), TextureContent::Data, "no bumps");
    if ((material.flags & interface::MATERIAL_EMISSIVE) != 0) attach_emission(material);
    attach_of_extensions(material);
  }

 private:
  void attach_emission(interface::Material& material) {
    float strength = 1;
    material.emissive_texture =
        load(texture_use(source_.emissiveTexture), TextureContent::Color, "no emission", &strength);
    if (strength == 1) return;
    material.emission = glm::vec3(0);
    material.flags &= ~interface::MATERIAL_EMISSIVE;
  }

  void attach_of_extensions(interface::Material& material) {
    const auto data = [&](const char* extension, const char* member, const char* shown,
                          float* factor = nullptr) {
      return load(texture_use(source_, extension, member), TextureContent::Data, shown, factor);
    };
    if (material.specular > 0) {
      material.specular_texture = data("KHR_materials_specular", "specularTexture", "specular by its factor");
      material.specular_color_texture =
          load(texture_use(source_, "KHR_materials_specular", "specularColorTexture"), TextureContent::Color,
               "specular colour by its factor");
    }
    if (material.transmission > 0)
      material.transmission_texture = data("KHR_materials_transmission", "transmissionTexture",
                                           "no transmission", &material.transmission);
    if (material.clearcoat > 0) {
      material.clearcoat_texture =
          data("KHR_materials_clearcoat", "clearcoatTexture", "no clearcoat", &material.clearcoat);
      material.clearcoat_roughness_texture = data("KHR_materials_clearcoat", "clearcoatRoughnessTexture",
                                                  "the clearcoat's roughness by its factor");
      attach_coat_normals(material);
    }
    if (material.sheen_color != glm::vec3(0)) {
      material.sheen_color_texture = load(texture_use(source_, "KHR_materials_sheen", "sheenColorTexture"),
                                          TextureContent::Color, "sheen by its factor");
      material.sheen_roughness_texture =
          data("KHR_materials_sheen", "sheenRoughnessTexture", "the sheen's roughness by its factor");
    }
    if (material.iridescence > 0) {
      material.iridescence_texture =
          data("KHR_materials_iridescence", "iridescenceTexture", "no iridescence", &material.iridescence);
      material.iridescence_thickness_texture =
          data("KHR_materials_iridescence", "iridescenceThicknessTexture",
               "the film as thick as its greatest thickness");
    }
    if (material.anisotropy > 0)
      material.anisotropy_texture =
          data("KHR_materials_anisotropy", "anisotropyTexture", "no anisotropy", &material.anisotropy);
  }

  /// Without a normal map of its own the clearcoat has the vertices' normals, whatever the base has
  /// (KHR_materials_clearcoat); many files give both the same.
  void attach_coat_normals(interface::Material& material) {
    const TextureUse of_base = texture_use(source_.normalTexture);
    const TextureUse of_coat = texture_use(source_, "KHR_materials_clearcoat", "clearcoatNormalTexture");
    if (of_coat.texture == of_base.texture && of_coat.mapping == of_base.mapping &&
        material.clearcoat_normal_scale == material.normal_scale)
      return;
    material.clearcoat_normal_texture = load(of_coat, TextureContent::Data, "no bumps of the clearcoat");
    if (material.clearcoat_normal_texture != INVALID_INDEX || material.normal_texture != INVALID_INDEX)
      material.flags |= interface::MATERIAL_COAT_NORMAL;
  }

  /// @param shown what is shown if it cannot be read; @param factor becomes 0 then, unless it is null
  uint32_t load(const TextureUse& use, TextureContent content, const char* shown, float* factor = nullptr) {
    if (use.texture < 0) return INVALID_INDEX;
    try {
      return loader_.load(use.texture, content, uvs_.placement(use.mapping));
    } catch (const Error& error) {
      document_.mend(error, shown);
      if (factor != nullptr) *factor = 0;
      return INVALID_INDEX;
    }
  }

  Document& document_;
  TextureLoader& loader_;
  const tinygltf::Material& source_;
  MaterialUvs uvs_;
};

/// Materials that are whole everywhere lose their flags: many exporters write BLEND for everything.
void drop_needless_alpha(Scene& scene) {
  float least_of_vertices = 1;
  for (const glm::vec4& color : scene.vertex_colors) least_of_vertices = std::min(least_of_vertices, color.a);
  for (interface::Material& material : scene.materials) {
    if ((material.flags & ALPHA_FLAGS) == 0) continue;
    const float of_texture = material.alpha_texture == INVALID_INDEX
                                 ? 1
                                 : channel_range(scene, scene.textures[material.alpha_texture], 3).first;
    if (of_texture == 1) material.alpha_texture = INVALID_INDEX;
    const float least = material.alpha * of_texture * least_of_vertices;
    const bool is_mask = (material.flags & interface::MATERIAL_ALPHA_MASK) != 0;
    // Interpolation may round the least value down a little.
    const float needed = is_mask ? material.alpha_cutoff * 1.0001f : 1;
    if (least < needed) continue;
    material.flags &= ~ALPHA_FLAGS;
    material.alpha_texture = INVALID_INDEX;
  }
}

/// materials[].extras.regulus.priority: which solid decides where several overlap, see Solids.
float priority(Document& document, size_t index, const std::string& name) {
  const nlohmann::json* value = &document.json["materials"][index];
  for (const char* member : {"extras", "regulus", "priority"}) {
    if (!value->is_object() || !value->contains(member)) return 0;
    value = &(*value)[member];
  }
  if (!value->is_number()) {
    document.warn(name + ": extras.regulus.priority is not a number and is ignored");
    return 0;
  }
  return finite_float(document, value->get<double>(), name + ": extras.regulus.priority");
}

}  // namespace

interface::Material untextured_material() {
  interface::Material material {};
  for (uint32_t* texture :
       {&material.base_color_texture, &material.metallic_roughness_texture, &material.specular_texture,
        &material.specular_color_texture, &material.emissive_texture, &material.transmission_texture,
        &material.normal_texture, &material.alpha_texture, &material.clearcoat_texture,
        &material.clearcoat_roughness_texture, &material.clearcoat_normal_texture,
        &material.anisotropy_texture, &material.sheen_color_texture, &material.sheen_roughness_texture,
        &material.iridescence_texture, &material.iridescence_thickness_texture})
    *texture = INVALID_INDEX;
  return material;
}

bool needs_tangents(const tinygltf::Material& material) {
  if (is_unlit(material)) return false;
  const auto is_positive = [&](const char* extension, const char* factor) {
    const auto found = material.extensions.find(extension);
    return found != material.extensions.end() && found->second.Has(factor) &&
           found->second.Get(factor).GetNumberAsDouble() > 0;
  };
  const TextureUse of_coat = texture_use(material, "KHR_materials_clearcoat", "clearcoatNormalTexture");
  return material.normalTexture.index >= 0 || is_positive("KHR_materials_anisotropy", "anisotropyStrength") ||
         (of_coat.texture >= 0 && is_positive("KHR_materials_clearcoat", "clearcoatFactor"));
}

bool may_emit(const tinygltf::Material& material) {
  const auto& factor = material.emissiveFactor;
  return is_unlit(material) || std::any_of(factor.begin(), factor.end(), [](double x) { return x != 0; });
}

bool may_refract(const tinygltf::Material& material) {
  return material.extensions.count("KHR_materials_transmission") != 0 &&
         material.extensions.count("KHR_materials_volume") != 0;
}

void add_materials(Document& document, Scene& scene, LoadedTextures& loaded) {
  const auto& sources = document.model.materials;
  std::vector<bool> is_used(sources.size() + 1, false);
  for (const interface::Triangle& triangle : scene.triangles) is_used[triangle.material] = true;

  TextureLoader loader(document, scene, loaded);
  for (size_t i = 0; i < sources.size(); ++i) {
    const std::string name = element_name("material", i, sources[i].name);
    interface::Material material = MaterialBuilder(document, sources[i], name).build();
    if (is_used[i]) TextureSlots(document, loader, sources[i], material_uvs(sources[i])).attach(material);
    finish_material(material);
    scene.materials.push_back(material);
    scene.material_names.push_back(sources[i].name);
    scene.material_priorities.push_back(priority(document, i, name));
  }
  if (is_used.back()) {
    tinygltf::Material standard;
    standard.emissiveFactor = {0, 0, 0};
    interface::Material material = MaterialBuilder(document, standard, "default material").build();
    finish_material(material);
    scene.materials.push_back(material);
    scene.material_names.emplace_back();
  }
  drop_needless_alpha(scene);
}

}  // namespace regulus::scene
