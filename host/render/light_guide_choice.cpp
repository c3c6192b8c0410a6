#include "render/light_guide_choice.hpp"

#include <fmt/format.h>

#include <cmath>

#include "probe/light_guide.hpp"
#include "reference/world.hpp"

namespace regulus::render {

using namespace interface;

namespace {

constexpr double TRAINING_PIXELS = 4096;
constexpr uint32_t TRAINING_SAMPLES = 8;
// Light paths that start by power have a second moment that is larger by less than this: other things then
// decide about the error, and light that the training met too rarely could make it worse.
constexpr double LEAST_GAIN = 4;

}  // namespace

reference::Settings settings_of_few_pixels(const RenderSettings& settings, double pixels, uint32_t samples) {
  const double aspect = static_cast<double>(settings.width) / settings.height;
  const double height = std::sqrt(pixels / aspect);
  reference::Settings result;
  result.height = std::max(static_cast<uint32_t>(std::lround(height)), 1u);
  result.width = std::max(static_cast<uint32_t>(std::lround(height * aspect)), 1u);
  result.camera = settings.camera;
  result.samples = samples;
  result.max_depth = settings.max_depth;
  result.ndf = settings.ndf;
  result.shadowing = settings.shadowing;
  return result;
}

reference::Settings training_settings(const RenderSettings& settings) {
  return settings_of_few_pixels(settings, TRAINING_PIXELS, TRAINING_SAMPLES);
}

LightGuideChoice choose_light_guide(const PreparedScene& prepared, const RenderSettings& settings) {
  const reference::World world(prepared, settings.ndf, settings.shadowing, settings.light_sampling,
                               settings.has_energy_compensation);
  const probe::TrainedLightGuide trained = probe::train_light_guide(world, training_settings(settings));
  if (!trained.guide) return {nullptr, "a training found no light that reaches what the camera sees"};
  const std::string gain =
      fmt::format("a training expects {:.2g} times the use of a light path", trained.gain);
  if (settings.light_guide == LIGHT_GUIDE_AUTO && trained.gain < LEAST_GAIN)
    return {nullptr, fmt::format("{}, less than {:g}", gain, LEAST_GAIN)};
  return {trained.guide, gain};
}

}  // namespace regulus::render
