// merge: a camera vertex of one material class gathers the light vertices within the merge radius.
// reads  bounce queue of spec_material_class, camera vertices, grid, light vertices          writes  film
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/coverage.glsl"
#include "lib/film.glsl"
#include "lib/grid.glsl"
#include "lib/layers.glsl"
#include "lib/measure.glsl"
#include "lib/queue.glsl"
#include "lib/shading.glsl"

// Surfaces with less coverage are hardly ever met: this bound loses a share of light of its own size.
const float MIN_COVERAGE = 1e-3;

// A camera vertex that gathers.
struct Gatherer {
  ShadingPoint point;
  CameraVertex vertex;
  MisVertex mis;
  PathHistory history;
  uint edges;
  uint pixel;
  uint iteration;
  bool is_diffused;  // is_diffused of light_vertex_mis; the vertex scatters as the camera's surface does
  Regularization regularization;
  TechniqueCounts counts;
};

// The bsdf of a merge with light vertex `light`, number `index`, and its product with the weight.
Weighted weighted_value(Frame frame, Gatherer gatherer, LightVertex light, uint index, vec3 wi) {
  TechniqueCounts counts = gatherer.counts;
  uvec3 place = uvec3(gatherer.edges, light.edges & PATH_VERTEX_EDGES,
                      light.edges >> LIGHT_VERTEX_STREAM_SHIFT & LIGHT_VERTEX_STREAM_MASK);
  uvec4 seed = virtual_merge_seed(frame.seed, gatherer.pixel, gatherer.iteration, VIRTUAL_MERGE_AT_MERGE, place);
  ConnectionEval bsdf =
      bsdf_connect(gatherer.point.bsdf, gatherer.point.wo, wi, TRANSPORT_RADIANCE, gatherer.regularization, seed);
  uint light_edges = light.edges & PATH_VERTEX_EDGES;
  PathHistory light_history;
  if (has_histories()) light_history = LOAD(PathHistoryBuffer, frame.light_vertex_histories, index);
  SubpathEnd light_subpath = light_end(light_vertex_mis(frame, counts, light, index, gatherer.is_diffused), light_history,
                                       light_edges, gatherer.is_diffused);
  return measure_merge(frame, counts, camera_end(gatherer.mis, gatherer.history, gatherer.edges), light_subpath, bsdf,
                       gatherer.regularization);
}

// The range [x, y) of the `total` light vertices in reach that this dispatch looks at, MERGE_ROUND_LENGTH at most.
uvec2 visits_of(Frame frame, uint slot, uint total) {
  if (stage.merge_units == 0u) return uvec2(0u, min(total, MERGE_ROUND_LENGTH));
  uint start = LOAD(WordBuffer, frame.merge_starts, slot);
  uint first = max(start, stage.merge_first);
  uint last = min(start + merge_units(total), stage.merge_first + stage.merge_units);
  if (first >= last) return uvec2(0u);
  uint begin = (first - start) * MERGE_UNIT + stage.merge_turn * MERGE_ROUND_LENGTH;
  uint end = min((last - start) * MERGE_UNIT, total);
  return uvec2(begin, min(end, begin + MERGE_ROUND_LENGTH));
}

// What one light vertex contributes at the camera vertex.
Weighted merge_contribution(Frame frame, Gatherer gatherer, LightVertex light, uint index) {
  vec3 wi;
  if (!to_local_lit(gatherer.point, light.direction, wi) || is_beyond_horizon(gatherer.point, light.direction))
    return Weighted(vec3(0.0), vec3(0.0));
  look_towards(frame, light.direction, gatherer.point);
  float correction = shading_correction(gatherer.point, light.direction, wi.z);
  bool is_dispersed = ((gatherer.vertex.edges | light.edges) & PATH_VERTEX_DISPERSED) != 0u || gatherer.point.is_dispersive;
  vec3 factor = gatherer.vertex.throughput * light.throughput * response_of(frame, gatherer.iteration, is_dispersed) *
                (correction / gatherer.counts.merge);
  Weighted bsdf = weighted_value(frame, gatherer, light, index, wi);
  return Weighted(factor * bsdf.value, factor * bsdf.unweighted);
}

