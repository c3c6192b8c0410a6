#include "reference/lights.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "reference/environment.hpp"
#include "reference/light_choice.hpp"
#include "reference/light_guide.hpp"
#include "reference/sampling.hpp"

namespace regulus::reference {

using glm::dvec2;
using glm::dvec3;
using std::numbers::pi;
using namespace interface;

namespace {

const Light& light_of(const World& world, const LightPoint& point) {
  return world.scene().lights[point.light];
}

/// Integral of the falloff over the cosine, cut into the inner cone and what surrounds it.
struct SpotMass {
  double falloff, inner;
  double total() const { return falloff + inner; }
};

SpotMass spot_mass(const Light& light) {
  return {(double{light.outer_height} - light.inner_height) / 3, light.inner_height};
}

/// Height 1 - cos over the cone's top, density spot_falloff / total mass, by inversion.
double sample_spot_height(const Light& light, double u) {
  const SpotMass mass = spot_mass(light);
  const double target = u * mass.total();
  if (target < mass.falloff)
    return light.outer_height -
           std::cbrt(target / mass.falloff) * (double{light.outer_height} - light.inner_height);
  return std::max(light.inner_height - (target - mass.falloff), 0.0);
}

dvec3 sample_spot_direction(const Light& light, const dvec2& u) {
  const double height = sample_spot_height(light, u.x);
  const double sine = std::sqrt(height * (2 - height));
  const double azimuth = 2 * pi * u.y;
  return Basis(normalize(dvec3(light.direction)))
      .to_world({sine * std::cos(azimuth), sine * std::sin(azimuth), 1 - height});
}

dvec3 sample_triangle_direction(const World& world, const Surface& surface, dvec2 u) {
  dvec3 normal = surface.geometric_normal;
  if (world.emits_from_both_sides(surface)) {
    const bool is_front = u.x < 0.5;
    u.x = is_front ? 2 * u.x : 2 * u.x - 1;
    if (!is_front) normal = -normal;
  }
  return Basis(normal).to_world(sample_cosine_hemisphere(u));
}

uint32_t select_by(const std::vector<LightAlias>& table, const dvec2& u) {
  const auto count = static_cast<uint32_t>(table.size());
  if (count == 1) return 0;
  const float bucket = static_cast<float>(u.x) * static_cast<float>(count);
  const uint32_t index = std::min(static_cast<uint32_t>(bucket), count - 1);
  const LightAlias& entry = table[index];
  return u.y < entry.threshold ? index : entry.alias;
}

/// Density of sample_light_point().
double density_on_light(const World& world, const LightPoint& point) {
  if (point.kind == LIGHT_ENVIRONMENT) return environment_pdf(*world.scene().environment, point.direction);
  return point.is_triangle() ? 1 / point.surface.area : 1;
}

}  // namespace

uint32_t select_emitter(const World& world, const dvec2& u) {
  return select_by(world.light_guide() ? world.light_guide()->aliases : world.scene().light_aliases, u);
}

uint32_t select_light(const scene::Scene& scene, const dvec2& u) {
  return select_by(scene.light_aliases, u);
}

LightStart start_light_path(const World& world, const glm::dvec4& u_point, const dvec2& u_direction) {
  const uint32_t light = select_emitter(world, {u_point.x, u_point.y});
  glm::dvec4 u(u_point.z, u_point.w, u_direction);
  if (world.light_guide()) u = guide_start(*world.light_guide(), light, u);
  LightStart start{sample_light_point(world, light, {u.x, u.y}), {}};
  start.ray = sample_emission(world, start.point, {u.x, u.y}, {u.z, u.w});
  return start;
}

LightPoint sample_light_point(const World& world, uint32_t index, const dvec2& u) {
  const Light& light = world.scene().lights[index];
  LightPoint point;
  point.light = index;
  point.kind = light.kind;
  if (point.is_triangle()) {
    const dvec2 barycentrics = sample_triangle(u);
    point.surface = world.surface_at(light.triangle, barycentrics);
    point.coverage = coverage_at(world.scene(), light.triangle, barycentrics);
  } else if (light.kind == LIGHT_ENVIRONMENT) {
    point.direction = sample_environment(*world.scene().environment, u);
  } else if (light.kind == LIGHT_DIRECTIONAL) {
    point.direction = -dvec3(light.direction);
  } else {
    point.surface.position = light.position;
  }
  return point;
}

std::optional<LightPoint> environment_point(const World& world, const dvec3& w) {
  const std::vector<Light>& lights = world.scene().lights;
  for (uint32_t i = 0; i < lights.size(); ++i)
    if (lights[i].kind == LIGHT_ENVIRONMENT) return LightPoint{i, LIGHT_ENVIRONMENT, {}, w};
  return std::nullopt;
}

std::optional<LightPoint> light_point_at(const Surface& surface) {
  if (surface.light == INVALID_INDEX) return std::nullopt;
  return LightPoint{surface.light, LIGHT_TRIANGLE, surface, {}};
}

double light_point_pdf(const World& world, const LightPoint& point) {
  const double selection_pdf = world.light_guide() ? world.light_guide()->lights[point.light].selection_pdf
                                                   : light_of(world, point).selection_pdf;
  return selection_pdf * density_on_light(world, point);
}

double connection_pdf(const World& world, const LightPoint& point, const Surface& surface,
                      const dvec3& w_light) {
  return choice_probability(world, receiver_at(world, surface, w_light), point.light) *
         density_on_light(world, point);
}

double spot_falloff(const Light& light, const dvec3& direction) {
  const dvec3 from_axis = direction - normalize(dvec3(light.direction));
  const double height = 0.5 * dot(from_axis, from_axis);
  const double width = double{light.outer_height} - light.inner_height;
  const double linear = std::clamp((light.outer_height - height) / width, 0.0, 1.0);
  return linear * linear;
}

double spot_solid_angle(const Light& light) {
  return 2 * pi * spot_mass(light).total();
}

double range_share(const World& world, const LightPoint& point, double distance) {
  const double range = point.is_triangle() ? 0 : light_of(world, point).area;
  if (range == 0) return 1;
  return std::clamp(1 - std::pow(distance / range, 4), 0.0, 1.0);
}

dvec3 emitted(const World& world, const LightPoint& point, const dvec3& direction) {
  const Light& light = light_of(world, point);
  if (point.is_triangle()) {
    const double cosine = dot(direction, point.surface.geometric_normal);
    const bool emits = cosine > 0 || (cosine < 0 && world.emits_from_both_sides(point.surface));
    return emits ? point.coverage * world.emission_at(point.surface) : dvec3(0);
  }
  if (point.kind == LIGHT_ENVIRONMENT)
    return environment_radiance(*world.scene().environment, point.direction);
  const dvec3 intensity(light.intensity);
  return light.kind == LIGHT_SPOT ? intensity * spot_falloff(light, direction) : intensity;
}

RayDensity emission_density(const World& world, const LightPoint& point, const dvec3& direction) {
  const Light& light = light_of(world, point);
  switch (light.kind) {
    case LIGHT_TRIANGLE: {
      const double cosine = dot(direction, point.surface.geometric_normal);
      if (world.emits_from_both_sides(point.surface)) return {std::abs(cosine) / (2 * pi)};
      return {std::max(cosine, 0.0) / pi};
    }
    case LIGHT_SPOT:
      return {spot_falloff(light, direction) / spot_solid_angle(light)};
    case LIGHT_DIRECTIONAL:
    case LIGHT_ENVIRONMENT:
      return {1 / (pi * world.radius() * world.radius()), true};
    default:
      return {1 / (4 * pi)};
  }
}

double emission_bound(const World& world, const LightPoint& point) {
  if (point.kind == LIGHT_POINT) return 1 / (4 * pi);
  if (point.kind != LIGHT_SPOT) return 1 / pi;
  return 1 / (2 * pi * light_of(world, point).outer_height);
}

Place place_of_light(const World& world, const LightPoint& point, const Ray& ray) {
  return {world.media_of_light(point.light, ray.origin),
          point.is_triangle() ? point.surface.triangle : INVALID_INDEX};
}

EmissionRay sample_emission(const World& world, const LightPoint& point, const dvec2& u_position,
                            const dvec2& u_direction) {
  const Light& light = light_of(world, point);
  switch (light.kind) {
    case LIGHT_TRIANGLE:
      return {point.surface.position, sample_triangle_direction(world, point.surface, u_direction)};
    case LIGHT_SPOT:
      return {point.surface.position, sample_spot_direction(light, u_direction)};
    case LIGHT_DIRECTIONAL:
    case LIGHT_ENVIRONMENT: {
      const dvec3 direction = -point.direction;
      const dvec2& u = light.kind == LIGHT_DIRECTIONAL ? u_position : u_direction;
      const dvec3 on_disk = Basis(direction).to_world(dvec3(sample_disk(u), -1));
      return {world.center() + world.radius() * on_disk, direction};
    }
    default:
      return {point.surface.position, sample_sphere(u_direction)};
  }
}

}  // namespace regulus::reference
