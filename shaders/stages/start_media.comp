// start_media: the solids that hold the start of each path, where they are not the same for all points of a camera or light.
// Emitters that were connected to a lens in unknown media (light_generate) are dimmed by these.
// reads  paths, path_media, splat candidates          writes  the same
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/camera.glsl"
#include "lib/queue.glsl"
#include "lib/scene_query.glsl"
#include "lib/shading.glsl"
#include "lib/strategies.glsl"

// Dims an emitter that the lens sees by what lies before the lens, where the segment starts.
void dim_splat(Frame frame, uint i) {
  SplatCandidate splat = LOAD(SplatBuffer, frame.splats, i);
  PathMedia media = LOAD(PathMediaBuffer, frame.splat_media, i);
  media.around = media_at(frame, splat.segment.origin);
  vec3 passed = transmittance(frame, medium_of(frame, media.around), splat.segment.t_max);
  splat.segment.contribution *= passed;
  STORE(SplatBuffer, frame.splats, i, splat);
  STORE(PathMediaBuffer, frame.splat_media, i, media);
  if (!has_strategies()) return;
  StrategyCandidate strategy = LOAD(StrategyCandidateBuffer, frame.splat_strategies, i);
  strategy.unweighted *= passed;
  STORE(StrategyCandidateBuffer, frame.splat_strategies, i, strategy);
}

void main() {
  uint slot = item_index();
  if (slot >= stage.wave_paths) return;
  Frame frame = FRAME;
  if (spec_walk == WALK_LIGHT && connects_emitters() && frame.camera_media == MEDIA_VARY && slot < queue_count(QUEUE_SPLATS))
    dim_splat(frame, slot);
  Path path = LOAD(PathBuffer, frame.paths, slot);
  if (path.medium != MEDIA_VARY) return;
  PathMedia media = LOAD(PathMediaBuffer, frame.path_media, slot);
  vec3 start = path.origin;
  if (spec_walk == WALK_CAMERA && has_clipping()) start += clipped_range(frame.camera, path.direction).x * path.direction;
  media.around = media_at(frame, start);
  path.medium = medium_of(frame, media.around);
  count_overrun();
  STORE(PathBuffer, frame.paths, slot, path);
  STORE(PathMediaBuffer, frame.path_media, slot, media);
}
