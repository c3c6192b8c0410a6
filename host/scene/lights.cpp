// build_lights: all lights of the scene, and how one is chosen.
#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <limits>
#include <utility>

#include "scene/alias_table.hpp"
#include "scene/film_exponents.hpp"
#include "scene/light_power.hpp"
#include "scene/light_tree.hpp"
#include "scene/scene.hpp"

namespace regulus::scene {
namespace {

bool is_distant(const interface::Light& light) {
  return light.kind == interface::LIGHT_DIRECTIONAL || light.kind == interface::LIGHT_ENVIRONMENT;
}

/// Lights that can be chosen, with their power.
class LightList {
 public:
  /// Index of the added light, or INVALID_INDEX if it has no power.
  uint32_t add(const interface::Light& light, double power, uint32_t node, const LightBounds& bounds = {}) {
    if (!(power > 0)) return interface::INVALID_INDEX;
    lights_.push_back(light);
    nodes_.push_back(node);
    powers_.push_back(power);
    for_tree_.push_back({is_distant(light), bounds, power});
    return static_cast<uint32_t>(lights_.size() - 1);
  }

  bool is_empty() const { return lights_.empty(); }

  void move_to(Scene& scene) {
    scene.lights = std::move(lights_);
    scene.light_nodes = std::move(nodes_);
    scene.light_aliases.clear();
    scene.light_tree = build_light_tree(for_tree_);
    if (scene.lights.empty()) {
      scene.warnings.emplace_back("the scene has no light: the picture will be black");
      return;
    }
    scene.light_aliases = make_alias_table(powers_);
    const std::vector<double> pdf = alias_table_pdf(scene.light_aliases);
    for (size_t i = 0; i < pdf.size(); ++i) scene.lights[i].selection_pdf = static_cast<float>(pdf[i]);
  }

