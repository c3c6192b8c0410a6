// Whole paths and images: what the stages add up to, weights included.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "check/check.hpp"
#include "reference/estimator.hpp"
#include "reference/renderer.hpp"
#include "render/renderer.hpp"

namespace regulus::check {

using glm::dvec3;
using namespace interface;

namespace {

// A path or pixel agrees if it is within this of the reference: a dozen vertices, each within the stages'
// bound in the worst case and far better in all others.
constexpr double RADIANCE_BOUND = 1e-3;
// Share of whole paths that may diverge or differ, because of ties and edges on the way.
constexpr double PATHS_ALLOWED = 0.01;
// Pixels in reach of a splat with the default filter, all of which change when a light path diverges.
constexpr double PIXELS_OF_A_SPLAT = 9;

double largest(const dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

/// Number of vertices after which the device's path and the reference's are no longer the same; the count of
/// all if they are.
size_t common_vertices(const std::vector<reference::WalkVertex>& vertices, const render::Recording& recording,
                       uint32_t slot, bool& is_same) {
  size_t count = 0;
  for (const render::RecordedBounce& bounce : recording.bounces) {
    const bool was_traced = std::find(bounce.slots.begin(), bounce.slots.end(), slot) != bounce.slots.end();
    const uint32_t triangle = was_traced ? bounce.hits[slot].triangle : INVALID_INDEX;
    const uint32_t expected = count < vertices.size() ? vertices[count].surface.triangle : INVALID_INDEX;
    if (triangle != expected) {
      is_same = false;
      return count;
    }
    if (triangle == INVALID_INDEX) break;
    ++count;
  }
  is_same = count == vertices.size();
  return count;
}

/// Error relative to the value, or for values far below `floor` to that.
double relative_error(const dvec3& found, const dvec3& expected, double floor) {
  const double difference = largest(found - expected);
  return difference == 0 ? 0 : difference / std::max(largest(expected), floor);
}

}  // namespace

std::vector<Tally> check_paths(const Subject& subject, const render::Recording& recording) {
  Tally vertices("whole paths: vertices", 0, PATHS_ALLOWED);
  Tally radiance("whole paths: radiance", RADIANCE_BOUND, PATHS_ALLOWED);
  reference::Settings settings = subject.reference_settings;
  const reference::Estimator estimator(subject.world, subject.camera, settings);
  std::vector<dvec3> expected(recording.generated.size(), dvec3(0));
  double mean = 0;
  for (uint32_t slot = 0; slot < recording.generated.size(); ++slot) {
    const Path& path = recording.generated[slot];
    estimator.camera_sample(path.pixel, path.sample_index, nullptr,
                            [&](const reference::Contribution& found) { expected[slot] += found.value(); });
    mean += largest(expected[slot]) / static_cast<double>(expected.size());
  }
  for (uint32_t slot = 0; slot < recording.generated.size(); ++slot) {
    const Path& path = recording.generated[slot];
    const auto walk =
        walk_from_camera(subject.world, subject.camera, settings, path.pixel, path.sample_index);
    bool is_same = true;
    const size_t common = common_vertices(walk.vertices, recording, slot, is_same);
    if (!is_same) {
      vertices.add_error(1);
      vertices.describe(fmt::format("pixel {}: diverges after {} vertices", path.pixel, common));
      continue;
    }
    vertices.add_error(0);
    const dvec3 found(recording.bounces.back().radiance[slot]);
    if (!radiance.add_error(relative_error(found, expected[slot], 0.01 * mean)))
      radiance.describe(
          fmt::format("pixel {} sample {}: ({:.6g} {:.6g} {:.6g}) against ({:.6g} {:.6g} {:.6g})", path.pixel,
                      path.sample_index, found.x, found.y, found.z, expected[slot].x, expected[slot].y,
                      expected[slot].z));
  }
  return {vertices, radiance};
}

Tally check_image(gpu::Device& device, const Subject& subject, const char* name, uint32_t techniques) {
  const bool has_splats = (techniques & TECHNIQUE_SPLAT) != 0;
  Tally tally(fmt::format("image by {}", name), RADIANCE_BOUND,
              has_splats ? PIXELS_OF_A_SPLAT * PATHS_ALLOWED : PATHS_ALLOWED);
  render::RenderSettings settings = subject.settings;
  settings.techniques = techniques;
  settings.samples = 1;
  render::Renderer renderer(device, subject.scene, subject.bvh, settings);
  renderer.render([](uint64_t, uint64_t) { return true; });
  const image::Image found = render::resolve(renderer.film());

  reference::Settings wanted = subject.reference_settings;
  wanted.techniques = techniques;
  wanted.samples = 1;
  const reference::Film expected = reference::render(subject.world, wanted);
  double mean = 0;
  for (const dvec3& value : expected.sum) mean += largest(value) / static_cast<double>(expected.sum.size());
  for (size_t i = 0; i < expected.sum.size(); ++i) {
    const dvec3 pixel(found.rgb[3 * i], found.rgb[3 * i + 1], found.rgb[3 * i + 2]);
    if (!tally.add_error(relative_error(pixel, expected.sum[i], 0.01 * mean)))
      tally.describe(fmt::format("pixel ({}, {}): ({:.6g} {:.6g} {:.6g}) against ({:.6g} {:.6g} {:.6g})",
                                 i % settings.width, i / settings.width, pixel.x, pixel.y, pixel.z,
                                 expected.sum[i].x, expected.sum[i].y, expected.sum[i].z));
  }
  return tally;
}

}  // namespace regulus::check