void main() {
  uint i = item_index();
  if (i >= queue_count(QUEUE_BOUNCE + spec_material_class)) return;
  Frame frame = FRAME;
  uint slot = queued_arrival(i);
  CameraVertex camera = LOAD(CameraVertexBuffer, frame.camera_vertices, slot);
  if (camera.edges == 0u) return;
  Neighbourhood near = neighbourhood(frame, stage.merge_radius, camera.position);
  uvec2 visits = visits_of(frame, slot, near.total);
  if (visits.x >= visits.y) return;

  Path path = LOAD(PathBuffer, frame.paths, slot);
  Gatherer gatherer;
  MediaSet media = NO_MEDIA;
  if (has_contacts()) media = LOAD(MediaSetBuffer, frame.camera_vertex_media, slot);
  gatherer.point = shading_point(frame, camera.triangle, camera.barycentrics, camera.direction, TRANSPORT_RADIANCE, media,
                                 bend_of(frame, path.sample_index));
  gatherer.vertex = camera;
  // Each subpath met the surface with the probability of its coverage, but the path has that factor once.
  Triangle triangle = placed_triangle(frame, camera.triangle).triangle;
  gatherer.vertex.throughput /= max(coverage_at(frame, triangle, camera.barycentrics), MIN_COVERAGE);
  gatherer.edges = camera.edges & PATH_VERTEX_EDGES;
  gatherer.pixel = path.number & PATH_NUMBER;
  gatherer.iteration = path.sample_index;
  bool is_diffused = (camera.edges & PATH_VERTEX_DIFFUSED) != 0u;
  gatherer.is_diffused = !has_diffusion() || is_diffused || diffuses(gatherer.point.bsdf);
  gatherer.regularization = regularization_of(frame, path.sample_index, is_diffused);
  gatherer.counts = technique_counts(frame, stage.merge_radius);
  gatherer.mis = mis_camera_vertex(gatherer.counts, camera.mis_a, camera.mis_b, gatherer.edges);
  if (has_histories()) gatherer.history = LOAD(PathHistoryBuffer, frame.camera_vertex_histories, slot);
  uint range = 0u, place = visits.x;
  for (uint r = 0u; r < 8u && place >= near.count[range]; ++r) {
    place -= near.count[range];
    range += 1u;
  }
  uint pixel = film_index(frame, path.number & PATH_NUMBER), trail = 0u;
  if (has_layers())
    trail = LOAD(WordBuffer, frame.camera_vertex_trails, slot) | vertex_trail(gatherer.point.bsdf, gatherer.edges == 1u);
  FixedSum sum = FIXED_SUM_ZERO;
  bool is_valid = true;
  for (uint visit = visits.x; visit < visits.y; ++visit) {
    GridEntry entry = LOAD(GridEntryBuffer, frame.grid_entries, near.first[range] + place);
    place += 1u;
    if (place == near.count[range]) {
      place = 0u;
      range += 1u;
    }
    vec3 offset = entry.position - camera.position;
    if (dot(offset, offset) > square(stage.merge_radius)) continue;
    LightVertex light = LOAD(LightVertexBuffer, frame.light_vertices, entry.vertex);
    if (gatherer.edges + (light.edges & PATH_VERTEX_EDGES) > frame.max_depth) continue;
    Weighted contribution = merge_contribution(frame, gatherer, light, entry.vertex);
    contribution.value = clamp_contribution(contribution.value, frame.largest_contribution);
    if (has_layers()) {
      uint whole_trail = trail | LOAD(WordBuffer, frame.light_vertex_trails, entry.vertex);
      is_valid = add_to_film(frame, whole_trail, pixel, contribution.value) && is_valid;
    } else if (is_valid_sample(contribution.value)) {
      fixed_sum_add(sum, contribution.value);
    } else {
      is_valid = false;
    }
    if (has_strategies())
      add_to_strategy(frame, strategy_layer(frame, (light.edges & PATH_VERTEX_EDGES) + 1u, gatherer.edges + 1u, true),
                      pixel, contribution.value, contribution.unweighted);
  }
  if (!is_valid) count_events(COUNTER_NON_FINITE, 1u);
  if (!has_layers()) film_add_sum(frame.film, pixel, sum);
}
