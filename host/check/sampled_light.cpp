#include "check/sampled_light.hpp"

#include <optional>

#include "reference/lights.hpp"
#include "reference/rounding.hpp"

namespace regulus::check {
namespace {

using glm::dvec2;
using glm::dvec3;

// How far single precision may move the numbers that choose a light: a walk down the tree takes a decision on
// each level with shares of a few roundings.
constexpr double CHOICE_ROUNDINGS = 32 * reference::UNIT_ROUNDOFF;
// A segment leads to a point if it passes it this near, relative to its length and to the size of the scene.
constexpr double SEGMENT_ANGLE = 1e-3;
constexpr double SEGMENT_OFFSET = 1e-5;

/// How far the segment passes by the light's point, over what its offsets and single precision may do.
double miss(const reference::World& world, uint32_t light, const dvec2& u,
            const interface::VisibilityCandidate& candidate) {
  const reference::LightPoint point = sample_light_point(world, light, u);
  const dvec3 direction(candidate.direction);
  if (point.is_distant()) return length(point.direction - direction) / SEGMENT_ANGLE;
  const dvec3 towards = point.surface.position - dvec3(candidate.origin);
  const double off_surface = point.is_triangle() ? clearance(world, point.surface) : 0;
  return length(towards - length(towards) * direction) /
         (SEGMENT_ANGLE * length(towards) + SEGMENT_OFFSET * world.radius() + off_surface);
}

}  // namespace

SampledLight sampled_light(const reference::World& world, const reference::Receiver& receiver,
                           const glm::dvec4& numbers, const interface::VisibilityCandidate& candidate) {
  const auto miss_of = [&](uint32_t light) { return miss(world, light, {numbers.z, numbers.w}, candidate); };
  const std::optional<uint32_t> wanted = choose_light(world, receiver, {numbers.x, numbers.y});
  std::optional<uint32_t> found = wanted;
  for (const dvec2& moved : {dvec2(1, 0), dvec2(-1, 0), dvec2(0, 1), dvec2(0, -1)}) {
    const dvec2 near =
        glm::clamp(dvec2(numbers) + CHOICE_ROUNDINGS * moved, 0.0, 1 - reference::UNIT_ROUNDOFF);
    const std::optional<uint32_t> other = choose_light(world, receiver, near);
    if (other && (!found || miss_of(*other) < miss_of(*found))) found = other;
  }
  if (!found) return {};
  if (miss_of(*found) > 1) return {*found, LightChoice::Unexplained};
  return {*found, found == wanted ? LightChoice::Same : LightChoice::Tie};
}

}  // namespace regulus::check
