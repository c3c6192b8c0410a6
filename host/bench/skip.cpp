#include "bench/skip.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "base/error.hpp"
#include "base/median.hpp"
#include "base/process_usage.hpp"
#include "interface/wavefront.h"
#include "prepared/prepared_scene.hpp"
#include "render/renderer.hpp"

namespace regulus::bench {
namespace {

using namespace interface;

constexpr float SPECK_SIZE = 1e-6F;    // of the scene's diagonal
constexpr float NEXT_TO_NONE = 1e-9F;  // radiance, intensity

/// A triangle with a material of its own in a scene that is not prepared yet.
class Speck {
 public:
  explicit Speck(scene::Scene& scene) : scene_(scene) {
    Material plain = scene::untextured_material();
    plain.base_color = glm::vec3(0.5F);
    plain.roughness = 1;
    plain.ior = 1.5F;
    plain.specular_color = glm::vec3(1);
    plain.alpha = 1;
    plain.normal_scale = plain.clearcoat_normal_scale = 1;
    plain.anisotropy_direction = {1, 0};
    const float size = SPECK_SIZE * glm::length(scene.bounds_max - scene.bounds_min);
    const auto first = static_cast<uint32_t>(scene.vertices.size());
    for (const glm::vec2& uv : {glm::vec2(0, 0), glm::vec2(1, 0), glm::vec2(0, 1)})
      scene.vertices.push_back({scene.bounds_min + size * glm::vec3(uv, 0), {0, 0, 1}, uv});
    scene.triangles.push_back({first, first + 1, first + 2, static_cast<uint32_t>(scene.materials.size()),
                               INVALID_INDEX, scene.triangles.empty() ? 0 : scene.triangles.back().instance});
    scene.materials.push_back(plain);
    scene.material_names.emplace_back("speck");
    const auto complete = [&](auto& values, auto value) {
      if (!values.empty()) values.resize(scene.vertices.size(), value);
    };
    complete(scene.vertex_colors, glm::vec4(1));
    scene.vertex_uvs.resize(scene.vertices.size() * scene.vertex_uv_sets, glm::vec2(0));
    complete(scene.vertex_tangents, glm::vec4(1, 0, 0, 1));
  }

  Material& material() { return scene_.materials.back(); }
  scene::Scene& scene() { return scene_; }
  Vertex& vertex() { return scene_.vertices.back(); }

  /// A dielectric whose lobe has this roughness.
  Material& shiny(float roughness) {
    material().specular = 1;
    material().roughness = roughness;
    material().material_class = MATERIAL_CLASS_OPAQUE;
    return material();
  }
  /// All vertex normals, alike.
  void tilt(const glm::vec3& normal) {
    for (size_t i = scene_.vertices.size() - 3; i < scene_.vertices.size(); ++i)
      scene_.vertices[i].normal = glm::normalize(normal);
  }
  /// Clear glass that absorbs.
  void refracts() {
    Material& material = shiny(0);
    material.transmission = 1;
    material.flags |= MATERIAL_VOLUME;
    material.absorption = glm::vec3(1);
    material.material_class = MATERIAL_CLASS_TRANSMISSIVE;
  }
  /// Makes the triangle a closed solid, thinner than what rays can be trusted with.
  void close() {
    const Triangle front = scene_.triangles.back();
    const auto apex = static_cast<uint32_t>(scene_.vertices.size());
    Vertex behind = scene_.vertices[front.v0];
    behind.position.z -= scene_.vertices[front.v1].position.x - behind.position.x;
    scene_.vertices.push_back(behind);
    for (auto* values : {&scene_.vertex_colors, &scene_.vertex_tangents})
      if (!values->empty()) values->push_back(values->back());
    if (!scene_.vertex_uvs.empty()) scene_.vertex_uvs.push_back(scene_.vertex_uvs.back());
    const uint32_t corners[3] = {front.v0, front.v1, front.v2};
    for (size_t i = 0; i < 3; ++i)
      scene_.triangles.push_back(
          {corners[(i + 1) % 3], corners[i], apex, front.material, front.light, front.instance});
  }
  /// One white texel.
  uint32_t texture(uint32_t flags = 0) {
    Texture texture{};
    texture.image = static_cast<uint32_t>(scene_.images.size());
    texture.width = texture.height = 1;
    texture.flags = flags;
    texture.map_u = {1, 0, 0};
    texture.map_v = {0, 1, 0};
    constexpr uint32_t TWO_HALF_ONES = 0x3C003C00, FOUR_CODES = 0xFFFFFFFF;
    if ((flags & TEXTURE_HALF) != 0)
      scene_.images.push_back({TWO_HALF_ONES, TWO_HALF_ONES});
    else
      scene_.images.push_back({FOUR_CODES});
    scene_.textures.push_back(texture);
    return static_cast<uint32_t>(scene_.textures.size() - 1);
  }
  void emits(uint32_t flags) {
    material().emission = glm::vec3(NEXT_TO_NONE);
    material().flags |= MATERIAL_EMISSIVE | flags;
  }
  void light(uint32_t kind) {
    Light light{};
    light.kind = kind;
    light.position = scene_.bounds_min;
    light.direction = {0, -1, 0};
    light.intensity = glm::vec3(NEXT_TO_NONE);
    scene_.lights.push_back(light);
  }

