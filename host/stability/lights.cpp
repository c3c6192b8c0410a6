// Spots down to a hundredth of a degree: what light paths start with, and what reaches a point inside the
// cone.
#include "reference/lights.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "interface/wavefront.h"
#include "stability/batch.hpp"
#include "stability/families.hpp"

namespace regulus::stability {

using glm::dvec3;
using glm::vec3;
using namespace interface;

namespace {

constexpr double OWN = 30 * 0x1p-24;
constexpr double OWN_REFERENCE = 30 * 0x1p-53;
constexpr int SPOTS_OF_AN_ANGLE = 20;

Exact height_of(Exact angle) {
  return 2 * std::sin(angle / 2) * std::sin(angle / 2);
}

/// A spot whose light falls off from half its angle on, and a point at a share of its angle from the axis.
struct SpotCase {
  double degrees;
  StabilitySpot spot;
};

std::vector<SpotCase> spot_cases(Extent extent) {
  std::vector<SpotCase> cases;
  for (const double degrees : in_equal_ratios(1e-2, 90, extent == Extent::Quick ? 9 : 51)) {
    const Exact outer = static_cast<Exact>(degrees) * std::numbers::pi_v<Exact> / 180;
    for (int i = 0; i < SPOTS_OF_AN_ANGLE; ++i) {
      const float share = (static_cast<float>(i) + 0.5f) / SPOTS_OF_AN_ANGLE;
      const double off = static_cast<double>(outer * share);
      const double around = 2.4 * i;  // anywhere
      const dvec3 receiver(std::sin(off) * std::cos(around), std::sin(off) * std::sin(around), std::cos(off));
      cases.push_back({degrees,
                       {static_cast<float>(height_of(outer / 2)),
                        static_cast<float>(height_of(outer)),
                        {share, 0.3f},
                        vec3(2.0 * receiver)}});
    }
  }
  return cases;
}

Light light_of(const StabilitySpot& spot) {
  Light light{};
  light.kind = LIGHT_SPOT;
  light.intensity = vec3(1);
  light.direction = vec3(0, 0, 1);
  light.inner_height = spot.inner_height;
  light.outer_height = spot.outer_height;
  return light;
}

/// Of a spot at the origin, at the receiver; the receiver is in extended precision.
Exact irradiance(const StabilitySpot& spot, const glm::vec<3, Exact>& receiver) {
  const Exact across = receiver.x * receiver.x + receiver.y * receiver.y;
  const Exact squared = across + receiver.z * receiver.z;
  const Exact height = across / (squared + receiver.z * std::sqrt(squared));
  const Exact width = Exact{spot.outer_height} - spot.inner_height;
  const Exact linear = std::clamp((spot.outer_height - height) / width, Exact{0}, Exact{1});
  return linear * linear / squared;
}

/// How far it moves as the receiver's coordinates and the light's heights do; the direction to the light has
/// rounded coordinates of its own, of length 1.
Exact moved_irradiance(const StabilitySpot& spot, const glm::vec<3, Exact>& receiver) {
  const Exact truth = irradiance(spot, receiver);
  Exact sum = 0;
  for (int axis = 0; axis < 3; ++axis) {
    Exact most = 0;
    for (const Exact sign : {-1.0L, 1.0L}) {
      glm::vec<3, Exact> there = receiver;
      there[axis] += sign * static_cast<Exact>(ROUNDING_OF_INPUTS) * length(receiver);
      most = std::max(most, std::abs(irradiance(spot, there) - truth));
    }
    sum += most;
  }
  return sum;
}

}  // namespace

std::vector<Sweep> sweep_lights(gpu::Device& device, Extent extent) {
  Sweep power({"lights", "power of a spot over its angle", "half angle, degrees",
               fmt::format("{:.1e} for 30 roundings", OWN), OWN, OWN_REFERENCE});
  Sweep received(
      {"lights", "light of a spot inside its cone over its angle", "half angle, degrees",
       fmt::format("{:.1e} for 30 roundings; what moving each coordinate by 2 ulp of the distance does", OWN),
       OWN, OWN_REFERENCE});
  const std::vector<SpotCase> cases = spot_cases(extent);
  std::vector<StabilitySpot> spots;
  spots.reserve(cases.size());
  for (const SpotCase& c : cases) spots.push_back(c.spot);
  const gpu::Kernel kernel = create_kernel(device, "spot", {{SPEC_FEATURES, FEATURE_POINT_LIGHTS}});
  const auto found = map_on_device<StabilityEmission>(device, kernel, spots);
  for (size_t i = 0; i < cases.size(); ++i) {
    const StabilitySpot& spot = cases[i].spot;
    const Light light = light_of(spot);
    const auto describe = [&] {
      return fmt::format("{:.9g} degrees, receiver ({:.9g} {:.9g} {:.9g})", cases[i].degrees, spot.receiver.x,
                         spot.receiver.y, spot.receiver.z);
    };
    const Exact inner = spot.inner_height;
    const Exact solid_angle = 2 * std::numbers::pi_v<Exact> * (inner + (spot.outer_height - inner) / 3);
    power.add({cases[i].degrees, found[i].throughput, reference::spot_solid_angle(light), solid_angle, 0},
              describe);
    const dvec3 receiver(spot.receiver);
    received.add({cases[i].degrees, found[i].irradiance,
                  reference::spot_falloff(light, normalize(receiver)) / dot(receiver, receiver),
                  irradiance(spot, receiver), moved_irradiance(spot, receiver)},
                 describe);
  }
  return {power, received};
}

}  // namespace regulus::stability
