// camera_generate: starts the paths of a wave at the lens.
// reads  frame.camera          writes  paths, radiance (zeroed), ray queue of bounce 0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/camera.glsl"
#include "lib/film.glsl"
#include "lib/footprint.glsl"
#include "lib/history.glsl"
#include "lib/media.glsl"
#include "lib/rng.glsl"
#include "lib/queue.glsl"

void main() {
  uint slot = item_index();
  if (slot >= stage.wave_paths) return;
  Frame frame = FRAME;
  uint pixels = frame.crop.z * frame.crop.w;
  uint index = stage.first_pixel + slot;
  uint pixel = pixel_of(frame, index % pixels), sample_index = stage.first_sample + index / pixels;

  vec4 u = random_block(frame.seed, pixel, sample_index, DIMENSION_BLOCK_CAMERA);
  vec2 centre = vec2(pixel % frame.width, pixel / frame.width) + 0.5;
  Path path;
  camera_ray(frame.camera, centre + sample_filter(u.xy, frame.filter_radius, frame.filter_sigma),
             vec2(frame.width, frame.height), u.zw, path.origin, path.direction);
  path.mis_a = 0.0;
  if ((spec_techniques & TECHNIQUE_SPLAT) != 0u)
    path.mis_a = 1.0 / camera_ray_pdf(frame.camera, vec2(frame.width, frame.height), path.direction);
  path.mis_b = 0.0;
  path.number = pixel;
  path.throughput = vec3(1.0);
  path.sample_index = sample_index;
  path.eta_scale = 1.0;
  path.bounce = 0u;
  path.medium = INVALID_INDEX;
  if (has_contacts()) start_in_media(frame, frame.camera_media, INVALID_INDEX, vec2(0.0), slot, path);
  STORE(PathBuffer, frame.paths, slot, path);
  if (has_histories())
    STORE(PathHistoryBuffer, frame.path_histories, slot,
          start_history(path.mis_a, path.mis_b, camera_bound(frame)));
  if (has_footprints()) STORE(Vec3Buffer, frame.path_footprints, slot, start_footprint(frame));
  if (has_state(STATE_LAYERS)) STORE(WordBuffer, frame.path_trails, slot, 0u);
  STORE(Vec3Buffer, frame.radiance, slot, vec3(0.0));
  append_ray(0u, slot);
}