 private:
  scene::Scene& scene_;
};

using Addition = std::function<void(Speck&)>;

const std::map<uint32_t, Addition>& additions() {
  static const std::map<uint32_t, Addition> table = {
      {FEATURE_TEXTURES, [](Speck& s) { s.material().base_color_texture = s.texture(); }},
      {FEATURE_TEXTURE_MAPPINGS,
       [](Speck& s) { s.material().base_color_texture = s.texture(TEXTURE_MAPPED); }},
      {FEATURE_WIDE_TEXELS, [](Speck& s) { s.material().base_color_texture = s.texture(TEXTURE_HALF); }},
      {FEATURE_UV_SETS,
       [](Speck& s) {
         s.scene().vertex_uv_sets = 1;
         s.scene().vertex_uvs.resize(s.scene().vertices.size(), glm::vec2(0));
         s.material().base_color_texture = s.texture(1U << TEXTURE_SET_SHIFT);
       }},
      {FEATURE_SPECULAR_TEXTURES, [](Speck& s) { s.shiny(0.5F).specular_texture = s.texture(); }},
      {FEATURE_TRIANGLE_LIGHTS, [](Speck& s) { s.emits(0); }},
      {FEATURE_TWO_SIDED_LIGHTS, [](Speck& s) { s.emits(MATERIAL_DOUBLE_SIDED); }},
      {FEATURE_MANY_LIGHTS, [](Speck& s) { s.light(LIGHT_POINT); }},
      {FEATURE_POINT_LIGHTS, [](Speck& s) { s.light(LIGHT_POINT); }},
      {FEATURE_LIGHT_RANGES,
       [](Speck& s) {
         s.light(LIGHT_POINT);
         s.scene().lights.back().area = 1;
       }},
      {FEATURE_CLIPPING, [](Speck& s) { s.scene().cameras.front().z_far = 1e30F; }},
      {FEATURE_DIRECTIONAL_LIGHTS, [](Speck& s) { s.light(LIGHT_DIRECTIONAL); }},
      {FEATURE_ROUGH_SPECULAR, [](Speck& s) { s.shiny(0.05F); }},
      {FEATURE_ROUGH_BASE, [](Speck& s) { s.shiny(0.5F); }},
      {FEATURE_DELTA_SPECULAR, [](Speck& s) { s.shiny(0); }},
      {FEATURE_ABSORPTION, [](Speck& s) { s.refracts(); }},
      {FEATURE_CONTACTS,
       [](Speck& s) {
         s.refracts();
         s.close();
       }},
      {FEATURE_SMOOTH_NORMALS,
       [](Speck& s) {
         s.tilt({0.1F, 0, 1});
       }},
      {FEATURE_BULGES, [](Speck& s) { s.vertex().normal = glm::normalize(glm::vec3(0, 0.1F, 1)); }},
      {FEATURE_VERTEX_COLORS,
       [](Speck& s) { s.scene().vertex_colors.resize(s.scene().vertices.size(), glm::vec4(1)); }},
      {FEATURE_NORMAL_MAPS,
       [](Speck& s) {
         s.scene().vertex_tangents.resize(s.scene().vertices.size(), glm::vec4(1, 0, 0, 1));
         s.material().normal_texture = s.texture();
       }},
      {FEATURE_ALPHA,
       [](Speck& s) {
         s.material().alpha = 0.5F;
         s.material().flags |= MATERIAL_ALPHA_BLEND;
       }},
      {FEATURE_CLEARCOAT,
       [](Speck& s) {
         s.shiny(0.5F).clearcoat = 1;
         s.material().clearcoat_roughness = 0.5F;
       }},
      {FEATURE_COAT_NORMALS,
       [](Speck& s) {
         s.shiny(0.5F).clearcoat = 1;
         s.material().clearcoat_roughness = 0.5F;
         s.material().flags |= MATERIAL_COAT_NORMAL;
       }},
      {FEATURE_IRIDESCENCE,
       [](Speck& s) {
         s.shiny(0.5F).iridescence = 1;
         s.material().iridescence_ior = 1.3F;
         s.material().iridescence_thickness = {100, 400};
       }},
      {FEATURE_DISPERSION,
       [](Speck& s) {
         s.refracts();
         s.material().absorption = glm::vec3(0);
         s.material().dispersion = 1;
       }},
      {FEATURE_SHEEN, [](Speck& s) { s.shiny(0.5F).sheen_color = glm::vec3(0.1F); }},
      {FEATURE_ANISOTROPY, [](Speck& s) {
         s.scene().vertex_tangents.resize(s.scene().vertices.size(), glm::vec4(1, 0, 0, 1));
         s.shiny(0.5F).anisotropy = 0.5F;
       }}};
  return table;
}

/// A scene, ready to be rendered again and again.
class Subject {
 public:
  Subject(gpu::Device& device, scene::Scene scene, const render::RenderSettings& settings,
          const SkipBudget& budget)
      : device_(device), prepared_(prepare(std::move(scene))), settings_(settings), budget_(budget) {
    render::RenderSettings warm_up = settings;
    warm_up.samples = 1;
    render(warm_up);
  }

