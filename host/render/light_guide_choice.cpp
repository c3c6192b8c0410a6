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
// `auto` looks at an eighth of the paths first: so few tell a gain that lies below what all would.
constexpr double GLIMPSE_PIXELS = 2048;
constexpr uint32_t GLIMPSE_SAMPLES = 2;
constexpr double LEAST_GLIMPSED_GAIN = 2.5;

std::string expected(double gain) {
  return fmt::format("a training expects {:.2g} times the use of a light path", gain);
}

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
  const bool is_open = settings.light_guide == LIGHT_GUIDE_AUTO;
  if (is_open) {
    const reference::Settings glimpse = settings_of_few_pixels(settings, GLIMPSE_PIXELS, GLIMPSE_SAMPLES);
    const double gain = probe::train_light_guide(world, glimpse).gain;
    if (gain < LEAST_GLIMPSED_GAIN) return {nullptr, fmt::format("{}, at a glimpse", expected(gain))};
  }
  const probe::TrainedLightGuide trained = probe::train_light_guide(world, training_settings(settings));
  if (!trained.guide) return {nullptr, "a training found no light that reaches what the camera sees"};
  const std::string gain = expected(trained.gain);
  if (is_open && trained.gain < LEAST_GAIN)
    return {nullptr, fmt::format("{}, less than {:g}", gain, LEAST_GAIN)};
  return {trained.guide, gain};
}

}  // namespace regulus::render
