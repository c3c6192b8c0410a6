// Lights in double precision: choosing one, a point on it, a direction from it, each with its density, and
// what it emits. Radiometry as in interface::Light.
#pragma once

#include <glm/glm.hpp>
#include <optional>

#include "reference/camera.hpp"
#include "reference/world.hpp"

namespace regulus::reference {

/// True for kinds of light that are infinitely far away.
constexpr bool is_distant(uint32_t kind) {
  return kind == interface::LIGHT_DIRECTIONAL || kind == interface::LIGHT_ENVIRONMENT;
}

/// True for kinds of light that a camera walk can meet.
constexpr bool can_be_hit(uint32_t kind) {
  return kind == interface::LIGHT_TRIANGLE || kind == interface::LIGHT_ENVIRONMENT;
}

/// A point of a light: x_0 of a path. Of the environment a direction.
struct LightPoint {
  uint32_t light = interface::INVALID_INDEX;
  uint32_t kind = interface::LIGHT_TRIANGLE;
  Surface surface;  ///< all of it for triangles; only the position for point and spot lights; else unused
  glm::dvec3 direction{0};  ///< distant lights: unit, towards the light
  /// Share of the surface that is there, if the point was sampled; 1 if a ray hit it, which has decided.
  double coverage = 1;

  bool is_triangle() const { return kind == interface::LIGHT_TRIANGLE; }
  bool is_distant() const { return reference::is_distant(kind); }
};

/// The light at which a light path starts, by two uniform numbers: by power, or as the world's guide says.
/// Precondition: the scene has lights.
uint32_t select_emitter(const World& world, const glm::dvec2& u);

/// The light that two uniform numbers choose by power. The bucket is found in single precision, as on the
/// device, because it is a decision, and decisions have to agree. Precondition: the scene has lights.
uint32_t select_light(const scene::Scene& scene, const glm::dvec2& u);

/// A point of the light: uniform on a triangle, the position of a point or spot light, a direction of the
/// environment.
LightPoint sample_light_point(const World& world, uint32_t light, const glm::dvec2& u);

/// The point of an emitter that a ray hit. Nothing if the surface is not a light.
std::optional<LightPoint> light_point_at(const Surface& surface);

/// The environment as it lies in unit direction `w`. Nothing if it is no light.
std::optional<LightPoint> environment_point(const World& world, const glm::dvec3& w);

/// Density with which a light walk chooses the point to start at, by selection and sample_light_point(): per
/// square metre for triangles, per steradian for the environment, discrete for the others (pt of
/// docs/mathematics.md section 1).
double light_point_pdf(const World& world, const LightPoint& point);

/// The same for next-event estimation at a surface point that is lit from the side of `w_light` (pc).
double connection_pdf(const World& world, const LightPoint& point, const Surface& surface,
                      const glm::dvec3& w_light);

/// What the point emits along unit `direction` (away from it): radiance of a triangle (0 from a back face
/// that does not emit) or the environment, intensity of a point or spot light, irradiance across the rays of
/// a directional light.
glm::dvec3 emitted(const World& world, const LightPoint& point, const glm::dvec3& direction);

/// Density with which a light walk leaves the point along `direction`: cosine-weighted for triangles (half on
/// each side if both emit), uniform for points, in proportion to the falloff for spots, one over the area of
/// the scene's disk for distant lights.
RayDensity emission_density(const World& world, const LightPoint& point, const glm::dvec3& direction);

/// rho-bar of a light for sampler quality (docs/mathematics.md 6): largest value of its normalized emission,
/// 1/sr. Lambertian for surfaces and distant lights, uniform in the cone or sphere of the others.
double emission_bound(const World& world, const LightPoint& point);

/// First ray of a light walk.
struct EmissionRay {
  glm::dvec3 origin, direction;
};

/// Draws it with density emission_density(). `u_direction` chooses the direction of lights that have a
/// choice; `u_position` places the ray of a directional light on the scene's disk. For the environment, whose
/// position was its direction, `u_direction` does so.
EmissionRay sample_emission(const World& world, const LightPoint& point, const glm::dvec2& u_position,
                            const glm::dvec2& u_direction);

/// How a light path starts.
struct LightStart {
  LightPoint point;
  EmissionRay ray;
};

/// Starts a light path with the random numbers of interface::DIMENSION_BLOCK_EMISSION (light, position) and
/// DIMENSION_BLOCK_EMISSION_DIRECTION. With density light_point_pdf() times that of light_end().
LightStart start_light_path(const World& world, const glm::dvec4& u_point, const glm::dvec2& u_direction);

/// The place from which a ray leaves the point of a light.
Place place_of_light(const World& world, const LightPoint& point, const Ray& ray);

/// Radiant intensity factor of a spot in this unit direction, whose cosine with the axis is c: clamp((c -
/// c_o) / (c_i - c_o))^2 (KHR_lights_punctual).
double spot_falloff(const interface::Light& light, const glm::dvec3& direction);

/// Integral of the falloff over directions, sr.
double spot_solid_angle(const interface::Light& light);

/// What a light of limited range sends over this distance, as a share of the inverse square law: 1 - (d /
/// range)^4, 0 from the range on (KHR_lights_punctual). 1 for all others.
double range_share(const World& world, const LightPoint& point, double distance);

}  // namespace regulus::reference
