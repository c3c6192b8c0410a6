// light_generate: starts the light paths of a wave.
// reads  lights          writes  paths, light heads (emptied), ray queue of bounce 0; splat candidates of emitters
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/emission.glsl"
#include "lib/light_walk.glsl"

void connect_emitter_to_lens(Frame frame, Emission emission, uint light_path, uint iteration, uint trail) {
  if (!connects_emitters() || stage.is_repeated != 0u) return;
  if (!(emission.area_pdf > 0.0)) return;
  vec4 u = random_block(frame.seed, light_path, iteration, DIMENSION_BLOCK_EMISSION_DIRECTION);
  LensSample lens = sample_lens(frame.camera, film_size(frame), emission.point.position, u.zw);
  float cos_light = dot(lens.wi, emission.point.normal);
  if (!lens.is_visible || is_off_film(frame, lens.film) || !(cos_light > 0.0 || emission.is_two_sided)) return;
  VisibilityCandidate segment;
  segment.origin = offset_origin(emission.point.position, emission.point.clearance, emission.point.normal, lens.wi);
  segment.direction = lens.wi;
  segment.t_max = lens.open_distance * SEGMENT_SCALE;
  segment.receiver = 0u;
  segment.contribution =
      emission.radiance * (lens.pdf * abs(cos_light) / (emission.area_pdf * float(frame.light_path_count)));
  PathMedia media = start_media(NO_MEDIA);
  if (has_contacts()) {
    // The segment starts at the lens, whose medium is known or found by start_media.
    segment.origin = emission.point.position + lens.open_distance * lens.wi;
    segment.direction = -lens.wi;
    segment.t_max = lens.open_distance - emission.point.clearance / abs(cos_light);
    if (frame.camera_media != MEDIA_VARY) media.around = LOAD(MediaSetBuffer, frame.media_sets, frame.camera_media);
    segment.contribution *= transmittance(frame, medium_of(frame, media.around), lens.open_distance) *
                            transmittance_before_plane(frame, lens.distance - lens.open_distance);
  }
  queue_splat(frame, segment, media, lens.film, 0u, trail, segment.contribution);
}

void main() {
  uint slot = item_index();
  if (slot >= stage.wave_paths) return;
  Frame frame = FRAME;
  uint pixels = frame.width * frame.height;
  // Waves of paired light paths run over (pixel, sample) like those of camera paths.
  uint period = frame.light_head_modulus == 0u ? pixels : frame.light_path_count;
  uint index = stage.first_pixel + slot;
  uint light_path = index % period, iteration = stage.first_sample + index / period;
  uint head = frame.light_head_modulus == 0u ? slot : light_path;
  if (has_state(STATE_VERTICES)) STORE(LightHeadBuffer, frame.light_heads, head, LightPathHead(INVALID_INDEX, 0u));

  vec4 u_light = random_block(frame.seed, light_path, iteration, DIMENSION_BLOCK_EMISSION);
  vec4 u_direction = random_block(frame.seed, light_path, iteration, DIMENSION_BLOCK_EMISSION_DIRECTION);
  Emission emission = sample_emission(frame, u_light, u_direction.xy);
  uint trail = 0u;
  if (has_layers()) {
    trail = group_trail(frame, select_emitter(frame, u_light.xy));
    STORE(WordBuffer, frame.path_trails, slot, trail);
  }
  connect_emitter_to_lens(frame, emission, light_path, iteration, trail);

  Path path;
  path.origin = emission.origin;
  path.direction = emission.direction;
  path.mis_a = emission.inverse_pdf;
  path.mis_b = (spec_techniques & TECHNIQUE_HIT) != 0u ? emission.hit_term : 0.0;
  path.number = emission.is_parallel ? light_path | PATH_PARALLEL : light_path;
  path.sample_index = iteration;
  path.throughput = emission.throughput;
  path.eta_scale = 1.0;
  path.bounce = 0u;
  path.medium = INVALID_INDEX;
  if (has_contacts()) {
    uint light = select_emitter(frame, u_light.xy);
    start_in_media(frame, LOAD(WordBuffer, frame.light_media, light), LOAD(LightBuffer, frame.lights, light).triangle,
                   sample_triangle(u_light.zw), slot, path);
  }
  if (!(max(path.throughput.r, max(path.throughput.g, path.throughput.b)) > 0.0)) return;
  STORE(PathBuffer, frame.paths, slot, path);
  if (has_histories())
    STORE(PathHistoryBuffer, frame.path_histories, slot, start_history(path.mis_a, path.mis_b, emission.bound));
  append_ray(0u, slot);
}
