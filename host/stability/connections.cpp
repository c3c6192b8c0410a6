// Connections and merges where surfaces meet: in corners, at borders of materials, through the horizon.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "render/technique_sets.hpp"
#include "stability/families.hpp"
#include "stability/stage.hpp"

namespace regulus::stability {

using glm::dvec3;
using namespace interface;

namespace {

constexpr double PI = std::numbers::pi;
using namespace technique_sets;

SweepText text_of(const char* name, const char* parameter, std::string bound, double own,
                  double floor = 1e-30) {
  // The picture of the reference has single precision as well.
  return {"connections", name, parameter, std::move(bound), own, own, floor};
}

constexpr uint32_t EDGES = 10;  // of paths in the room

/// A closed room of 2 m that emits 1 and reflects half: everywhere as much as a series of halves.
PreparedScene furnace(double distance) {
  Stage stage;
  const Material wall = diffuse(0.5, 1);
  stage.add_quad({-1, -1, -1}, {2, 0, 0}, {0, 2, 0}, wall);
  stage.add_quad({-1, -1, 1}, {0, 2, 0}, {2, 0, 0}, wall);
  stage.add_quad({-1, -1, -1}, {0, 2, 0}, {0, 0, 2}, wall);
  stage.add_quad({1, -1, -1}, {0, 0, 2}, {0, 2, 0}, wall);
  stage.add_quad({-1, -1, -1}, {0, 0, 2}, {2, 0, 0}, wall);
  stage.add_quad({-1, 1, -1}, {2, 0, 0}, {0, 0, 2}, wall);
  return stage.seen_from({-1 + distance, 0.1, 0}, distance / 4);
}

void add_furnace(Sweep& sweep, double parameter, gpu::Device& device, double distance, double radius) {
  const PreparedScene prepared = furnace(distance);
  render::RenderSettings settings = settings_of(VCM, 32, 2, EDGES);
  settings.merge_radius = static_cast<float>(radius);
  const Mean device_mean = by_device(device, prepared, settings);
  settings.width = settings.height = 8;
  const Mean reference_mean = by_reference(prepared, settings);
  // What lies within a radius of an edge merges with up to a quarter more or less than a disk has, over all
  // bounces.
  const double edges = 2 * radius;
  const Exact truth = 2 * (1 - std::ldexp(1.0L, -static_cast<int>(EDGES)));
  sweep.add(
      {parameter, device_mean.value, reference_mean.value, truth, 0,
       static_cast<Exact>(SIGMAS * device_mean.error + edges),
       static_cast<Exact>(SIGMAS * reference_mean.error + edges)},
      [&] { return fmt::format("{:g} m from the edge of a room, merge radius {:g} m", distance, radius); });
}

// A hundred roundings a bounce.
constexpr double OWN_OF_ROOMS = 100 * EDGES * 0x1p-24;

Sweep connections_over_distance(gpu::Device& device, Extent extent) {
  Sweep sweep(text_of("all techniques beside an edge of a closed room", "distance from the edge, m",
                      fmt::format("{:.1e} for roundings, {} standard errors", OWN_OF_ROOMS, SIGMAS),
                      OWN_OF_ROOMS));
  for (const double distance : in_equal_ratios(1e-7, 1e-1, extent == Extent::Quick ? 2 : 13))
    add_furnace(sweep, distance, device, distance, 1e-6);
  return sweep;
}

Sweep merges_over_radius(gpu::Device& device, Extent extent) {
  Sweep sweep(
      text_of("all techniques over the merge radius in a closed room", "merge radius, m",
              fmt::format("{:.1e} for roundings, {} standard errors, and the radius", OWN_OF_ROOMS, SIGMAS),
              OWN_OF_ROOMS));
  for (const double radius : in_equal_ratios(1e-7, 1e-1, extent == Extent::Quick ? 2 : 13))
    add_furnace(sweep, radius, device, 0.2, radius);
  return sweep;
}

constexpr double OWN = 100 * 0x1p-24;

/// The edge of a square of albedo .2 that is seen, beside one of .8, under a sun. A merge counts light that
/// falls across the border by what is seen, so that the border does not show.
void add_border(Sweep& sweep, gpu::Device& device, double radius) {
  constexpr double SEEN = 0.2;
  constexpr double ACROSS = 0.8;
  constexpr uint32_t SAMPLES = 16;
  const double low = 2.1 * radius;
  Stage stage;
  stage.add_quad({0, -low, 0}, {3.7 * radius, 0, 0}, {0, 2 * low, 0}, diffuse(SEEN, 0));
  stage.add_quad({-1.2 * radius, -low, 0}, {1.2 * radius, 0, 0}, {0, 2 * low, 0}, diffuse(ACROSS, 0));
  stage.add_sun(1);
  const PreparedScene prepared = stage.seen_from({radius, 0, radius}, radius);
  render::RenderSettings settings = settings_of(TECHNIQUE_MERGE, 32, SAMPLES, 2);
  settings.merge_radius = static_cast<float>(radius);
  const double device_mean = by_device(device, prepared, settings).value;
  settings.width = settings.height = 16;
  const double reference_mean = by_reference(prepared, settings).value;
  // Light paths fall on the disk around the scene, and by its share into the square that is seen; each counts
  // alike, or less near the rim.
  const double disk = PI * (2.45 * 2.45 + 2.1 * 2.1);
  const auto chance = [&](double paths) {
    return static_cast<Exact>(SIGMAS * SEEN / PI / std::sqrt(paths * SAMPLES * 4 / disk));
  };
  sweep.add({radius, device_mean, reference_mean, static_cast<Exact>(SEEN) / std::numbers::pi_v<Exact>, 0,
             chance(32 * 32), chance(16 * 16)},
            [&] { return fmt::format("a border of materials, merge radius {:g} m", radius); });
}

Sweep merges_at_borders(gpu::Device& device, Extent extent) {
  Sweep sweep(
      text_of("merges at a border of materials", "merge radius, m",
              fmt::format("{:.1e} for roundings, {} standard errors of the light paths that fall into "
                          "what is seen",
                          OWN, SIGMAS),
              OWN));
  for (const double radius : in_equal_ratios(1e-6, 1e2, extent == Extent::Quick ? 2 : 9))
    add_border(sweep, device, radius);
  return sweep;
}

constexpr double RISING_ALBEDO = 0.5;

/// Radiance of light that fell on the slope x < 0, of this angle, and then on the level square x > 0: its
/// mean over .25 < x < .75, |y| < .25. With t from the crease, cosines are t sin / d and x sin / d.
Exact radiance_of_rise(Exact angle) {
  constexpr int SEEN = 16;
  constexpr int CELLS = 64;
  const Exact s = std::sin(angle);
  const Exact c = std::cos(angle);
  const auto middle = [](int i, int count) { return (i + 0.5L) / count; };
  Exact sum = 0;
  for (int i = 0; i < SEEN; ++i)
    for (int j = 0; j < SEEN; ++j)
      for (int k = 0; k < CELLS; ++k)
        for (int l = 0; l < CELLS; ++l) {
          const Exact x = 0.25L + 0.5L * middle(i, SEEN);
          const Exact y = 0.25L - 0.5L * middle(j, SEEN);
          const Exact t = middle(k, CELLS);
          const Exact across = middle(l, CELLS) - 0.5L - y;
          const Exact squared = (x + c * t) * (x + c * t) + across * across + s * t * s * t;
          sum += s * t * s * x / (squared * squared);
        }
  const Exact albedo = static_cast<Exact>(RISING_ALBEDO) / std::numbers::pi_v<Exact>;
  return albedo * albedo * c * sum / (SEEN * SEEN * CELLS * CELLS);
}

/// A level square and beside it one that rises, or with a negative angle falls, under a sun: what connections
/// alone bring from one to the other.
void add_crease(Sweep& sweep, gpu::Device& device, double angle) {
  const double s = std::sin(angle);
  const double c = std::cos(angle);
  Stage stage;
  stage.add_quad({0, -0.5, 0}, {1, 0, 0}, {0, 1, 0}, diffuse(RISING_ALBEDO, 0));
  stage.add_quad({-c, -0.5, s}, {c, 0, -s}, {0, 1, 0}, diffuse(RISING_ALBEDO, 0));
  stage.add_sun(1);
  const PreparedScene prepared = stage.seen_from({0.5, 0, 1.5}, 0.25);
  render::RenderSettings settings = settings_of(TECHNIQUE_CONNECT, 32, 16, 3);
  const Mean device_mean = by_device(device, prepared, settings);
  settings.width = settings.height = 16;
  const Mean reference_mean = by_reference(prepared, settings);
  const Exact truth = angle > 0 ? radiance_of_rise(angle) : 0;
  // Rays start off both surfaces by their clearance, beside which the heights of what is seen, .25 m from the
  // crease and beyond, over the other's plane must be large. In the reference corners are rounded to floats,
  // and with them two cosines.
  constexpr double LIFT = CONTACT_CLEARANCE * 0x1p-24;
  const Exact moved = truth * static_cast<Exact>(2 * LIFT / (0.25 * std::abs(angle)));
  const Exact rounded = truth * 0x1p-21L / std::abs(static_cast<Exact>(angle));
  sweep.add({std::abs(angle), device_mean.value, reference_mean.value, truth, moved,
             static_cast<Exact>(SIGMAS * device_mean.error),
             static_cast<Exact>(SIGMAS * reference_mean.error) + rounded},
            [&] { return fmt::format("two squares that meet at {:g} rad off a plane", angle); });
}

Sweep connections_above_the_horizon(gpu::Device& device, Extent extent) {
  constexpr double OWN_OF_RISES = 2e-3;
  Sweep sweep(text_of("connections just above the horizon", "angle, rad",
                      fmt::format("{:.0e} for the known value, the clearance of rays, {} standard errors",
                                  OWN_OF_RISES, SIGMAS),
                      OWN_OF_RISES));
  for (const double angle : in_equal_ratios(1e-7, 1, extent == Extent::Quick ? 3 : 15))
    add_crease(sweep, device, angle);
  return sweep;
}

Sweep connections_through_the_horizon(gpu::Device& device, Extent extent) {
  // Roundings of corners raise two cosines by 2^-23 at most.
  constexpr double OWN_BELOW = 1e-12;
  Sweep sweep(text_of("no light through the horizon", "angle below, rad",
                      fmt::format("{:.0e} of what a right angle brings: two cosines of rounding", OWN_BELOW),
                      OWN_BELOW, static_cast<double>(radiance_of_rise(1))));
  for (const double angle : in_equal_ratios(1e-7, 1, extent == Extent::Quick ? 3 : 15))
    add_crease(sweep, device, -angle);
  return sweep;
}

}  // namespace

std::vector<Sweep> sweep_connections(gpu::Device& device, Extent extent) {
  std::vector<Sweep> all;
  all.push_back(connections_over_distance(device, extent));
  all.push_back(merges_over_radius(device, extent));
  all.push_back(merges_at_borders(device, extent));
  all.push_back(connections_above_the_horizon(device, extent));
  all.push_back(connections_through_the_horizon(device, extent));
  return all;
}

}  // namespace regulus::stability
