// Images that must have the same mean, by Student's t over independent seeds.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "check/check.hpp"
#include "image/comparison.hpp"
#include "reference/renderer.hpp"
#include "render/renderer.hpp"

namespace regulus::check {

using image::Image;

namespace {

constexpr double FALSE_ALARM_RATE = 1e-4;  // of a whole comparison
constexpr uint32_t TILE = 8;               // pixels
// Seeds of the second set follow at this distance.
constexpr uint32_t OTHER_SEEDS = 0x10000;

// Times the samples of a round that settles alarms, the distance of its seeds: rounds of at most 1000 batches
// each, below those of the second set.
constexpr uint32_t SEEDS_OF_A_ROUND = 0x100;
// A test that needs a difference of more standard errors to raise an alarm sees no bias that matters.
constexpr double MOST_STANDARD_ERRORS = 100;

std::vector<Image> device_images(gpu::Device& device, const Subject& subject, render::Plan plan,
                                 uint32_t count, uint32_t times) {
  std::vector<Image> images;
  plan.samples *= times;
  plan.seed += times > 1 ? times * SEEDS_OF_A_ROUND : 0;
  for (uint32_t i = 0; i < count; ++i, ++plan.seed) {
    render::Renderer renderer(device, subject.prepared, plan);
    renderer.render([](uint64_t, uint64_t) { return true; });
    images.push_back(render::resolve(renderer.film()));
  }
  return images;
}

double mean_there(const std::vector<Image>& images, uint32_t tile, const image::TileTest& test) {
  double sum = 0;
  for (const Image& image : images)
    sum += image::tile_mean(image, test.worst_x, test.worst_y, tile, test.worst_channel);
  return sum / static_cast<double>(images.size());
}

std::vector<Image> reference_images(const Subject& subject, uint32_t count, uint32_t times) {
  reference::Settings settings = subject.reference_settings;
  settings.samples *= times;
  settings.seed += OTHER_SEEDS + (times > 1 ? times * SEEDS_OF_A_ROUND : 0);
  std::vector<Image> images;
  for (uint32_t i = 0; i < count; ++i, ++settings.seed) {
    const reference::Film film = reference::render(subject.world, settings);
    Image image{film.width, film.height, {}};
    for (size_t pixel = 0; pixel < film.sum.size(); ++pixel)
      for (int c = 0; c < 3; ++c) image.rgb.push_back(static_cast<float>(film.mean(pixel)[c]));
    images.push_back(std::move(image));
  }
  return images;
}

std::string words_of(const image::Alarm& alarm) {
  return fmt::format("\n    at ({}, {}), channel {}: {:+.2g} at first", alarm.tile * alarm.x,
                     alarm.tile * alarm.y, alarm.channel, alarm.difference);
}

Agreement agreement_of(const image::Settled& settled) {
  return settled.is_passed()      ? Agreement::Agree
         : settled.is_undecided() ? Agreement::Undecided
                                  : Agreement::Differ;
}

/// The greatest radiance of lamps and environment: a path that meets them by chance is worth no more.
double brightest_light(const scene::Scene& scene) {
  float brightest = 0;
  const auto add = [&](const glm::vec3& radiance) {
    brightest = std::max({brightest, radiance.r, radiance.g, radiance.b});
  };
  for (const interface::Light& light : scene.lights)
    if (light.kind == interface::LIGHT_TRIANGLE) add(light.intensity);
  if (scene.environment) {
    if (!scene.environment->is_map()) add(scene.environment->parameters.radiance);
    for (const glm::vec3& texel : scene.environment->texels) add(texel);
  }
  return brightest;
}

/// What is left of a test's alarms.
std::string verdict(const image::TileTest& test, const image::Settled& settled) {
  if (test.is_passed()) return "agree";
  const Agreement agreement = agreement_of(settled);
  std::string text =
      fmt::format("{}, with up to {} times the samples {} of {} alarms confirmed, {} withdrawn, {} open",
                  agreement == Agreement::Agree       ? "agree"
                  : agreement == Agreement::Undecided ? "undecided"
                                                      : "MISMATCH",
                  settled.times, settled.confirmed.size(), test.alarms.size(), settled.withdrawn.size(),
                  settled.open.size());
  constexpr size_t MOST = 3;
  for (const std::vector<image::Alarm>* alarms : {&settled.confirmed, &settled.open})
    for (size_t i = 0; i < std::min(alarms->size(), MOST); ++i) text += words_of((*alarms)[i]);
  return text;
}

}  // namespace

std::vector<ImageTest> check_statistics(gpu::Device& device, const Subject& subject, uint32_t batches,
                                        std::optional<uint32_t> other_techniques, double tolerance) {
  std::optional<render::Plan> other;
  if (other_techniques) {
    render::RenderSettings settings = subject.plan.asked;
    settings.techniques = *other_techniques;
    settings.seed += OTHER_SEEDS;
    other = make_plan(subject.prepared, settings);
  }
  std::map<uint32_t, std::pair<std::vector<Image>, std::vector<Image>>> rendered;
  const auto batches_of = [&](uint32_t times) {
    const auto found = rendered.find(times);
    if (found != rendered.end()) return found->second;
    std::vector<Image> ours = device_images(device, subject, subject.plan, batches, times);
    return rendered[times] = {std::move(ours), other ? device_images(device, subject, *other, batches, times)
                                                     : reference_images(subject, batches, times)};
  };
  const auto [first, second] = batches_of(1);
  const uint32_t size = std::max(subject.plan.width, subject.plan.height);
  std::vector<ImageTest> tests;
  for (const auto& [name, tile] :
       {std::pair<const char*, uint32_t>{"pixels", 1}, {"tiles of 8x8", TILE}, {"whole image", size}}) {
    image::ComparisonOptions options;
    options.tile = tile;
    options.false_alarm_rate = FALSE_ALARM_RATE / 3;
    options.relative_tolerance = tolerance;
    // The reference meets what the device meets, as often.
    if (other) {
      options.samples = uint64_t{subject.plan.samples} * batches;
      options.brightest = brightest_light(subject.prepared.scene);
    }
    const image::TileTest test = image::test_equal(first, second, options);
    const image::Settled settled = image::settle(test.alarms, batches_of, options);
    tests.push_back(
        {fmt::format(
             "{:<14} smallest p {:.2g} of {} tests, bound {:.2g}; there {:.4g} and {:.4g}: {:+.2g} with a "
             "standard error of {:.2g}  {}",
             name, test.worst_p, test.tests, test.bound, mean_there(first, tile, test),
             mean_there(second, tile, test), test.worst_difference, test.worst_error, verdict(test, settled)),
         agreement_of(settled)});
  }
  return tests;
}

uint32_t fewest_batches(const render::Plan& plan) {
  const uint64_t pixels = plan.crop.pixels() != 0 ? plan.crop.pixels() : uint64_t{plan.width} * plan.height;
  const auto tests = static_cast<int>(3 * pixels);
  uint32_t batches = 2;
  while (image::standard_errors_of_alarm(static_cast<int>(batches), tests, FALSE_ALARM_RATE / 3) >
         MOST_STANDARD_ERRORS)
    ++batches;
  return batches;
}

}  // namespace regulus::check
