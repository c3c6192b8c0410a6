// Small pictures of scenes whose radiance is known, by the device and by the reference: emitters of any size
// and power, lights that touch what they light, skies with one bright texel.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "render/technique_sets.hpp"
#include "stability/families.hpp"
#include "stability/stage.hpp"

namespace regulus::stability {

using glm::dvec3;
using glm::vec3;
using namespace interface;

namespace {

constexpr double PI = std::numbers::pi;
using namespace technique_sets;

/// The plane z = 0, 6 m wide.
constexpr double ALBEDO = 0.5;
Stage lit_plane() {
  Stage stage;
  stage.add_quad({-3, -3, 0}, {6, 0, 0}, {0, 6, 0}, diffuse(ALBEDO, 0));
  return stage;
}

constexpr uint32_t PLANE_FILM = 4;

/// Mean over the film's pixel centres, within +- half_extent, of a light at height h that sends `intensity`
/// times the cosine's power along it.
Exact radiance_under(double half_extent, double h, Exact intensity, int cosine_power) {
  Exact sum = 0;
  for (uint32_t y = 0; y < PLANE_FILM; ++y)
    for (uint32_t x = 0; x < PLANE_FILM; ++x) {
      const Exact px = half_extent * (2 * (x + 0.5L) / PLANE_FILM - 1);
      const Exact py = half_extent * (2 * (y + 0.5L) / PLANE_FILM - 1);
      const Exact squared = px * px + py * py + Exact{h} * h;
      const Exact cosine = h / std::sqrt(squared);
      sum += intensity * std::pow(cosine, static_cast<Exact>(1 + cosine_power)) / squared;
    }
  return sum / (PLANE_FILM * PLANE_FILM) * ALBEDO / std::numbers::pi_v<Exact>;
}

constexpr double OWN = 100 * 0x1p-24;

SweepText text_of(const char* name, const char* parameter, std::string bound, double own = OWN) {
  // The picture of the reference has single precision as well.
  return {"pictures", name, parameter, std::move(bound), own, own};
}

/// A square emitter 1 m above the plane, of that side and power. Seen as one point it errs by less than four
/// sides: the irradiance is L s^2 cos^4.
void add_emitter(Sweep& sweep, double parameter, gpu::Device& device, double side, double power) {
  Stage stage = lit_plane();
  const double radiance = power / (PI * side * side);
  stage.add_quad({-side / 2, side / 2, 1}, {side, 0, 0}, {0, -side, 0}, diffuse(0, radiance));
  const PreparedScene prepared = stage.seen_from({0, 0, 0.5}, 1);
  const render::RenderSettings settings = settings_of(PT, PLANE_FILM, 4, 2);
  const Exact truth = radiance_under(1, 1, static_cast<Exact>(power) / std::numbers::pi_v<Exact>, 1);
  sweep.add({parameter, by_device(device, prepared, settings).value, by_reference(prepared, settings).value,
             truth, 0, truth * 4 * static_cast<Exact>(side), truth * 4 * static_cast<Exact>(side)},
            [&] { return fmt::format("an emitter of {:g} m and {:g} W, 1 m above a plane", side, power); });
}

Sweep emitters_over_size(gpu::Device& device, Extent extent) {
  Sweep sweep(
      text_of("light of an emitter over its size", "side, m",
              fmt::format("{:.1e} for 100 roundings, and 4 sides, because it is taken as a point", OWN)));
  for (const double side : in_equal_ratios(1e-10, 1e-2, extent == Extent::Quick ? 3 : 17))
    add_emitter(sweep, side, device, side, 1);
  return sweep;
}

Sweep emitters_over_power(gpu::Device& device, Extent extent) {
  Sweep sweep(text_of("light of an emitter over its power", "power, W",
                      fmt::format("{:.1e} for 100 roundings, and 4 sides of .1 mm", OWN)));
  for (const double power : in_equal_ratios(1e-20, 1e20, extent == Extent::Quick ? 3 : 41))
    add_emitter(sweep, power, device, 1e-4, power);
  return sweep;
}

/// A point light that comes down to the plane, seen within a tenth of its height. Rays start a little off the
/// plane.
Sweep point_light_over_height(gpu::Device& device, Extent extent) {
  // Clearance of rays on a plane with coordinates up to 3 (CONTACT_CLEARANCE), there and in the distance.
  constexpr double LIFT = CONTACT_CLEARANCE * 0x1p-24 * 3;
  Sweep sweep(
      text_of("a point light that touches a surface", "height, m",
              fmt::format("{:.1e} for 100 roundings, and what moving the light by the clearance of rays, "
                          "{:.1e} m, does",
                          OWN, LIFT)));
  for (const double height : in_equal_ratios(1e-9, 1, extent == Extent::Quick ? 4 : 28)) {
    Stage stage = lit_plane();
    const double h = static_cast<float>(height);
    stage.add_point_light({0, 0, h}, h * h);
    const double half_extent = static_cast<float>(0.1 * h);
    const PreparedScene prepared = stage.seen_from({0, 0, 0.5}, half_extent);
    const render::RenderSettings settings = settings_of(PT, PLANE_FILM, 1, 2);
    const Exact truth = radiance_under(half_extent, h, static_cast<Exact>(static_cast<float>(h * h)), 0);
    const Exact moved = truth * 4 * static_cast<Exact>(LIFT / h);
    sweep.add({height, by_device(device, prepared, settings).value, by_reference(prepared, settings).value,
               truth, moved, moved},
              [&] { return fmt::format("a point light {:g} m above a plane", height); });
  }
  return sweep;
}

/// Integral over one texel's angle and its neighbours', `step` each, of a function times the texel's share
/// there.
template <typename Function>
Exact integral_of_texel(Exact centre, Exact step, const Function& f) {
  constexpr int CELLS = 2000;
  Exact sum = 0;
  for (int i = 0; i < CELLS; ++i) {
    const Exact off = 2 * (i + 0.5L) / CELLS - 1;
    sum += (1 - std::abs(off)) * f(centre + off * step);
  }
  return sum * 2 * step / CELLS;
}

/// A plane under a sky of 1 with one texel that is brighter.
Sweep environments_over_texel(gpu::Device& device, Extent extent) {
  constexpr uint32_t WIDTH = 16, HEIGHT = 8, COLUMN = 12, ROW = 4;  // beside +z, the plane's normal
  constexpr Exact STEP = std::numbers::pi_v<Exact> / HEIGHT;        // of both angles
  // w.z = sin theta sin phi, and solid angles are sin theta dtheta dphi.
  const Exact share =
      integral_of_texel((ROW + 0.5L) * STEP, STEP,
                        [](Exact theta) { return std::sin(theta) * std::sin(theta); }) *
      integral_of_texel((COLUMN + 0.5L - 0.5L * WIDTH) * STEP, STEP, [](Exact phi) { return std::sin(phi); });
  constexpr double OWN_OF_SKIES = 1e-5;
  Sweep sweep(text_of(
      "one texel of an environment over its radiance", "radiance",
      fmt::format("{:.1e} for roundings and the known value, {} standard errors", OWN_OF_SKIES, SIGMAS),
      OWN_OF_SKIES));
  for (const double radiance : in_equal_ratios(1, 1e8, extent == Extent::Quick ? 3 : 17)) {
    std::vector<vec3> texels(size_t{WIDTH} * HEIGHT, vec3(1));
    texels[ROW * WIDTH + COLUMN] =
        vec3(static_cast<float>(radiance * 1.5));  // not the others', which would be no map
    Stage stage = lit_plane();
    stage.set_environment(scene::map_environment(std::move(texels), WIDTH, 0));
    const PreparedScene prepared = stage.seen_from({0, 0, 0.5}, 0.1);
    render::RenderSettings settings = settings_of(PT, 32, 8, 2);
    const Mean device_mean = by_device(device, prepared, settings);
    settings.width = settings.height = 16;
    const Mean reference_mean = by_reference(prepared, settings);
    const Exact truth =
        ALBEDO * (1 + (static_cast<float>(radiance * 1.5) - 1.0L) * share / std::numbers::pi_v<Exact>);
    sweep.add(
        {radiance, device_mean.value, reference_mean.value, truth, 0,
         static_cast<Exact>(SIGMAS * device_mean.error), static_cast<Exact>(SIGMAS * reference_mean.error)},
        [&] { return fmt::format("a texel of {:g} in a sky of 1", radiance * 1.5); });
  }
  return sweep;
}

}  // namespace

std::vector<Sweep> sweep_pictures(gpu::Device& device, Extent extent) {
  std::vector<Sweep> all;
  all.push_back(emitters_over_size(device, extent));
  all.push_back(emitters_over_power(device, extent));
  all.push_back(point_light_over_height(device, extent));
  all.push_back(environments_over_texel(device, extent));
  return all;
}

}  // namespace regulus::stability
