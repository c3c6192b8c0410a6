// escape: technique `hit` for camera rays that left the scene: they meet the environment.
// reads  escaped paths          writes  radiance
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/dispersion.glsl"
#include "lib/environment.glsl"
#include "lib/film.glsl"
#include "lib/history.glsl"
#include "lib/layers.glsl"
#include "lib/light.glsl"
#include "lib/queue.glsl"
#include "lib/strategies.glsl"

void main() {
  uint i = item_index();
  if (i >= queue_count(QUEUE_ESCAPED)) return;
  Frame frame = FRAME;
  uint slot = queued_escape(i);
  Path path = LOAD(PathBuffer, frame.paths, slot);
  EnvironmentSample environment = environment_at(frame, path.direction);
  // The accumulators are those of the ray itself, because its end has no distance and no cosine (docs/mathematics.md 1).
  float weight = 1.0;
  if (path.bounce > 0u) {
    float selection_pdf = frame.environment.selection_pdf;
    float pdf_connect =
        environment.pdf * previous_choice_probability(frame, slot, frame.environment.light, selection_pdf);
    float pdf_emit = environment.pdf * selection_pdf * INV_PI / square(frame.scene_radius);
    if (has_light_guide()) {
      vec2 numbers = environment_numbers(frame, path.direction);
      pdf_emit *= guided_share(frame, frame.environment.light, selection_pdf,
                               environment_start(frame, numbers, -path.direction, path.origin));
    }
    PathHistory history;
    if (has_histories()) {
      history = LOAD(PathHistoryBuffer, frame.path_histories, slot);
      history_arrive(frame, history, 0.0, 1.0, true);
    }
    weight = hit_weight(frame, path, history, technique_counts(frame, stage.merge_radius), pdf_connect, pdf_emit,
                        EMITTER_BOUND);
  }
  vec3 carried = path.throughput * response_of(frame, path.sample_index, has_dispersed(path));
  vec3 emitted = clamp_contribution(carried * environment.radiance * weight, frame.largest_contribution);
  if (has_layers()) {
    uint trail = LOAD(WordBuffer, frame.path_trails, slot) | group_trail(frame, frame.environment.light);
    if (!add_to_film(frame, trail, film_index(frame, path.number & PATH_NUMBER), emitted))
      count_events(COUNTER_NON_FINITE, 1u);
  } else {
    STORE(Vec3Buffer, frame.radiance, slot, LOAD(Vec3Buffer, frame.radiance, slot) + emitted);
  }
  if (has_strategies())
    add_to_strategy(frame, strategy_layer(frame, 0u, path.bounce + 2u, false), film_index(frame, path.number & PATH_NUMBER), emitted,
                    carried * environment.radiance);
}
