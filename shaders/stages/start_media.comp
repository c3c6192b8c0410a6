// start_media: the solids that hold the start of each path, where they are not the same for all points of a camera or light.
// reads  paths, path_media          writes  paths, path_media
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/camera.glsl"
#include "lib/contacts.glsl"
#include "lib/stage.glsl"

void main() {
  uint slot = item_index();
  if (slot >= stage.wave_paths) return;
  Frame frame = FRAME;
  Path path = LOAD(PathBuffer, frame.paths, slot);
  if (path.medium != MEDIA_VARY) return;
  PathMedia media = LOAD(PathMediaBuffer, frame.path_media, slot);
  vec3 start = path.origin;
  if (spec_walk == WALK_CAMERA && has_clipping()) start += clipped_range(frame.camera, path.direction).x * path.direction;
  media.around = media_at(frame, start);
  path.medium = medium_of(frame, media.around);
  if (traversal_overrun != 0u) count_events(COUNTER_TRAVERSAL_OVERRUN, 1u);
  STORE(PathBuffer, frame.paths, slot, path);
  STORE(PathMediaBuffer, frame.path_media, slot, media);
}
