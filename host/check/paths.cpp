// Whole paths and images: what the stages add up to, weights included.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "base/components.hpp"
#include "check/check.hpp"
#include "check/item_class.hpp"
#include "reference/estimator.hpp"
#include "reference/renderer.hpp"
#include "render/reference_settings.hpp"
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
// How often the reference is run again, with its numbers moved as single precision may move them, to see how
// well conditioned a path or pixel is. Of what that moves it, CONDITIONING times is not held against the
// device.
constexpr uint32_t WALK_PATTERNS = 4;
constexpr double CONDITIONING = 4;
// Pixels in reach of a splat with the default filter, all of which change when a light path diverges.
constexpr double PIXELS_OF_A_SPLAT = 9;

/// The triangles that a path of the device meets, by slot.
std::vector<std::vector<uint32_t>> triangles_of(const render::Recording& recording) {
  std::vector<std::vector<uint32_t>> triangles(recording.generated.size());
  for (const render::RecordedBounce& bounce : recording.bounces)
    for (const uint32_t slot : bounce.slots)
      if (bounce.hits[slot].triangle != INVALID_INDEX) triangles[slot].push_back(bounce.hits[slot].triangle);
  return triangles;
}

/// The reference's walk of a path, with its numbers moved by a pattern of roundings.
reference::CameraSubpath reference_walk(const Subject& subject, reference::Settings settings, uint32_t pixel,
                                        uint32_t sample, uint32_t pattern) {
  settings.rounding_pattern = pattern;
  return walk_from_camera(subject.world, subject.camera, settings, pixel, sample);
}

/// What the camera sees there, as a class of items.
std::string first_class(const reference::CameraSubpath& walk) {
  return walk.vertices.empty() ? "nothing" : "first " + vertex_class(walk.vertices.front());
}

std::vector<uint32_t> triangles_of(const reference::CameraSubpath& walk) {
  std::vector<uint32_t> triangles;
  for (const reference::WalkVertex& vertex : walk.vertices) triangles.push_back(vertex.surface.triangle);
  return triangles;
}

size_t common_length(const std::vector<uint32_t>& a, const std::vector<uint32_t>& b) {
  size_t i = 0;
  while (i < a.size() && i < b.size() && a[i] == b[i]) ++i;
  return i;
}

/// Judges a path whose triangles are those of the device. What the reference under rounding does is a tie.
void compare_vertices(const Subject& subject, const Path& path, const std::vector<uint32_t>& found,
                      const std::vector<uint32_t>& expected, const std::string& of_class, size_t& moved_paths,
                      Tally& tally) {
  bool is_tie = false;
  for (uint32_t pattern = 1; pattern <= WALK_PATTERNS; ++pattern) {
    const std::vector<uint32_t> moved = triangles_of(
        reference_walk(subject, subject.reference_settings, path.number, path.sample_index, pattern));
    moved_paths += moved == expected ? 0 : 1;
    is_tie = is_tie || common_length(moved, expected) <= common_length(found, expected);
  }
  if (found == expected) {
    tally.add_error(0, 0, of_class);
  } else if (is_tie) {
    tally.add_difference(Difference::Tie, of_class);
  } else {
    tally.add_difference(Difference::Real, of_class);
    tally.describe(
        fmt::format("pixel {}: diverges after {} vertices", path.number, common_length(found, expected)));
  }
}

/// Error relative to the value, or for values far below `floor` to that.
double relative_error(const dvec3& found, const dvec3& expected, double floor) {
  const double difference = largest_magnitude(found - expected);
  return difference == 0 ? 0 : difference / std::max(largest_magnitude(expected), floor);
}

std::string against(const dvec3& found, const dvec3& expected) {
  return fmt::format("({:.6g} {:.6g} {:.6g}) against ({:.6g} {:.6g} {:.6g})", found.x, found.y, found.z,
                     expected.x, expected.y, expected.z);
}

