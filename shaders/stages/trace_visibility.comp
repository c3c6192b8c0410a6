// trace_visibility: adds the contribution of each candidate whose segment is free: to its path, or, where there are
// connections, of which a path has many at once, or layers, to its pixel.
// reads  candidates          writes  radiance or film
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/film.glsl"
#include "lib/layers.glsl"
#include "lib/queue.glsl"
#include "lib/scene_query.glsl"
#include "lib/strategies.glsl"

void main() {
  uint i = stage.first_item + item_index();
  if (i >= queue_count(QUEUE_VISIBILITY)) return;
  VisibilityCandidate candidate = LOAD(CandidateBuffer, FRAME.candidates, i);
  bool is_seen = is_open(candidate, FRAME.candidate_media, i);
  count_overrun();
  if (!is_seen) return;
  candidate.contribution = clamp_contribution(candidate.contribution, FRAME.largest_contribution);
  const bool is_of_path = (spec_techniques & TECHNIQUE_CONNECT) == 0u;
  uint pixel = candidate.receiver;
  if (is_of_path && (has_strategies() || has_layers()))
    pixel = film_index(FRAME, LOAD(PathBuffer, FRAME.paths, pixel).number & PATH_NUMBER);
  if (has_strategies()) {
    StrategyCandidate strategy = LOAD(StrategyCandidateBuffer, FRAME.candidate_strategies, i);
    add_to_strategy(FRAME, strategy.layer, pixel, candidate.contribution, strategy.unweighted);
  }
  if (has_layers()) {
    uint trail = LOAD(WordBuffer, FRAME.candidate_trails, i);
    if (!add_to_film(FRAME, trail, pixel, candidate.contribution)) count_events(COUNTER_NON_FINITE, 1u);
  } else if (is_of_path) {
    vec3 radiance = LOAD(Vec3Buffer, FRAME.radiance, candidate.receiver);
    STORE(Vec3Buffer, FRAME.radiance, candidate.receiver, radiance + candidate.contribution);
  } else if (is_valid_sample(candidate.contribution)) {
    film_add(FRAME.film, candidate.receiver, candidate.contribution);
  } else {
    count_events(COUNTER_NON_FINITE, 1u);
  }
}
