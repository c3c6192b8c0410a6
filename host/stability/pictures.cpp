// Small pictures of scenes whose radiance is known, by the device and by the reference: emitters of any size
// and power, lights that touch what they light, connections and merges where surfaces meet.
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "check/reference_render.hpp"
#include "prepared/prepared_scene.hpp"
#include "render/renderer.hpp"
#include "scene/environment.hpp"
#include "stability/families.hpp"

namespace regulus::stability {

using glm::dvec3;
using glm::vec3;
using namespace interface;

namespace {

constexpr double PI = std::numbers::pi;
constexpr uint32_t PT = TECHNIQUE_HIT | TECHNIQUE_NEE;
constexpr uint32_t VCM = PT | TECHNIQUE_SPLAT | TECHNIQUE_CONNECT | TECHNIQUE_MERGE;

Material diffuse(double albedo, double radiance) {
  Material material = scene::untextured_material();
  material.base_color = vec3(static_cast<float>(albedo));
  material.roughness = 1;
  material.ior = 1.5f;
  material.alpha = 1;
  material.emission = vec3(static_cast<float>(radiance));
  material.flags = radiance > 0 ? MATERIAL_EMISSIVE : 0;
  material.material_class = MATERIAL_CLASS_DIFFUSE;
  return material;
}

/// A scene under construction.
class Stage {
 public:
  /// The parallelogram corner, corner + u, corner + u + v, corner + v, its front towards cross(u, v).
  void add_quad(const dvec3& corner, const dvec3& u, const dvec3& v, const Material& material) {
    const auto first = static_cast<uint32_t>(scene_.vertices.size());
    for (const dvec3& position : {corner, corner + u, corner + u + v, corner + v}) {
      scene_.vertices.push_back({vec3(position), vec3(normalize(cross(u, v))), glm::vec2(0)});
      scene_.bounds_min =
          first == 0 && scene_.vertices.size() == 1 ? vec3(position) : min(scene_.bounds_min, vec3(position));
      scene_.bounds_max =
          scene_.vertices.size() == 1 ? vec3(position) : max(scene_.bounds_max, vec3(position));
    }
    const auto number = static_cast<uint32_t>(scene_.materials.size());
    scene_.materials.push_back(material);
    scene_.material_names.emplace_back();
    scene_.material_priorities.push_back(0);
    for (const uint32_t k : {1u, 2u})
      scene_.triangles.push_back({first, first + k, first + k + 1, number, INVALID_INDEX, number});
  }

  void add_point_light(const dvec3& position, double intensity) {
    Light light{};
    light.kind = LIGHT_POINT;
    light.triangle = light.material = INVALID_INDEX;
    light.position = vec3(position);
    light.intensity = vec3(static_cast<float>(intensity));
    scene_.lights.push_back(light);
  }

  void set_environment(scene::Environment environment) { scene_.environment = std::move(environment); }

  /// A camera that looks along -z at a square of these half extents.
  PreparedScene seen_from(const dvec3& eye, double half_extent) {
    scene::SceneCamera camera;
    camera.is_orthographic = true;
    camera.camera_to_world = glm::mat4(1);
    camera.camera_to_world[3] = glm::vec4(vec3(eye), 1);
    camera.x_magnification = camera.y_magnification = static_cast<float>(half_extent);
    scene_.cameras.push_back(camera);
    return prepare(std::move(scene_));
  }

 private:
  scene::Scene scene_;
};

render::RenderSettings settings_of(uint32_t techniques, uint32_t size, uint32_t samples, uint32_t depth) {
  render::RenderSettings settings;
  settings.width = settings.height = size;
  settings.samples = samples;
  settings.max_depth = depth;
  settings.techniques = techniques;
  settings.filter = FILTER_BOX;
  settings.filter_radius = 0;
  settings.keeps_merge_radius = true;
  return settings;
}

/// Mean of a picture, and its standard error if all pixels have the same expectation.
struct Mean {
  double value = 0, error = 0;
};

Mean mean_of(const image::Image& image) {
  double sum = 0;
  double squares = 0;
  const size_t pixels = image.rgb.size() / 3;
  for (size_t i = 0; i < pixels; ++i) {
    const double value = image.rgb[3 * i + 1];
    sum += value;
    squares += value * value;
  }
  const double n = static_cast<double>(pixels);
  const double mean = sum / n;
  return {mean, std::sqrt(std::max(squares / n - mean * mean, 0.0) / (n - 1))};
}

Mean by_device(gpu::Device& device, const PreparedScene& prepared, const render::RenderSettings& settings) {
  render::Renderer renderer(device, prepared, make_plan(prepared, settings));
  renderer.render([](uint64_t, uint64_t) { return true; });
  if (renderer.statistics().non_finite != 0) return {std::numeric_limits<double>::quiet_NaN(), 0};
  return mean_of(resolve(renderer.film()));
}

Mean by_reference(const PreparedScene& prepared, const render::RenderSettings& settings) {
  return mean_of(
      check::render_with_reference(prepared, make_plan(prepared, settings), [](uint64_t, uint64_t) {
        return true;
      }).image);
}

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

constexpr double SIGMAS = 6;  // of pixels that are far from normal where geometry terms are large

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

}  // namespace

std::vector<Sweep> sweep_pictures(gpu::Device& device, Extent extent) {
  std::vector<Sweep> all;
  all.push_back(emitters_over_size(device, extent));
  all.push_back(emitters_over_power(device, extent));
  all.push_back(point_light_over_height(device, extent));
  all.push_back(environments_over_texel(device, extent));
  all.push_back(connections_over_distance(device, extent));
  all.push_back(merges_over_radius(device, extent));
  return all;
}

}  // namespace regulus::stability
