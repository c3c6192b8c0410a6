// trace_splats: adds what each light vertex that the lens sees contributes to the pixels whose filter reaches it.
// reads  splat candidates          writes  splat film
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/camera.glsl"
#include "lib/film.glsl"
#include "lib/layers.glsl"
#include "lib/queue.glsl"
#include "lib/scene_query.glsl"
#include "lib/strategies.glsl"

void main() {
  uint i = item_index();
  if (i >= queue_count(QUEUE_SPLATS)) return;
  Frame frame = FRAME;
  SplatCandidate splat = LOAD(SplatBuffer, frame.splats, i);
  bool is_seen = is_open(splat.segment, frame.splat_media, i);
  count_overrun();
  if (!is_seen) return;
  if (!is_valid_sample(splat.segment.contribution)) {
    count_events(COUNTER_NON_FINITE, 1u);
    return;
  }
  ivec2 corner = ivec2(frame.crop.xy), size = ivec2(frame.crop.zw);
  ivec2 first = max(ivec2(ceil(splat.film - frame.filter_radius - 0.5)), corner);
  ivec2 last = min(ivec2(floor(splat.film + frame.filter_radius - 0.5)), corner + size - 1);
  for (int y = first.y; y <= last.y; ++y)
    for (int x = first.x; x <= last.x; ++x) {
      vec2 offset = vec2(x, y) + 0.5 - splat.film;
      float density = filter_density(offset, frame.filter_radius, frame.filter_sigma);
      vec3 contribution = clamp_contribution(density * splat.segment.contribution, frame.largest_contribution);
      if (!(density > 0.0)) continue;
      uint index = uint((y - corner.y) * size.x + x - corner.x);
      film_add(frame.splat_film, index, contribution);
      if (has_layers())
        add_to_layers(frame, frame.layer_count, LOAD(WordBuffer, frame.splat_trails, i), index, contribution);
      if (has_strategies()) {
        StrategyCandidate strategy = LOAD(StrategyCandidateBuffer, frame.splat_strategies, i);
        add_to_strategy(frame, strategy.layer, index, contribution, density * strategy.unweighted);
      }
    }
}
