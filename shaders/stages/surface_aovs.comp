// surface_aovs: what camera rays meet first, a function of the scene, the camera and the seed, whichever samples are
// rendered. A dispatch traces ray `round` of each pixel, the last of them through the centres of the pixel and
// of the lens; a loop over the rays here would take SwiftShader minutes to compile.
// reads  frame.camera, scene, aovs          writes  aovs, ids
#version 460
#extension GL_GOOGLE_include_directive : require
#define SCENE_QUERY_WITHOUT_MEDIA
#include "lib/scene_query.glsl"
#include "lib/camera.glsl"
#include "lib/film.glsl"
#include "lib/rng.glsl"
#include "lib/shading.glsl"
#include "lib/stage.glsl"

// Unlit surfaces show their emission.
vec3 albedo_of(Frame frame, ShadingPoint point) {
  if ((point.material.flags & MATERIAL_UNLIT) == 0u) return point.material.base_color;
  return emitted_radiance(frame, point.material, point.material.emission, point.surface.uv, point.surface.color);
}

// Meets the scene through film point `film` and a point of the lens that u chooses. False if there is nothing.
bool meet(Frame frame, vec2 film, vec2 u, out ShadingPoint point, out Hit hit) {
  vec3 origin, direction;
  camera_ray(frame.camera, film, vec2(frame.width, frame.height), u, origin, direction);
  uint tag;
  hit = closest(origin, direction, seen_range(direction), tag);
  if (hit.triangle == INVALID_INDEX) return false;
  point =
      shading_point(frame, hit.triangle, vec2(hit.u, hit.v), -direction, TRANSPORT_RADIANCE, NO_MEDIA, BEND_OF_D_LINE);
  return true;
}

void main() {
  Frame frame = FRAME;
  uint index = stage.first_pixel + item_index();
  if (index >= frame.crop.z * frame.crop.w) return;
  uint pixel = pixel_of(frame, index);
  uint ray = stage.surface_ray;
  bool is_centre = ray == AOV_RAYS;
  vec4 u = random_block(frame.seed, pixel, ray, DIMENSION_BLOCK_CAMERA);
  vec2 offset = is_centre ? vec2(0.0) : sample_filter(u.xy, frame.filter_radius, frame.filter_sigma);
  AovPixel result = AovPixel(vec3(0.0), uintBitsToFloat(0x7F800000u), vec3(0.0), INVALID_INDEX, vec3(0.0), INVALID_INDEX,
                             vec3(0.0), 0u);
  if (ray > 0u) result = LOAD(AovPixelBuffer, frame.aovs, index);
  ShadingPoint point;
  Hit hit;
  uvec2 ids = uvec2(INVALID_INDEX);
  if (meet(frame, vec2(pixel % frame.width, pixel / frame.width) + 0.5 + offset, is_centre ? vec2(0.5) : u.zw, point, hit)) {
    ids = uvec2(placed_triangle(frame, hit.triangle).triangle.instance, point.surface.material);
    if (is_centre) {
      result.position = point.surface.position;
      result.depth = dot(result.position - frame.camera.position, frame.camera.forward);
      result.material = ids.y;
      result.instance = ids.x;
    } else {
      result.albedo += albedo_of(frame, point) / float(AOV_RAYS);
      result.shading_normal += point.normal / float(AOV_RAYS);
      result.geometric_normal += point.geometric_normal / float(AOV_RAYS);
    }
  }
  STORE(AovPixelBuffer, frame.aovs, index, result);
  if (!has_state(STATE_IDS) || is_centre) return;
  uint place = 2u * (index * AOV_RAYS + ray);
  STORE(WordBuffer, frame.aov_ids, place, ids.x);
  STORE(WordBuffer, frame.aov_ids, place + 1u, ids.y);
}
