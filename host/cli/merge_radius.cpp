#include "cli/merge_radius.hpp"

#include <fmt/format.h>

#include "cli/render_options.hpp"

namespace regulus::cli {

reference::SeenSurfaces seen_by_camera(const scene::Scene& scene, const bvh::Bvh& bvh, uint32_t camera) {
  const glm::uvec2 film = default_size(scene, camera);
  return see_surfaces(reference::World(scene, bvh), scene.cameras.at(camera), film.x, film.y);
}

std::string choose_merge_radius(const scene::Scene& scene, const bvh::Bvh& bvh,
                                render::RenderSettings& settings) {
  const double scene_radius = 0.5 * glm::length(glm::dvec3(scene.bounds_max) - glm::dvec3(scene.bounds_min));
  const reference::SeenSurfaces seen = seen_by_camera(scene, bvh, settings.camera);
  const float asked = settings.merge_radius >= 0
                          ? settings.merge_radius
                          : reference::radius_of_share(-settings.merge_radius, seen, scene_radius);
  const reference::MergeRadius chosen =
      asked == 0 ? default_merge_radius(seen, scene_radius) : given_merge_radius(asked, seen, scene_radius);
  settings.merge_radius = chosen.metres;
  settings.merge_radius_rule = chosen.rule;
  if (asked == 0 || chosen.metres == asked) return "";
  return fmt::format("--merge-radius {:g} m does not suit a view of {:.3g} m: {:g} m ({})", asked,
                     2 * seen.extent, chosen.metres, chosen.rule);
}

std::string choose_needed_merge_radius(const scene::Scene& scene, const bvh::Bvh& bvh,
                                       render::RenderSettings& settings) {
  if ((settings.techniques & interface::TECHNIQUE_MERGE) != 0)
    return choose_merge_radius(scene, bvh, settings);
  settings.merge_radius = 0;
  return "";
}

}  // namespace regulus::cli
