#include "stability/bsdf_cases.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "reference/bsdf.hpp"

namespace regulus::stability {

using glm::dvec2;
using glm::dvec3;
using std::numbers::pi;
using namespace interface;

namespace {

/// What a surface is made of, and from which side it is seen.
struct Surface {
  bool is_metal;
  bool is_front;
  dvec2 alpha;
  double ior = 1.5;
  double tau = 100;
};

dvec3 direction(double theta, double phi) {
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

/// At this angle above the horizon: the sine of a small angle keeps its digits.
dvec3 above_horizon(double elevation, double phi) {
  return {std::cos(elevation) * std::cos(phi), std::cos(elevation) * std::sin(phi), std::sin(elevation)};
}

Material material_of(const Surface& surface) {
  Material material{};
  material.base_color = material.specular_color = glm::vec3(1);
  material.metallic = surface.is_metal ? 1.0f : 0.0f;
  material.roughness = 1;
  material.ior = static_cast<float>(surface.ior);
  material.specular = 1;
  material.transmission = surface.is_metal ? 0.0f : 1.0f;
  material.flags = surface.is_metal ? 0u : MATERIAL_VOLUME;
  material.material_class = MATERIAL_CLASS_TRANSMISSIVE;
  return material;
}

/// A sweep that is being filled.
class Builder {
 public:
  Builder(BsdfSweep sweep) : sweep_(std::move(sweep)) {}

  void add(double parameter, const Surface& surface, const dvec3& wo, const dvec3& wi) {
    BsdfCase c;
    c.parameter = parameter;
    c.is_metal = surface.is_metal;
    c.inputs.material = material_of(surface);
    c.inputs.alpha = surface.alpha;
    c.inputs.is_front = surface.is_front ? 1 : 0;
    c.inputs.tau = static_cast<float>(surface.tau);
    c.inputs.wo = wo;
    c.inputs.wi = wi;
    // Numbers of a sample that wander over the unit cube from case to case.
    const auto wander = [&](double step) {
      return static_cast<float>(
          std::floor(std::fmod(step * (static_cast<double>(sweep_.cases.size()) + 0.5), 1) * 0x1p24) *
          0x1p-24);
    };
    c.inputs.u_lobe = wander(0.8191725134);
    c.inputs.u = {wander(0.6710436067), wander(0.5497004779)};
    sweep_.cases.push_back(c);
  }

  /// wo with the directions into which facets send it whose slopes are these multiples of alpha.
  void add_events(double parameter, const Surface& surface, const dvec3& wo) {
    const double eta = surface.is_front || surface.is_metal ? surface.ior : 1 / surface.ior;
    for (const double slope : {0.0, 0.4, 1.5}) {
      const dvec2 slopes = slope * surface.alpha * dvec2(0.8, 0.6);
      const dvec3 h = normalize(dvec3(slopes, 1));
      if (dot(wo, h) <= 0) continue;
      const dvec3 reflected = reference::reflect_at(wo, h);
      if (reflected.z > 0) add(parameter, surface, wo, reflected);
      if (surface.is_metal) continue;
      const dvec3 refracted = reference::refract_at(wo, h, eta);
      if (refracted.z < 0) add(parameter, surface, wo, refracted);
    }
  }

  /// The same for a metal and both sides of a solid.
  void add_all_events(double parameter, Surface surface, const dvec3& wo) {
    surface.is_front = surface.is_metal = true;
    add_events(parameter, surface, wo);
    surface.is_metal = false;
    add_events(parameter, surface, wo);
    surface.is_front = false;
    add_events(parameter, surface, wo);
  }

  BsdfSweep take() { return std::move(sweep_); }

 private:
  BsdfSweep sweep_;
};

constexpr double AZIMUTH = 0.4;

BsdfSweep over_roughness(int points) {
  Builder sweep({"over roughness", "alpha", LOBE | RAISED | WEIGHT, false, {}});
  for (const double alpha : in_equal_ratios(1e-7, 1, points))
    for (const double theta : {0.0, 0.6, 1.3, 1.55})
      sweep.add_all_events(alpha, {true, true, dvec2(static_cast<float>(alpha))}, direction(theta, AZIMUTH));
  return sweep.take();
}

BsdfSweep over_anisotropy(int points) {
  Builder sweep({"over anisotropy", "alpha across : along", LOBE | RAISED | WEIGHT, true, {}});
  for (const double ratio : in_equal_ratios(1, 1000, points))
    for (const double theta : {0.3, 1.4})
      for (const double azimuth : {0.0, AZIMUTH, pi / 2}) {
        sweep.add_all_events(ratio, {true, true, {1e-3, 1e-3 * ratio}}, direction(theta, azimuth));
        sweep.add_all_events(ratio, {true, true, {1, 1 / ratio}}, direction(theta, azimuth));
      }
  return sweep.take();
}

BsdfSweep over_elevation(int points) {
  Builder sweep({"at grazing incidence", "angle above the horizon, rad", LOBE | RAISED | WEIGHT, false, {}});
  for (const double elevation : in_equal_ratios(1e-6, 1, points))
    for (const double alpha : {0.01, 0.3})
      sweep.add_all_events(elevation, {true, true, dvec2(alpha)}, above_horizon(elevation, AZIMUTH));
  return sweep.take();
}

/// Both directions low, on the same side of the normal: so is their half vector.
BsdfSweep over_facet_elevation(int points) {
  Builder sweep({"half vector at the horizon", "angle above the horizon, rad", LOBE | RAISED, false, {}});
  for (const double elevation : in_equal_ratios(1e-6, 1, points))
    for (const double alpha : {0.1, 1.0})
      for (const bool is_metal : {true, false})
        sweep.add(elevation, {is_metal, true, dvec2(alpha)}, above_horizon(elevation, AZIMUTH),
                  above_horizon(0.7 * elevation, AZIMUTH + 0.3));
  return sweep.take();
}

BsdfSweep over_distance(int points) {
  Builder sweep({"wi next to wo", "angle between them, rad", LOBE | RAISED, false, {}});
  for (const double angle : in_equal_ratios(1e-7, 1, points))
    for (const double alpha : {0.1, 1.0})
      for (const bool is_metal : {true, false})
        for (const double theta : {0.2, 1.2})
          sweep.add(angle, {is_metal, true, dvec2(alpha)}, direction(theta, AZIMUTH),
                    direction(theta - angle, AZIMUTH));
  return sweep.take();
}

BsdfSweep over_incidence(int points) {
  Builder sweep({"at normal incidence", "angle with the normal, rad", LOBE | RAISED | WEIGHT, false, {}});
  for (const double theta : in_equal_ratios(1e-7, 1, points))
    for (const double alpha : {1e-3, 0.3})
      sweep.add_all_events(theta, {true, true, dvec2(alpha)}, direction(theta, AZIMUTH));
  return sweep.take();
}

BsdfSweep over_index(int points) {
  Builder sweep({"over the index", "n - 1, both sides", LOBE | RAISED | WEIGHT, false, {}});
  for (const double excess : in_equal_ratios(0x1p-23, 99, points))
    for (const double alpha : {0.05, 0.5})
      for (const double theta : {0.1, 1.0, 1.5})
        for (const bool is_front : {true, false})
          sweep.add_events(excess, {false, is_front, dvec2(alpha), static_cast<float>(1 + excess)},
                           direction(theta, AZIMUTH));
  return sweep.take();
}

/// From the dense side, before and beyond the critical angle of the mean facet.
BsdfSweep over_critical(int points) {
  Builder sweep({"at the critical angle", "angle from it, rad", LOBE | RAISED | WEIGHT, false, {}});
  for (const double distance : in_equal_ratios(1e-7, 0.1, points))
    for (const double alpha : {0.02, 0.5})
      for (const double sign : {-1.0, 1.0})
        sweep.add_events(distance, {false, false, dvec2(alpha)},
                         direction(std::asin(1 / 1.5) + sign * distance, AZIMUTH));
  return sweep.take();
}

BsdfSweep over_tau(int points) {
  Builder sweep({"over tau", "tau, 1/sr", RAISED, false, {}});
  std::vector<double> taus = in_equal_ratios(1e-3, 1e12, points);
  taus.push_back(std::numeric_limits<float>::max());  // as good as infinite: 4 pi of it are
  for (const double tau : taus)
    for (const double alpha : {1e-5, 0.05})
      for (const double theta : {0.1, 1.2, 1.55})
        sweep.add_all_events(tau, {true, true, dvec2(alpha), 1.5, tau}, direction(theta, AZIMUTH));
  return sweep.take();
}

}  // namespace

std::vector<BsdfSweep> bsdf_sweeps(Extent extent) {
  const int points = extent == Extent::Quick ? 8 : 22;
  std::vector<BsdfSweep> sweeps;
  for (BsdfSweep (*make)(int) : {over_roughness, over_anisotropy, over_elevation, over_facet_elevation,
                                 over_distance, over_incidence, over_index, over_critical, over_tau})
    sweeps.push_back(make(points));
  return sweeps;
}

}  // namespace regulus::stability