 private:
  std::vector<interface::Light> lights_;
  std::vector<uint32_t> nodes_;
  std::vector<double> powers_;
  std::vector<TreeLight> for_tree_;
};

interface::Light triangle_light(const Scene& scene, uint32_t index, double area) {
  interface::Light light {};
  light.kind = interface::LIGHT_TRIANGLE;
  light.triangle = index;
  light.material = scene.triangles[index].material;
  light.intensity = scene.materials[light.material].emission;
  light.area = static_cast<float>(area);
  return light;
}

LightBounds punctual_bounds(const interface::Light& light) {
  LightBounds bounds;
  bounds.lower = bounds.upper = glm::dvec3(light.position);
  bounds.intensity = luminance(glm::dvec3(light.intensity));
  bounds.theta_o = glm::pi<double>();
  bounds.theta_e = glm::half_pi<double>();
  if (light.kind != interface::LIGHT_SPOT) return bounds;
  bounds.axis = glm::normalize(glm::dvec3(light.direction));
  const auto angle_of = [](double height) { return 2 * std::asin(std::sqrt(std::min(height / 2, 1.0))); };
  bounds.theta_o = angle_of(light.inner_height);
  bounds.theta_e = angle_of(light.outer_height) - bounds.theta_o;
  return bounds;
}

LightBounds triangle_bounds(const Scene& scene, const interface::Triangle& triangle, double power) {
  const glm::dvec3 p0(scene.vertices[triangle.v0].position);
  const glm::dvec3 p1(scene.vertices[triangle.v1].position);
  const glm::dvec3 p2(scene.vertices[triangle.v2].position);
  LightBounds bounds;
  bounds.lower = glm::min(p0, glm::min(p1, p2));
  bounds.upper = glm::max(p0, glm::max(p1, p2));
  bounds.axis = glm::normalize(glm::cross(p1 - p0, p2 - p0));
  bounds.theta_e = glm::half_pi<double>();
  bounds.is_two_sided = (scene.materials[triangle.material].flags & interface::MATERIAL_DOUBLE_SIDED) != 0;
  bounds.intensity = power / (glm::pi<double>() * (bounds.is_two_sided ? 2 : 1));
  return bounds;
}

// Light from everywhere: what is left of a light's fields does not apply.
interface::Light environment_light() {
  interface::Light light {};
  light.kind = interface::LIGHT_ENVIRONMENT;
  light.triangle = light.material = interface::INVALID_INDEX;
  return light;
}

bool is_punctual(const interface::Light& light) {
  return light.kind != interface::LIGHT_TRIANGLE && light.kind != interface::LIGHT_ENVIRONMENT;
}

/// Of what comes from no file there are none.
uint32_t entry_of(const std::vector<uint32_t>& nodes, size_t index) {
  return index < nodes.size() ? nodes[index] : interface::INVALID_INDEX;
}

/// By material that shows light: m^2 of its triangles; infinite if some are shared by copies.
std::vector<double> shining_areas(const Scene& scene) {
  std::vector<double> areas(scene.materials.size(), 0);
  size_t shared = 0;
  for (const SharedMesh& mesh : scene.shared_meshes) shared += mesh.triangle_count;
  for (size_t i = 0; i < scene.triangles.size(); ++i) {
    const uint32_t material = scene.triangles[i].material;
    if (scene.materials[material].emission == glm::vec3(0)) continue;
    areas[material] +=
        i < shared ? std::numeric_limits<double>::infinity() : triangle_area(scene, scene.triangles[i]);
  }
  return areas;
}

}  // namespace

void build_lights(Scene& scene) {
  LightList list;
  const double scene_radius = 0.5 * glm::length(glm::dvec3(scene.bounds_max) - glm::dvec3(scene.bounds_min));
  FilmRange film_range(0.5 * (glm::dvec3(scene.bounds_min) + glm::dvec3(scene.bounds_max)), scene_radius);
  const std::vector<double> areas = shining_areas(scene);
  for (size_t i = 0; i < scene.materials.size(); ++i)
    film_range.add_visible(glm::dvec3(scene.materials[i].emission), areas[i]);
  for (size_t i = 0; i < scene.lights.size(); ++i) {
    const interface::Light& light = scene.lights[i];
    if (!is_punctual(light)) continue;
    list.add(light, punctual_power(light, scene_radius), entry_of(scene.light_nodes, i),
             punctual_bounds(light));
    film_range.add_punctual(light);
  }
  // One that is dark counts: an animation may have turned it off.
  bool has_lamps = std::ranges::any_of(scene.lights, is_punctual);
  TrianglePower triangle_power(scene);
  for (uint32_t i = 0; i < scene.triangles.size(); ++i) {
    interface::Triangle& triangle = scene.triangles[i];
    triangle.light = interface::INVALID_INDEX;
    if ((scene.materials[triangle.material].flags & interface::MATERIAL_EMISSIVE) == 0) continue;
    const double area = triangle_area(scene, triangle);
    const double power = triangle_power(triangle, area);
    triangle.light =
        list.add(triangle_light(scene, i, area), power, entry_of(scene.place_nodes, triangle.instance),
                 triangle_bounds(scene, triangle, power));
    film_range.add_power(power);
    has_lamps |= triangle.light != interface::INVALID_INDEX &&
                 scene.materials[triangle.material].emissive_texture == interface::INVALID_INDEX;
  }
  // Textures that glow are the displays and signs of a model; its file leaves the light to the viewer.
  if (!has_lamps && !scene.environment) {
    scene.warnings.emplace_back(
        list.is_empty()
            ? "the scene has no light: a dim uniform environment lights it"
            : "only textures emit light here: a dim uniform environment lights the scene as well");
    scene.environment = uniform_environment(glm::vec3(DIM_RADIANCE));
  }
  uint32_t environment = interface::INVALID_INDEX;
  if (scene.environment) {
    environment = list.add(environment_light(), environment_power(*scene.environment, scene_radius),
                           interface::INVALID_INDEX);
    film_range.add_environment(*scene.environment);
  }
  scene.film_exponents = film_range.exponents();
  list.move_to(scene);
  if (environment == interface::INVALID_INDEX) return;
  scene.environment->parameters.selection_pdf = scene.lights[environment].selection_pdf;
  scene.environment->parameters.light = environment;
}

}  // namespace regulus::scene