  /// CPU seconds of one render without what precedes it.
  double seconds() { return render(settings_); }
  /// Device memory without the nodes of the tree.
  uint64_t bytes() const { return bytes_; }
  uint64_t bytes_per_path() const { return bytes_per_path_; }

 private:
  double render(const render::RenderSettings& settings) {
    const uint64_t before = device_.allocated_bytes();
    render::Renderer renderer(device_, prepared_, make_plan(prepared_, settings));
    const double start = process_cpu_seconds();
    renderer.render([&](uint64_t, uint64_t) { return !budget_.is_interrupted || !budget_.is_interrupted(); });
    if (budget_.is_interrupted && budget_.is_interrupted())
      throw Error(ErrorCode::Interrupted, "interrupted");
    bytes_ = device_.allocated_bytes() - before - prepared_.bvh.nodes.size() * sizeof(prepared_.bvh.nodes[0]);
    bytes_per_path_ = renderer.statistics().bytes_per_path;
    return process_cpu_seconds() - start;
  }

  gpu::Device& device_;
  PreparedScene prepared_;
  const render::RenderSettings& settings_;
  const SkipBudget& budget_;
  uint64_t bytes_ = 0, bytes_per_path_ = 0;
};

}  // namespace

bool add_unused_feature(scene::Scene& scene, uint32_t feature) {
  const auto found = additions().find(feature);
  if (found == additions().end()) return false;
  Speck speck(scene);
  found->second(speck);
  return true;
}

SkipReport measure_skipped(gpu::Device& device, const scene::Scene& scene,
                           const render::RenderSettings& settings, const SkipBudget& budget) {
  Subject plain(device, scene, settings, budget);
  const PreparedScene prepared = prepare(scene);
  const uint32_t present = prepared.features.bits;

  SkipReport report;
  report.bytes_per_path = plain.bytes_per_path();
  std::vector<double> seconds, noise;
  for (const scene::FeatureDescription& feature : scene::feature_descriptions()) {
    scene::Scene changed = scene;
    changed.environment = prepared.scene.environment;  // what a scene without lights gets
    if ((present & feature.bit) != 0 || !add_unused_feature(changed, feature.bit)) continue;
    Subject subject(device, std::move(changed), settings, budget);
    std::vector<double> ratios;
    for (uint32_t repeat = 0; repeat < budget.repeats; ++repeat) {
      const double first = plain.seconds(), with = subject.seconds(), second = plain.seconds();
      ratios.push_back(2 * with / (first + second));
      noise.push_back(std::abs(first / second - 1));
      seconds.push_back(first);
    }
    const auto [least, greatest] = std::ranges::minmax(ratios);
    report.features.push_back({feature.name, median(ratios), least, greatest,
                               static_cast<int64_t>(subject.bytes()) - static_cast<int64_t>(plain.bytes()),
                               subject.bytes_per_path()});
  }
  if (!seconds.empty()) {
    report.seconds = median(seconds);
    report.noise = median(noise);
  }
  return report;
}

}  // namespace regulus::bench
