#include "render/walk_guide_choice.hpp"

#include <fmt/format.h>

#include "probe/light_guide.hpp"
#include "probe/walk_guide.hpp"
#include "reference/world.hpp"
#include "render/light_guide_choice.hpp"

namespace regulus::render {

using namespace interface;

namespace {

constexpr uint32_t WALK_TRAINING_SAMPLES = 2;
constexpr uint32_t TRAINING_LIGHT_PATHS = 1 << 17;
// Second moments that are larger by less than this without a guide: other things then decide about the error.
constexpr double LEAST_WALK_GAIN = 1.5;

reference::World world_with(const PreparedScene& prepared, const RenderSettings& settings,
                            std::shared_ptr<const scene::LightGuide> guide) {
  return reference::World(prepared, settings.ndf, settings.shadowing, settings.light_sampling,
                          settings.has_energy_compensation, std::move(guide));
}

}  // namespace

WalkGuideChoice choose_walk_guide(const PreparedScene& prepared, const RenderSettings& settings,
                                  uint32_t regularization) {
  reference::Settings training = training_settings(settings);
  training.samples = WALK_TRAINING_SAMPLES;
  // Light paths that train go where the camera looks, whether or not those of the render do.
  const std::shared_ptr<const scene::LightGuide> towards =
      probe::train_light_guide(world_with(prepared, settings, nullptr), training).guide;
  training.light_paths = TRAINING_LIGHT_PATHS;
  training.regularization = regularization & REGULARIZATION_ROUGHNESS;
  const probe::TrainedWalkGuide trained =
      probe::train_walk_guide(world_with(prepared, settings, towards), training);
  if (!trained.guide) return {nullptr, "a training found no light that a camera walk would have to look for"};
  const std::string gain =
      fmt::format("a training expects {:.2g} times the use of a sample of a diffuse lobe", trained.gain);
  if (settings.walk_guide == LIGHT_GUIDE_AUTO && trained.gain < LEAST_WALK_GAIN)
    return {nullptr, fmt::format("{}, less than {:g}", gain, LEAST_WALK_GAIN)};
  return {trained.guide, gain};
}

}  // namespace regulus::render
