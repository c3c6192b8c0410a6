// find_features: what kernels may leave out for this scene.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "interface/energy.h"
#include "interface/wavefront.h"
#include "scene/interfaces.hpp"
#include "scene/scene.hpp"
#include "scene/texture.hpp"
#include "scene/wavelengths.hpp"

namespace regulus::scene {
namespace {

using interface::INVALID_INDEX;

// Cosine below which a vertex normal counts as smooth: further from the geometric normal than rounding puts
// it.
constexpr float FLAT_COSINE = 1.0f - 1e-6f;

/// Least and greatest value of green (a roughness) of a texture.
std::pair<float, float> roughness_range(const Scene& scene, const interface::Texture& texture) {
  return channel_range(scene, texture, 1);
}

uint32_t specular_features(const Scene& scene, const interface::Material& material) {
  if (material.material_class == interface::MATERIAL_CLASS_DIFFUSE) return 0;
  std::pair<float, float> scale(1.0f, 1.0f);
  if (material.metallic_roughness_texture != INVALID_INDEX && material.roughness > 0)
    scale = roughness_range(scene, scene.textures[material.metallic_roughness_texture]);
  uint32_t bits = 0;
  if (material.roughness * scale.second > 0) bits |= interface::FEATURE_ROUGH_SPECULAR;
  if (material.roughness * scale.first == 0) bits |= interface::FEATURE_DELTA_SPECULAR;
  if (material.anisotropy > 0) bits |= interface::FEATURE_ANISOTROPY | interface::FEATURE_ROUGH_SPECULAR;
  if (material.clearcoat > 0) {
    const float roughness = material.clearcoat_roughness;
    std::pair<float, float> range(1.0f, 1.0f);
    if (material.clearcoat_roughness_texture != INVALID_INDEX)
      range = roughness_range(scene, scene.textures[material.clearcoat_roughness_texture]);
    bits |= interface::FEATURE_CLEARCOAT;
    if (roughness * range.second > 0) bits |= interface::FEATURE_ROUGH_SPECULAR;
    if (roughness * range.first == 0) bits |= interface::FEATURE_DELTA_SPECULAR;
  }
  return bits;
}

/// Least roughness between a factor's and a texture's texels.
float least_roughness(const Scene& scene, float factor, uint32_t texture) {
  return texture == INVALID_INDEX ? factor : factor * roughness_range(scene, scene.textures[texture]).first;
}

/// Least index of refraction of what the material bounds, over all wavelengths.
float least_ior(const interface::Material& material) {
  return is_dispersive(material) ? static_cast<float>(dispersed_ior(material, sampled_bends().front()))
                                 : material.ior;
}

void find_sharpest_lobes(const Scene& scene, const interface::Material& material, Features& features) {
  if (material.material_class == interface::MATERIAL_CLASS_DIFFUSE) return;
  const float roughness = least_roughness(scene, material.roughness, material.metallic_roughness_texture);
  float reflection = roughness;
  if (material.clearcoat > 0)
    reflection = std::min(reflection, least_roughness(scene, material.clearcoat_roughness,
                                                      material.clearcoat_roughness_texture));
  features.least_reflection_alpha = std::min(features.least_reflection_alpha, reflection * reflection);
  const bool refracts = material.material_class == interface::MATERIAL_CLASS_TRANSMISSIVE &&
                        (material.flags & interface::MATERIAL_VOLUME) != 0;
  if (!refracts) return;
  // |n - 1| / max(n, 1) is the same from both sides. Where solids touch, the indices that meet may be as near
  // as one likes.
  const float ior = least_ior(material);
  const float bend = scene.solids.has_contacts ? 0 : (ior - 1) / std::max(ior, 1.0f);
  features.least_refraction_alpha = std::min(features.least_refraction_alpha, roughness * roughness * bend);
}

/// True if a diffuse base lies under an interface so rough that its own albedo counts (lib/cover.glsl): from
/// inside a solid at any roughness.
bool has_rough_base(const Scene& scene, const interface::Material& material) {
  if (material.material_class == interface::MATERIAL_CLASS_DIFFUSE || material.specular == 0) return false;
  const bool may_diffuse = (material.metallic < 1 || material.metallic_roughness_texture != INVALID_INDEX) &&
                           (material.transmission < 1 || material.transmission_texture != INVALID_INDEX);
  float roughness = material.anisotropy > 0 ? 1 : material.roughness;
  if (material.anisotropy == 0 && material.metallic_roughness_texture != INVALID_INDEX)
    roughness *= roughness_range(scene, scene.textures[material.metallic_roughness_texture]).second;
  return may_diffuse &&
         roughness > (may_show_base_inside(material) ? 0 : 0.01f * interface::COVER_BEGIN_HUNDREDTHS);
}

uint32_t material_features(const Scene& scene, const interface::Material& material) {
  uint32_t bits = specular_features(scene, material);
  if (has_rough_base(scene, material)) bits |= interface::FEATURE_ROUGH_BASE;
  if (material.sheen_color != glm::vec3(0)) bits |= interface::FEATURE_SHEEN;
  if (material.iridescence > 0) bits |= interface::FEATURE_IRIDESCENCE;
  if (is_dispersive(material)) bits |= interface::FEATURE_DISPERSION;
  for (const uint32_t texture :
       {material.base_color_texture, material.metallic_roughness_texture, material.emissive_texture,
        material.transmission_texture, material.clearcoat_texture, material.clearcoat_roughness_texture,
        material.clearcoat_normal_texture, material.anisotropy_texture, material.sheen_color_texture,
        material.sheen_roughness_texture, material.iridescence_texture,
        material.iridescence_thickness_texture})
    if (texture != INVALID_INDEX) bits |= interface::FEATURE_TEXTURES;
  if (material.specular_texture != INVALID_INDEX || material.specular_color_texture != INVALID_INDEX)
    bits |= interface::FEATURE_SPECULAR_TEXTURES | interface::FEATURE_TEXTURES;
  if (material.normal_texture != INVALID_INDEX)
    bits |= interface::FEATURE_NORMAL_MAPS | interface::FEATURE_SMOOTH_NORMALS | interface::FEATURE_TEXTURES;
  if ((material.flags & interface::MATERIAL_COAT_NORMAL) != 0) bits |= interface::FEATURE_COAT_NORMALS;
  if ((material.flags & (interface::MATERIAL_ALPHA_MASK | interface::MATERIAL_ALPHA_BLEND)) != 0)
    bits |= interface::FEATURE_ALPHA;
  if (material.alpha_texture != INVALID_INDEX) bits |= interface::FEATURE_TEXTURES;
  const bool is_volume = material.material_class == interface::MATERIAL_CLASS_TRANSMISSIVE &&
                         (material.flags & interface::MATERIAL_VOLUME) != 0;
  if (is_volume && material.absorption != glm::vec3(0)) bits |= interface::FEATURE_ABSORPTION;
  return bits;
}

// Conservative: textures may take away what the factors allow, never add to it.
bool is_connectible(const interface::Material& material) {
  const bool has_diffuse = material.metallic < 1 && material.transmission < 1;
  const bool has_rough_coat =
      material.clearcoat > 0 &&
      (material.clearcoat_roughness > 0 || material.clearcoat_roughness_texture != INVALID_INDEX);
  return has_diffuse || has_rough_coat || material.sheen_color != glm::vec3(0) || material.anisotropy > 0 ||
         material.metallic_roughness_texture != INVALID_INDEX || material.roughness > 0 ||
         material.transmission_texture != INVALID_INDEX;
}

uint32_t light_features(const Scene& scene, const interface::Light& light) {
  if (light.kind == interface::LIGHT_TRIANGLE) {
    const bool is_two_sided = (scene.materials[light.material].flags & interface::MATERIAL_DOUBLE_SIDED) != 0;
    return interface::FEATURE_TRIANGLE_LIGHTS | (is_two_sided ? interface::FEATURE_TWO_SIDED_LIGHTS : 0u);
  }
  if (light.kind == interface::LIGHT_ENVIRONMENT)
    return interface::FEATURE_ENVIRONMENT |
           (scene.environment->is_map() ? interface::FEATURE_ENVIRONMENT_MAP : 0u);
  if (light.kind == interface::LIGHT_DIRECTIONAL) return interface::FEATURE_DIRECTIONAL_LIGHTS;
  return interface::FEATURE_POINT_LIGHTS | (light.area > 0 ? interface::FEATURE_LIGHT_RANGES : 0u);
}

bool is_smooth(const Scene& scene, const interface::Triangle& triangle) {
  const interface::Vertex& a = scene.vertices[triangle.v0];
  const interface::Vertex& b = scene.vertices[triangle.v1];
  const interface::Vertex& c = scene.vertices[triangle.v2];
  const glm::vec3 normal = glm::normalize(glm::cross(b.position - a.position, c.position - a.position));
  return glm::dot(normal, a.normal) < FLAT_COSINE || glm::dot(normal, b.normal) < FLAT_COSINE ||
         glm::dot(normal, c.normal) < FLAT_COSINE;
}

/// True if the vertex normals spread on either side: shaders/lib/geometry.glsl, find_bulge.
bool bulges(const Scene& scene, const interface::Triangle& triangle) {
  constexpr float LEAST_BULGE = 1e-3f;
  const std::array corners = {&scene.vertices[triangle.v0], &scene.vertices[triangle.v1],
                              &scene.vertices[triangle.v2]};
  float spread = 0, length = 0;
  for (size_t i = 0; i < 3; ++i) {
    const interface::Vertex &from = *corners[i], &to = *corners[(i + 1) % 3];
    spread += glm::dot(to.position - from.position, to.normal - from.normal);
    length += glm::length(to.position - from.position);
  }
  return std::abs(spread) > LEAST_BULGE * length;
}

}  // namespace

std::span<const FeatureDescription> feature_descriptions() {
  using namespace interface;
  static constexpr std::array DESCRIPTIONS = {
      FeatureDescription{FEATURE_TEXTURES, "textures", "texture look-ups of materials and emitters"},
      FeatureDescription{FEATURE_TEXTURE_MAPPINGS, "texture_mappings",
                         "coordinates that differ between textures"},
      FeatureDescription{FEATURE_UV_SETS, "uv_sets",
                         "materials with more than one set of texture coordinates"},
      FeatureDescription{FEATURE_SPECULAR_TEXTURES, "specular_textures", "textures of specular reflection"},
      FeatureDescription{FEATURE_WIDE_TEXELS, "wide_texels", "texels of 16 bits a channel"},
      FeatureDescription{FEATURE_TRIANGLE_LIGHTS, "triangle_lights",
                         "emission at hits and its weight, sampling of emissive triangles"},
      FeatureDescription{FEATURE_POINT_LIGHTS, "point_lights", "sampling of point and spot lights"},
      FeatureDescription{FEATURE_DIRECTIONAL_LIGHTS, "directional_lights", "sampling of directional lights"},
      FeatureDescription{FEATURE_ROUGH_SPECULAR, "rough_specular",
                         "evaluation and sampling of microfacet lobes"},
      FeatureDescription{FEATURE_ROUGH_BASE, "rough_base",
                         "what rough dielectrics leave to their diffuse base, and its tables"},
      FeatureDescription{FEATURE_DELTA_SPECULAR, "delta_specular", "perfect mirrors and smooth glass"},
      FeatureDescription{FEATURE_ABSORPTION, "absorption", "media along the path and their transmittance"},
      FeatureDescription{FEATURE_MANY_LIGHTS, "many_lights", "the choice among lights"},
      FeatureDescription{FEATURE_SMOOTH_NORMALS, "smooth_normals", "interpolation of vertex normals"},
      FeatureDescription{FEATURE_BULGES, "bulges", "light from beyond the horizon of facets (terminators)"},
      FeatureDescription{FEATURE_TWO_SIDED_LIGHTS, "two_sided_lights", "emission from back faces"},
      FeatureDescription{FEATURE_VERTEX_COLORS, "vertex_colors", "colours of vertices"},
      FeatureDescription{FEATURE_NORMAL_MAPS, "normal_maps", "tangents and normal maps"},
      FeatureDescription{FEATURE_ENVIRONMENT, "environment",
                         "what rays that leave the scene meet, its sampling and its weight"},
      FeatureDescription{FEATURE_ENVIRONMENT_MAP, "environment_map", "look-ups and sampling of a map"},
      FeatureDescription{FEATURE_CLEARCOAT, "clearcoat", "a second microfacet lobe"},
      FeatureDescription{FEATURE_SHEEN, "sheen", "the lobe of fibres on cloth"},
      FeatureDescription{FEATURE_IRIDESCENCE, "iridescence", "thin films and their colours"},
      FeatureDescription{FEATURE_DISPERSION, "dispersion",
                         "a wavelength for each sample, and indices of refraction at it"},
      FeatureDescription{FEATURE_COAT_NORMALS, "coat_normals", "clearcoats whose normal is not the base's"},
      FeatureDescription{FEATURE_ANISOTROPY, "anisotropy", "axes of roughness and the tangents they need"},
      FeatureDescription{FEATURE_ALPHA, "alpha",
                         "the question whether a surface is there, in traversal and light sampling"},
      FeatureDescription{FEATURE_CLIPPING, "clipping", "the planes between which cameras see"},
      FeatureDescription{FEATURE_LIGHT_RANGES, "light_ranges", "the ends of lights of limited range"},
      FeatureDescription{FEATURE_INSTANCES, "instances",
                         "trees of meshes below the scene's, and the placing of their triangles"},
      FeatureDescription{FEATURE_CONTACTS, "contacts",
                         "which solids a path is inside, and the order of surfaces in one place"}};
  return DESCRIPTIONS;
}

bool has_blended_surfaces(const Scene& scene) {
  return std::ranges::any_of(scene.triangles, [&](const interface::Triangle& triangle) {
    return (scene.materials[triangle.material].flags & interface::MATERIAL_ALPHA_BLEND) != 0;
  });
}

Features find_features(const Scene& scene) {
  Features features;
  std::vector<bool> is_used(scene.materials.size(), false);
  bool has_smooth_normals = false, has_bulges = false;
  for (const interface::Triangle& triangle : scene.triangles) {
    is_used[triangle.material] = true;
    has_smooth_normals = has_smooth_normals || is_smooth(scene, triangle);
    has_bulges = has_bulges || bulges(scene, triangle);
  }
  if (has_smooth_normals) features.bits |= interface::FEATURE_SMOOTH_NORMALS;
  if (has_bulges) features.bits |= interface::FEATURE_BULGES | interface::FEATURE_SMOOTH_NORMALS;
  if (!scene.instances.empty()) features.bits |= interface::FEATURE_INSTANCES;
  if (!scene.vertex_colors.empty()) features.bits |= interface::FEATURE_VERTEX_COLORS;
  for (const interface::Texture& texture : scene.textures) {
    if ((texture.flags & interface::TEXTURE_MAPPED) != 0)
      features.bits |= interface::FEATURE_TEXTURE_MAPPINGS;
    if ((texture.flags >> interface::TEXTURE_SET_SHIFT & interface::TEXTURE_SET_MASK) != 0)
      features.bits |= interface::FEATURE_UV_SETS;
    if ((texture.flags & (interface::TEXTURE_UNORM16 | interface::TEXTURE_HALF)) != 0)
      features.bits |= interface::FEATURE_WIDE_TEXELS;
  }
  for (size_t i = 0; i < scene.materials.size(); ++i) {
    if (!is_used[i]) continue;
    features.bits |= material_features(scene, scene.materials[i]);
    find_sharpest_lobes(scene, scene.materials[i], features);
    features.material_classes |= 1u << scene.materials[i].material_class;
    features.has_connectible_surfaces =
        features.has_connectible_surfaces || is_connectible(scene.materials[i]);
  }
  for (const interface::Light& light : scene.lights) features.bits |= light_features(scene, light);
  if (scene.lights.size() > 1) features.bits |= interface::FEATURE_MANY_LIGHTS;
  features.film_exponents = scene.film_exponents;
  if (std::any_of(scene.cameras.begin(), scene.cameras.end(),
                  [](const SceneCamera& camera) { return camera.z_near > 0 || camera.z_far < NO_FAR_PLANE; }))
    features.bits |= interface::FEATURE_CLIPPING;
  if (scene.solids.has_contacts) features.bits |= interface::FEATURE_CONTACTS;
  const auto varies = [](const std::vector<uint32_t>& sets) {
    return std::ranges::find(sets, interface::MEDIA_VARY) != sets.end();
  };
  features.has_varying_starts = varies(scene.solids.of_camera) || varies(scene.solids.of_light);
  return features;
}

}  // namespace regulus::scene
