#include "reference/merge_radius.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "reference/walk.hpp"

namespace regulus::reference {

using glm::dvec2;
using glm::dvec3;

namespace {

constexpr uint32_t RAYS_PER_SIDE = 32;
constexpr uint32_t MOST_EDGES = 16;  // through mirrors and glass
// Random numbers that choose a perfectly specular surface's last lobe, which is transmission if there is any.
constexpr glm::dvec4 LAST_LOBE(1 - 0x1p-24, 0.5, 0.5, 0);

/// Points where rays met surfaces.
struct Points {
  std::vector<dvec3> positions;
  std::vector<double> depths;  // along the camera's axis, by the length of the path

  void add(const dvec3& position, double depth) {
    positions.push_back(position);
    depths.push_back(depth);
  }
};

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

bool shines(const World& world, const Surface& surface) {
  return world.emission_at(surface) != dvec3(0);
}

/// Follows one ray: the first surface of all, and the first where it can merge, if it comes to one.
void follow(const World& world, const CameraRay& start, double cos_axis, Points& first, Points& mergeable) {
  WalkState state{start.origin, start.direction};
  if (world.has_contacts()) state.place.around = world.media_at(start.start());
  Ray ray{start.origin, start.direction, start.nearest, start.farthest};
  double length = 0, cos_start = 1;
  for (uint32_t edge = 0; edge < MOST_EDGES; ++edge) {
    const std::optional<Intersection> hit = world.meet(ray, state.place);
    if (!hit) return;
    const Surface surface = world.surface_at(hit->triangle, hit->barycentrics);
    length += hit->t;
    if (edge == 0) first.add(surface.position, length * cos_axis);
    if (shines(world, surface)) return;
    WalkVertex vertex = arrive(world, surface, hit->t, state, cos_start, true);
    const double side = dot(vertex.w_back, surface.geometric_normal);
    if (vertex.bsdf.has_finite_lobe({0, 0, side})) return mergeable.add(surface.position, length * cos_axis);
    if (!scatter_from_camera(world, vertex, state, 0, LAST_LOBE)) return;
    cos_start = std::abs(dot(state.direction, surface.geometric_normal));
    ray = world.ray_from(surface, state.direction);
  }
}

double extent_of(const std::vector<dvec3>& positions) {
  std::vector<double> values(positions.size());
  dvec3 middle(0);
  for (int axis = 0; axis < 3; ++axis) {
    std::ranges::transform(positions, values.begin(), [&](const dvec3& position) { return position[axis]; });
    middle[axis] = median(values);
  }
  std::ranges::transform(positions, values.begin(),
                         [&](const dvec3& position) { return glm::length(position - middle); });
  return median(values);
}

double extent_of(const SeenSurfaces& seen, double scene_radius) {
  return seen.extent > 0 ? seen.extent : scene_radius;
}

float three_digits(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 2);
  return static_cast<float>(std::round(value / unit) * unit);
}

}  // namespace

SeenSurfaces see_surfaces(const World& world, const scene::SceneCamera& camera, uint32_t width,
                          uint32_t height) {
  const Camera film(scene::make_camera(camera, width, height), width, height);
  Points first, mergeable;
  for (uint32_t i = 0; i < RAYS_PER_SIDE * RAYS_PER_SIDE; ++i) {
    const dvec2 place = (dvec2(i % RAYS_PER_SIDE, i / RAYS_PER_SIDE) + 0.5) / double{RAYS_PER_SIDE};
    const CameraRay ray = film.ray(place * dvec2(width, height), dvec2(0.5));
    const double cos_axis = film.depth(ray.origin + ray.direction) - film.depth(ray.origin);
    follow(world, ray, cos_axis, first, mergeable);
  }
  const Points& seen = mergeable.positions.empty() ? first : mergeable;
  if (seen.positions.empty()) return {};
  // At distance 1 for a perspective picture, at any distance for an orthographic one.
  const double picture_height = height * std::sqrt(film.pixel_area());
  const double depth = film.is_orthographic() ? 1 : median(seen.depths);
  return {MERGE_FOOTPRINT * picture_height * depth, extent_of(seen.positions)};
}

MergeRadius default_merge_radius(const SeenSurfaces& seen, double scene_radius) {
  const double most = LARGEST_DEFAULT_RADIUS * seen.extent;
  if (!(seen.footprint > 0) || !(most > 0))
    return {three_digits(UNSEEN_RADIUS * scene_radius), "no surface seen: 0.3 % of the scene's radius"};
  if (seen.footprint > most) return {three_digits(most), "1 % of the extent seen"};
  return {three_digits(seen.footprint), "a thousandth of the picture's height"};
}

float radius_of_share(float share, const SeenSurfaces& seen, double scene_radius) {
  return three_digits(std::min(double{share}, 1.0) * extent_of(seen, scene_radius));
}

MergeRadius given_merge_radius(float metres, const SeenSurfaces& seen, double scene_radius) {
  const double extent = extent_of(seen, scene_radius);
  if (metres > LARGEST_GIVEN_RADIUS * extent)
    return {three_digits(LARGEST_GIVEN_RADIUS * extent), "given, clamped to 10 % of the extent seen"};
  if (metres < LEAST_GIVEN_RADIUS * extent)
    return {three_digits(LEAST_GIVEN_RADIUS * extent), "given, clamped to a millionth of the extent seen"};
  return {metres, "given"};
}

}  // namespace regulus::reference
