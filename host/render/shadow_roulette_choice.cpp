#include "render/shadow_roulette_choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "probe/probe.hpp"
#include "reference/walk.hpp"
#include "reference/world.hpp"
#include "render/light_guide_choice.hpp"

namespace regulus::render {

using namespace interface;

namespace {

constexpr double GLIMPSE_PIXELS = 324;
constexpr uint32_t GLIMPSE_SAMPLES = 1;
// Of the typical brightness, measured (docs/decisions/034-shadow-roulette.md).
constexpr double SHARE_OF_BRIGHTNESS = 0.125;

// Unregularized paths of all kinds, so that what a technique misses is seen by another.
reference::Settings glimpse_settings(const RenderSettings& settings) {
  reference::Settings result = settings_of_few_pixels(settings, GLIMPSE_PIXELS, GLIMPSE_SAMPLES);
  result.techniques = TECHNIQUE_HIT | SHADOW_RAY_TECHNIQUES;
  return result;
}

}  // namespace

ShadowRouletteChoice choose_shadow_roulette(const PreparedScene& prepared, const RenderSettings& settings) {
  float least = settings.shadow_roulette.value_or(0);
  std::string why = "given";
  if (!settings.shadow_roulette) {
    const reference::World world(prepared, settings.ndf, settings.shadowing, settings.light_sampling,
                                 settings.has_energy_compensation);
    const double brightness = probe::typical_brightness(probe::find_paths(world, glimpse_settings(settings)));
    if (!(brightness > 0) || !std::isfinite(brightness)) return {0, "a probe found no light"};
    // A power of two, so that it is the same however the probe's last digits are rounded.
    least = std::exp2(std::round(std::log2(static_cast<float>(SHARE_OF_BRIGHTNESS * brightness))));
    why = fmt::format("an eighth of the brightness {:.2g} that is typical", brightness);
  }
  return {std::min(least, settings.largest_contribution), why};
}

}  // namespace regulus::render
