// surface_footprints: path diffusion's footprint (lib/footprint.glsl) where the ray through the centres of a
// pixel and of the lens first meets a surface that diffuses. On the way there it follows each sharp surface:
// through glass, unless all is reflected. A dispatch walks one edge; path slots stand for pixels. reads
// frame.camera, scene, paths, path_footprints          writes  paths, path_footprints
#version 460
#extension GL_GOOGLE_include_directive : require
#define SCENE_QUERY_WITHOUT_MEDIA
#include "lib/scene_query.glsl"
#include "lib/film.glsl"
#include "lib/footprint.glsl"
#include "lib/shading.glsl"

// Follows the surface's last lobe: transmission if there is any. In rough lobes the ray keeps to the middle; they are so
// narrow that it does not matter where in them it goes.
BsdfSample follow(ShadingPoint point) {
  const float NARROW_ALPHA = 1e-4;
  Bsdf bsdf = point.bsdf;
  bsdf.alpha = min(bsdf.alpha, vec2(NARROW_ALPHA));
  bsdf.coat.alpha = min(bsdf.coat.alpha, vec2(NARROW_ALPHA));
  return bsdf_sample(bsdf, point.wo, ONE_MINUS_ULP, vec2(0.5), TRANSPORT_RADIANCE);
}

// Goes on from a surface that the path has met. False if the footprint is wanted there.
bool pass(Frame frame, ShadingPoint point, uint triangle, inout Path path, inout vec3 footprint) {
  if (diffuses(point.bsdf) || point.wo.z <= 0.0) return false;
  BsdfSample next = follow(point);
  if ((next.flags & BSDF_SAMPLE_VALID) == 0u) return false;
  vec3 direction;
  if (!to_world_lit(point, next.wi, direction)) return false;
  float curvature = curvature_at(frame, triangle);
  footprint = scattered(footprint, point.bsdf, next, point.is_front ? curvature : -curvature);
  path.origin = ray_origin(point, direction);
  path.direction = normalize(direction);
  return true;
}

void main() {
  uint slot = item_index();
  if (slot >= stage.wave_paths) return;
  Frame frame = FRAME;
  Path path = LOAD(PathBuffer, frame.paths, slot);
  vec3 footprint = LOAD(Vec3Buffer, frame.path_footprints, slot);
  if (stage.bounce == 0u) {
    uint pixel = pixel_of(frame, stage.first_pixel + slot);
    camera_ray(frame.camera, vec2(pixel % frame.width, pixel / frame.width) + 0.5,
               vec2(frame.width, frame.height), vec2(0.5), path.origin, path.direction);
    path.throughput = vec3(1.0);
    footprint = start_footprint(frame);
  }
  // A path that has ended carries nothing.
  if (path.throughput.x == 0.0) return;
  uint tag;
  vec2 range = WHOLE_RAY;
  if (stage.bounce == 0u) range = seen_range(path.direction);
  Hit hit = closest(path.origin, path.direction, range, tag);
  bool goes_on = false;
  if (hit.triangle == INVALID_INDEX) {
    footprint.x = uintBitsToFloat(0x7F800000u);
  } else {
    footprint = travelled(footprint, hit.t);
    ShadingPoint point =
        shading_point(frame, hit.triangle, vec2(hit.u, hit.v), -path.direction, TRANSPORT_RADIANCE, NO_MEDIA, BEND_OF_D_LINE);
    goes_on = stage.bounce + 1u < frame.max_depth && pass(frame, point, hit.triangle, path, footprint);
  }
  if (!goes_on) path.throughput = vec3(0.0);
  STORE(PathBuffer, frame.paths, slot, path);
  STORE(Vec3Buffer, frame.path_footprints, slot, footprint);
}
