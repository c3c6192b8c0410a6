// Images that must have the same mean, by Student's t over independent seeds.
#include <fmt/format.h>

#include <algorithm>

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

std::vector<Image> device_images(gpu::Device& device, const Subject& subject, render::Plan plan,
                                 uint32_t count) {
  std::vector<Image> images;
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

std::vector<Image> reference_images(const Subject& subject, uint32_t count) {
  reference::Settings settings = subject.reference_settings;
  settings.seed += OTHER_SEEDS;
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

}  // namespace

std::vector<ImageTest> check_statistics(gpu::Device& device, const Subject& subject, uint32_t batches,
                                        std::optional<uint32_t> other_techniques, double tolerance) {
  const std::vector<Image> first = device_images(device, subject, subject.plan, batches);
  std::vector<Image> second;
  if (other_techniques) {
    render::RenderSettings other = subject.plan.asked;
    other.techniques = *other_techniques;
    other.seed += OTHER_SEEDS;
    second = device_images(device, subject, make_plan(subject.prepared, other), batches);
  } else {
    second = reference_images(subject, batches);
  }
  const uint32_t size = std::max(subject.plan.width, subject.plan.height);
  std::vector<ImageTest> tests;
  for (const auto& [name, tile] :
       {std::pair<const char*, uint32_t>{"pixels", 1}, {"tiles of 8x8", TILE}, {"whole image", size}}) {
    image::ComparisonOptions options;
    options.tile = tile;
    options.false_alarm_rate = FALSE_ALARM_RATE / 3;
    options.relative_tolerance = tolerance;
    const image::TileTest test = image::test_equal(first, second, options);
    std::string line = fmt::format(
        "{:<14} smallest p {:.2g} of {} tests, bound {:.2g}; there {:.4g} and {:.4g}: {:+.2g} with a "
        "standard error of {:.2g}  "
        "{}",
        name, test.worst_p, test.tests, test.bound, mean_there(first, tile, test),
        mean_there(second, tile, test), test.worst_difference, test.worst_error,
        test.is_passed() ? "ok" : "MISMATCH");
    if (!test.is_passed())
      line += fmt::format("\n    at ({}, {}), channel {}", tile * test.worst_x, tile * test.worst_y,
                          test.worst_channel);
    tests.push_back({std::move(line), test.is_passed()});
  }
  return tests;
}

}  // namespace regulus::check
