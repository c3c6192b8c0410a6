#include "reference/light_guide.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "reference/environment.hpp"
#include "reference/sampling.hpp"

namespace regulus::reference {

using glm::dvec2;
using glm::dvec3;
using glm::dvec4;
using std::numbers::pi;
using namespace interface;

namespace {

constexpr double BELOW_ONE = 1 - 0x1p-24;

/// Share of a turn, in [0, 1), at which a direction lies around the z axis.
double turn_of(const dvec3& w) {
  const double turn = std::atan2(w.y, w.x) / (2 * pi);
  return std::min(turn < 0 ? turn + 1 : turn, BELOW_ONE);
}

/// Inverse of sample_sphere().
dvec2 sphere_numbers(const dvec3& w) {
  return {std::clamp((1 - w.z) / 2, 0.0, BELOW_ONE), turn_of(w)};
}

/// Inverse of sample_disk(): the square's point lies on the same spoke, at the radius in the maximum norm.
dvec2 disk_numbers(const dvec2& p) {
  const double radius = std::hypot(p.x, p.y);
  if (radius == 0) return dvec2(0.5);
  const auto along = [&](double minor, double major) { return std::atan(minor / major) / (pi / 4); };
  const dvec2 square = std::abs(p.x) > std::abs(p.y) ? std::copysign(radius, p.x) * dvec2(1, along(p.y, p.x))
                                                     : std::copysign(radius, p.y) * dvec2(along(p.x, p.y), 1);
  return clamp((square + 1.0) / 2.0, 0.0, BELOW_ONE);
}

dvec2 triangle_numbers(const World& world, const Surface& surface, const dvec3& w) {
  const bool is_two_sided = world.emits_from_both_sides(surface);
  const bool is_back = is_two_sided && dot(w, surface.geometric_normal) < 0;
  const Basis basis(is_back ? -surface.geometric_normal : surface.geometric_normal);
  dvec2 numbers = disk_numbers(dvec2(basis.to_local(w)));
  if (is_two_sided) numbers.x = std::min((numbers.x + (is_back ? 1 : 0)) / 2, BELOW_ONE);
  return numbers;
}

/// The share of a spot's light that it sends farther from its axis than w, and the turn around it.
dvec2 spot_numbers(const Light& light, const dvec3& w) {
  const dvec3 axis = normalize(dvec3(light.direction));
  const double height = dot(w - axis, w - axis) / 2;
  const double inner = light.inner_height;
  const double ring = light.outer_height - inner;
  const double ramp = std::clamp((light.outer_height - height) / ring, 0.0, 1.0);
  const double beyond = ring / 3 * std::pow(ramp, 3) + std::max(inner - height, 0.0);
  return {std::clamp(beyond / (ring / 3 + inner), 0.0, BELOW_ONE), turn_of(Basis(axis).to_local(w))};
}

/// Place on the disk from which distant light starts, of the ray through `at`.
dvec2 distant_numbers(const World& world, const dvec3& w, const dvec3& at) {
  return disk_numbers(dvec2(Basis(w).to_local(at - world.center())) / world.radius());
}

}  // namespace

dvec4 start_numbers(const World& world, const LightPoint& point, const dvec3& direction, const dvec3& at) {
  const Light& light = world.scene().lights[point.light];
  switch (point.kind) {
    case LIGHT_TRIANGLE:
      return {0, 0, triangle_numbers(world, point.surface, direction)};
    case LIGHT_SPOT:
      return {0, 0, spot_numbers(light, direction)};
    case LIGHT_DIRECTIONAL:
      return {distant_numbers(world, direction, at), 0, 0};
    case LIGHT_ENVIRONMENT: {
      const scene::Environment& environment = *world.scene().environment;
      return {environment.is_map() ? environment_numbers(environment, point.direction)
                                   : sphere_numbers(point.direction),
              distant_numbers(world, direction, at)};
    }
    default:
      return {0, 0, sphere_numbers(direction)};
  }
}

double guide_density(const scene::LightGuide& guide, uint32_t light, const dvec4& numbers) {
  dvec4 lower(0);
  dvec4 upper(1);
  double share = 1;
  uint32_t index = guide.lights[light].root;
  for (const GuideNode* node = &guide.nodes[index]; node->next != GUIDE_LEAF; node = &guide.nodes[index]) {
    const auto axis = static_cast<int>(node->next & GUIDE_AXIS_MASK);
    const double middle = (lower[axis] + upper[axis]) / 2;
    const bool is_lower = numbers[axis] < middle;
    (is_lower ? upper : lower)[axis] = middle;
    share *= is_lower ? double{node->first_share} : 1 - double{node->first_share};
    index = (node->next >> GUIDE_AXIS_BITS) + (is_lower ? 0 : 1);
  }
  const dvec4 size = upper - lower;
  return share / (size.x * size.y * size.z * size.w);
}

dvec4 guide_start(const scene::LightGuide& guide, uint32_t light, const dvec4& u) {
  dvec4 lower(0);
  dvec4 upper(1);
  glm::vec4 first(0);  // the numbers that lead into the box
  glm::vec4 last(1);
  const glm::vec4 number(u);
  uint32_t index = guide.lights[light].root;
  for (const GuideNode* node = &guide.nodes[index]; node->next != GUIDE_LEAF; node = &guide.nodes[index]) {
    const auto axis = static_cast<int>(node->next & GUIDE_AXIS_MASK);
    const float middle = first[axis] + node->first_share * (last[axis] - first[axis]);
    const bool is_lower = number[axis] < middle;
    (is_lower ? last : first)[axis] = middle;
    (is_lower ? upper : lower)[axis] = (lower[axis] + upper[axis]) / 2;
    index = (node->next >> GUIDE_AXIS_BITS) + (is_lower ? 0 : 1);
  }
  const dvec4 place = (u - dvec4(first)) / (dvec4(last) - dvec4(first));
  return lower + (upper - lower) * clamp(place, 0.0, BELOW_ONE);
}

}  // namespace regulus::reference
