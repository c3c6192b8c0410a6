#include "reference/subpaths.hpp"

#include <algorithm>
#include <cmath>

namespace regulus::reference {

using glm::dvec3;
using namespace interface;

namespace {

Path path_of_length(size_t length) {
  Path path;
  path.edges.resize(length);
  path.vertices.resize(length + 1);
  return path;
}

/// The first `edges` edges and the vertices between them from a light walk.
void set_light_part(Path& path, const LightSubpath& light, size_t edges) {
  for (size_t m = 1; m <= edges; ++m) path.edges[m - 1] = light.vertices[m - 1].edge;
  for (size_t m = 1; m < edges; ++m) path.vertices[m] = light.vertices[m - 1].scattering;
  if (edges > 0) path.light = light.end;
  path.response = light.response;
}

/// The last `edges` edges and the vertices between them from a camera walk.
void set_camera_part(Path& path, const CameraSubpath& camera, size_t edges) {
  const size_t length = path.length();
  for (size_t m = 1; m <= edges; ++m) path.edges[length - m] = camera.vertices[m - 1].edge;
  for (size_t m = 1; m < edges; ++m) path.vertices[length - m] = camera.vertices[m - 1].scattering;
  path.camera = camera.density;
  path.camera_bound = camera.bound;
  path.longest_edge = camera.longest_edge;
  path.response = camera.response;
}

bool is_black(const dvec3& color) {
  return !(color.r > 0 || color.g > 0 || color.b > 0);
}

/// True if a connection or merge at vertices first .. last carries nothing, regularized or not.
bool is_dark(const Path& path, size_t first, size_t last) {
  dvec3 regularized(1);
  dvec3 plain(1);
  for (size_t i = first; i <= last; ++i) {
    regularized *= connected_at(path, i).value;
    plain *= path.vertices[i].value;
  }
  return is_black(regularized) && is_black(plain);
}

/// The tries of virtual merges, if the regularization has any.
VirtualTries tries_of(const Regularization& regularization, const Stream& stream, uint32_t end,
                      size_t camera_edges, size_t light_edges, uint32_t light_path) {
  if (!regularization.is_virtual) return {};
  return virtual_tries(stream, end, camera_edges, light_edges, light_path);
}

double cosine(const Surface& surface, const dvec3& w) {
  return std::abs(dot(w, surface.geometric_normal));
}

/// The direction that tells connection_pdf() which side of a camera walk's vertex is lit, for light from
/// direction w: w itself, or if it lies beyond the facet's horizon the camera's.
dvec3 looks_towards(const WalkVertex& vertex, const dvec3& w) {
  return is_beyond_horizon(vertex.surface, w, vertex.w_back) ? vertex.w_back : w;
}

}  // namespace

std::optional<SampledPath> hit_light(const World& world, const CameraSubpath& camera, size_t edges) {
  const WalkVertex& last = camera.vertices[edges - 1];
  const std::optional<LightPoint> point = light_point_at(last.surface);
  if (!point) return std::nullopt;
  SampledPath sampled{path_of_length(edges), TECHNIQUE_HIT, 0, last.survival};
  set_camera_part(sampled.path, camera, edges);
  sampled.path.light = light_end(world, *point, last.w_back, last.surface.position);
  if (edges > 1)
    sampled.path.light.connect_pdf = connection_pdf(world, *point, camera.vertices[edges - 2].surface,
                                                    looks_towards(camera.vertices[edges - 2], -last.w_back));
  if (is_black(sampled.path.light.emitted)) return std::nullopt;
  return sampled;
}

std::optional<SampledPath> hit_environment(const World& world, const CameraSubpath& camera) {
  if (!camera.escape) return std::nullopt;
  const Escape& escape = *camera.escape;
  const std::optional<LightPoint> point = environment_point(world, escape.direction);
  if (!point) return std::nullopt;
  const size_t edges = camera.vertices.size();
  SampledPath sampled{path_of_length(edges + 1), TECHNIQUE_HIT, 0, escape.survival};
  set_camera_part(sampled.path, camera, edges);
  sampled.path.edges[0].cos_camera_end = escape.cos_start;
  sampled.path.light = light_end(world, *point, -escape.direction,
                                 edges > 0 ? camera.vertices[edges - 1].surface.position : camera.ray.origin);
  if (edges > 0) {
    const WalkVertex& last = camera.vertices[edges - 1];
    sampled.path.vertices[1] = last.scattering;
    sampled.path.light.connect_pdf =
        connection_pdf(world, *point, last.surface, looks_towards(last, escape.direction));
  }
  if (is_black(sampled.path.light.emitted)) return std::nullopt;
  return sampled;
}

std::optional<SampledPath> connect_to_light(const World& world, const LightPoint& point,
                                            const CameraSubpath& camera, size_t edges) {
  const WalkVertex& last = camera.vertices[edges - 1];
  const bool is_distant = point.is_distant();
  const dvec3 to_light = is_distant ? point.direction : point.surface.position - last.surface.position;
  const dvec3 w = normalize(to_light);
  SampledPath sampled{path_of_length(edges + 1), TECHNIQUE_NEE, 1, last.survival};
  Path& path = sampled.path;
  set_camera_part(path, camera, edges);
  path.light = light_end(world, point, -w, last.surface.position);
  path.light.connect_pdf = connection_pdf(world, point, last.surface, looks_towards(last, w));
  path.vertices[1] =
      scattering_between(last.surface, last.bsdf, w, last.w_back, last.regularization,
                         tries_of(last.regularization, camera.stream, VIRTUAL_MERGE_AT_CAMERA, edges, 0, 0));
  if (is_black(path.light.emitted) || is_dark(path, 1, 1)) return std::nullopt;

  Edge& edge = path.edges[0];
  edge.distance = is_distant ? 0 : length(to_light);  // a medium has no far end to measure from
  edge.cos_light_end = point.is_triangle() ? cosine(point.surface, w) : 1;
  edge.cos_camera_end = cosine(last.surface, w);
  const bool is_beyond = path.vertices[1].is_beyond;
  edge.transmittance = world.transmittance(
      world.medium_towards(last.surface, last.medium, last.around, last.w_back, w, is_beyond), edge.distance);
  edge.transmittance *= range_share(world, point, edge.distance);
  const Place place = world.place_towards(last.surface, last.around, last.w_back, w, is_beyond);
  const bool is_visible = is_distant ? world.is_open(last.surface, place, w, is_beyond)
                                     : world.is_visible(last.surface, place, point.surface.position,
                                                        point.surface.triangle, is_beyond);
  if (!is_visible) return std::nullopt;
  return sampled;
}

std::optional<SampledPath> connect_vertices(const World& world, const LightSubpath& light, size_t light_edges,
                                            const CameraSubpath& camera, size_t camera_edges) {
  const WalkVertex& from = camera.vertices[camera_edges - 1];
  const WalkVertex& to = light.vertices[light_edges - 1];
  const dvec3 segment = to.surface.position - from.surface.position;
  const dvec3 w = normalize(segment);
  SampledPath sampled{path_of_length(light_edges + camera_edges + 1), TECHNIQUE_CONNECT, light_edges + 1,
                      from.survival * to.survival};
  Path& path = sampled.path;
  set_light_part(path, light, light_edges);
  set_camera_part(path, camera, camera_edges);
  const auto tries = [&](uint32_t end) {
    return tries_of(light.regularization, camera.stream, end, camera_edges, light_edges, light.stream.index);
  };
  path.vertices[light_edges] = scattering_between(to.surface, to.bsdf, to.w_back, -w, light.regularization,
                                                  tries(VIRTUAL_MERGE_AT_LIGHT));
  path.vertices[light_edges + 1] = scattering_between(from.surface, from.bsdf, w, from.w_back,
                                                      from.regularization, tries(VIRTUAL_MERGE_AT_CAMERA));
  if (is_dark(path, light_edges, light_edges + 1)) return std::nullopt;

  Edge& edge = path.edges[light_edges];
  edge.distance = length(segment);
  edge.cos_light_end = cosine(to.surface, w);
  edge.cos_camera_end = cosine(from.surface, w);
  const bool is_beyond = path.vertices[light_edges + 1].is_beyond;
  edge.transmittance = world.transmittance(
      world.medium_towards(from.surface, from.medium, from.around, from.w_back, w, is_beyond), edge.distance);
  const Place place = world.place_towards(from.surface, from.around, from.w_back, w, is_beyond);
  if (!world.is_visible(from.surface, place, to.surface.position, to.surface.triangle, is_beyond))
    return std::nullopt;
  return sampled;
}

std::optional<SampledPath> connect_to_lens(const World& world, const Camera& lens, uint32_t lens_medium,
                                           const LightSubpath& light, size_t edges,
                                           const glm::dvec2& u_lens) {
  if (edges == 0 && !light.point.is_triangle()) return std::nullopt;
  const Surface& surface = edges == 0 ? light.point.surface : light.vertices[edges - 1].surface;
  const std::optional<Camera::Projection> projection = lens.project(surface.position, u_lens);
  if (!projection) return std::nullopt;
  const dvec3 w = -projection->ray.direction;
  SampledPath sampled{path_of_length(edges + 1), TECHNIQUE_SPLAT, edges + 1, 1, projection->film};
  Path& path = sampled.path;
  set_light_part(path, light, edges);
  path.camera = lens.density(projection->ray.direction);
  path.longest_edge = 2 * world.radius();
  path.camera_bound = camera_bound(lens, path.longest_edge);
  uint32_t medium = INVALID_INDEX;
  Place place;
  if (edges == 0) {
    path.light = light_end(world, light.point, w, surface.position);
    place = place_of_light(world, light.point, world.ray_from(surface, w));
    medium = world.medium_of(place.around);
  } else {
    const WalkVertex& last = light.vertices[edges - 1];
    sampled.survival = last.survival;
    path.vertices[edges] =
        scattering_between(surface, last.bsdf, last.w_back, w, light.regularization,
                           tries_of(light.regularization, light.stream, VIRTUAL_MERGE_AT_LIGHT, 0, edges, 0));
    medium = world.medium_towards(surface, last.medium, last.around, last.w_back, w);
    place = world.place_towards(surface, last.around, last.w_back, w);
  }
  if (edges == 0 ? is_black(path.light.emitted) : is_dark(path, edges, edges)) return std::nullopt;

  Edge& edge = path.edges[edges];
  edge.distance = length(projection->ray.origin - surface.position);
  edge.cos_light_end = cosine(surface, w);
  const double cut = world.has_contacts() ? projection->ray.nearest : 0;
  edge.transmittance =
      world.transmittance(medium, edge.distance - cut) * world.transmittance(lens_medium, cut);
  if (!world.is_visible(surface, place, projection->ray.start())) return std::nullopt;
  return sampled;
}

std::optional<SampledPath> merge_vertices(const LightSubpath& light, size_t light_edges,
                                          const CameraSubpath& camera, size_t camera_edges) {
  const WalkVertex& at = camera.vertices[camera_edges - 1];
  const WalkVertex& other = light.vertices[light_edges - 1];
  // Each walk met the surface with the probability of its coverage, but the path has that factor once.
  const double coverage = std::max(at.surface.coverage, 1e-3);
  SampledPath sampled{path_of_length(light_edges + camera_edges), TECHNIQUE_MERGE, light_edges,
                      at.survival * other.survival * coverage};
  Path& path = sampled.path;
  set_light_part(path, light, light_edges);
  set_camera_part(path, camera, camera_edges);
  path.vertices[light_edges] =
      scattering_between(at.surface, at.bsdf, other.w_back, at.w_back, at.regularization,
                         tries_of(at.regularization, camera.stream, VIRTUAL_MERGE_AT_MERGE, camera_edges,
                                  light_edges, light.stream.index));
  if (path.vertices[light_edges].is_beyond || is_dark(path, light_edges, light_edges)) return std::nullopt;
  return sampled;
}

}  // namespace regulus::reference