/// Holds colours found by the device against those that `evaluate` finds with given settings. Only where they
/// differ is the conditioning worth its time: the reference again, with its numbers moved.
/// @param classes of the colours, as many
template <typename Evaluate, typename Describe>
void compare_colors(const std::vector<dvec3>& found, reference::Settings settings, const Evaluate& evaluate,
                    const Describe& describe, const std::vector<std::string>& classes, Tally& tally) {
  const std::vector<dvec3> expected = evaluate(settings);
  double mean = 0;
  for (const dvec3& value : expected) mean += largest_magnitude(value) / static_cast<double>(expected.size());
  std::vector<double> errors(found.size()), spreads(found.size(), 0.0);
  for (size_t i = 0; i < found.size(); ++i) errors[i] = relative_error(found[i], expected[i], 0.01 * mean);
  if (std::any_of(errors.begin(), errors.end(), [](double e) { return !(e <= RADIANCE_BOUND); })) {
    for (uint32_t pattern = 1; pattern <= WALK_PATTERNS; ++pattern) {
      settings.rounding_pattern = pattern;
      const std::vector<dvec3> moved = evaluate(settings);
      for (size_t i = 0; i < found.size(); ++i)
        spreads[i] = std::max(spreads[i], relative_error(moved[i], expected[i], 0.01 * mean));
    }
  }
  for (size_t i = 0; i < found.size(); ++i)
    if (!tally.add_error(errors[i], CONDITIONING * spreads[i], classes[i]))
      tally.describe(describe(i) + ": " + against(found[i], expected[i]));
}

std::vector<dvec3> colors_of(const image::Image& image) {
  std::vector<dvec3> colors;
  for (size_t i = 0; i + 2 < image.rgb.size(); i += 3)
    colors.emplace_back(image.rgb[i], image.rgb[i + 1], image.rgb[i + 2]);
  return colors;
}

}  // namespace

std::vector<Tally> check_paths(const Subject& subject, const render::Recording& recording) {
  Tally vertices("whole paths: vertices", 0, PATHS_ALLOWED);
  Tally radiance("whole paths: radiance", RADIANCE_BOUND, PATHS_ALLOWED);
  const std::vector<std::vector<uint32_t>> triangles = triangles_of(recording);
  size_t moved_paths = 0;
  std::vector<uint32_t> slots;  // of paths that go the same way
  std::vector<dvec3> found;     // their radiance
  std::vector<std::string> classes;
  for (uint32_t slot = 0; slot < recording.generated.size(); ++slot) {
    const Path& path = recording.generated[slot];
    const reference::CameraSubpath walk =
        reference_walk(subject, subject.reference_settings, path.number, path.sample_index, 0);
    const std::vector<uint32_t> same = triangles_of(walk);
    const std::string of_class = first_class(walk);
    compare_vertices(subject, path, triangles[slot], same, of_class, moved_paths, vertices);
    if (triangles[slot] != same) continue;
    slots.push_back(slot);
    classes.push_back(of_class);
    found.emplace_back(recording.bounces.back().radiance[slot]);
  }
  const auto evaluate = [&](const reference::Settings& settings) {
    const reference::Estimator estimator(subject.world, subject.camera, settings);
    std::vector<dvec3> values(slots.size(), dvec3(0));
    for (size_t i = 0; i < slots.size(); ++i) {
      const Path& path = recording.generated[slots[i]];
      estimator.camera_sample(path.number, path.sample_index, nullptr,
                              [&](const reference::Contribution& one) { values[i] += one.value(); });
    }
    return values;
  };
  const auto describe = [&](size_t i) {
    const Path& path = recording.generated[slots[i]];
    return fmt::format("pixel {} sample {}", path.number, path.sample_index);
  };
  compare_colors(found, subject.reference_settings, evaluate, describe, classes, radiance);
  vertices.expect_ties(moved_paths / WALK_PATTERNS);
  return {vertices, radiance};
}

Tally check_image(gpu::Device& device, const Subject& subject, const char* name, uint32_t techniques) {
  const bool has_splats = (techniques & TECHNIQUE_SPLAT) != 0;
  Tally tally(fmt::format("image by {}", name), RADIANCE_BOUND,
              has_splats ? PIXELS_OF_A_SPLAT * PATHS_ALLOWED : PATHS_ALLOWED);
  render::RenderSettings settings = subject.plan.asked;
  settings.techniques = techniques;
  settings.samples = 1;
  const render::Plan plan = make_plan(subject.prepared, settings);
  render::Renderer renderer(device, subject.prepared, plan);
  renderer.render([](uint64_t, uint64_t) { return true; });
  const image::Image image = render::resolve(renderer.film());

  const reference::Settings wanted = render::reference_settings(plan);
  std::vector<std::string> classes;
  for (uint32_t pixel = 0; pixel < settings.width * settings.height; ++pixel)
    classes.push_back(first_class(reference_walk(subject, wanted, pixel, plan.first_sample, 0)));
  compare_colors(
      colors_of(image), wanted,
      [&](const reference::Settings& moved) { return reference::render(subject.world, moved).sum; },
      [&](size_t i) { return fmt::format("pixel ({}, {})", i % settings.width, i / settings.width); },
      classes, tally);
  return tally;
}

}  // namespace regulus::check
