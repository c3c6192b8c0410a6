// build_lights: all lights of the scene, and how one is chosen.
#include <utility>

#include "scene/alias_table.hpp"
#include "scene/light_power.hpp"
#include "scene/scene.hpp"

namespace regulus::scene {
namespace {

/// Lights that can be chosen, with their power.
class LightList {
 public:
  /// Index of the added light, or INVALID_INDEX if it has no power.
  uint32_t add(const interface::Light& light, double power) {
    if (!(power > 0)) return interface::INVALID_INDEX;
    lights_.push_back(light);
    powers_.push_back(power);
    return static_cast<uint32_t>(lights_.size() - 1);
  }

  void move_to(Scene& scene) {
    scene.lights = std::move(lights_);
    scene.light_aliases.clear();
    if (scene.lights.empty()) {
      scene.warnings.emplace_back("the scene has no light");
      return;
    }
    scene.light_aliases = make_alias_table(powers_);
    const std::vector<double> pdf = alias_table_pdf(scene.light_aliases);
    for (size_t i = 0; i < pdf.size(); ++i) scene.lights[i].selection_pdf = static_cast<float>(pdf[i]);
  }

 private:
  std::vector<interface::Light> lights_;
  std::vector<double> powers_;
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

}  // namespace

void build_lights(Scene& scene) {
  LightList list;
  const double scene_radius = 0.5 * glm::length(glm::dvec3(scene.bounds_max) - glm::dvec3(scene.bounds_min));
  for (const interface::Light& light : scene.lights)
    if (light.kind != interface::LIGHT_TRIANGLE) list.add(light, punctual_power(light, scene_radius));
  TrianglePower triangle_power(scene);
  for (uint32_t i = 0; i < scene.triangles.size(); ++i) {
    interface::Triangle& triangle = scene.triangles[i];
    triangle.light = interface::INVALID_INDEX;
    if ((scene.materials[triangle.material].flags & interface::MATERIAL_EMISSIVE) == 0) continue;
    const double area = triangle_area(scene, triangle);
    triangle.light = list.add(triangle_light(scene, i, area), triangle_power(triangle, area));
  }
  list.move_to(scene);
}

}  // namespace regulus::scene
