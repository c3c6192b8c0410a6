#include "reference/light_guide.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "reference/environment.hpp"
#include "reference/guide_tree.hpp"
#include "reference/sampling.hpp"

namespace regulus::reference {

using glm::dvec2;
using glm::dvec3;
using glm::dvec4;
using std::numbers::pi;
using namespace interface;

namespace {

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
  return tree_density(guide.nodes, guide.lights[light].root, numbers);
}

dvec4 guide_start(const scene::LightGuide& guide, uint32_t light, const dvec4& u) {
  return tree_start(guide.nodes, guide.lights[light].root, u);
}

}  // namespace regulus::reference
