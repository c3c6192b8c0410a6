// merge: a camera vertex of one material class gathers the light vertices within the merge radius.
// reads  bounce queue of spec_material_class, camera vertices, grid, light vertices          writes  film
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/film.glsl"
#include "lib/grid.glsl"
#include "lib/mis.glsl"
#include "lib/regularization.glsl"
#include "lib/shading.glsl"

// The grid entries of the cells near a point: ranges without duplicates (cells may share a hash).
struct Neighbourhood {
  uint first[8];
  uint count[8];
  uint ranges;
  uint total;
};

Neighbourhood neighbourhood(Frame frame, vec3 position) {
  ivec3 base = ivec3(floor(grid_position(frame, stage.merge_radius, position) - 0.5));
  Neighbourhood near;
  near.ranges = 0u;
  near.total = 0u;
  for (uint corner = 0u; corner < 8u; ++corner) {
    uint cell = grid_cell(frame, base + ivec3(corner & 1u, corner >> 1u & 1u, corner >> 2u));
    uint first = LOAD(WordBuffer, frame.grid_cells, cell);
    uint count = LOAD(WordBuffer, frame.grid_cells, cell + 1u) - first;
    bool is_new = count > 0u;
    for (uint i = 0u; i < near.ranges; ++i) is_new = is_new && near.first[i] != first;
    if (is_new) {
      near.first[near.ranges] = first;
      near.count[near.ranges] = count;
      near.ranges += 1u;
      near.total += count;
    }
  }
  return near;
}

// What one light vertex contributes at the camera vertex.
vec3 merge_contribution(ShadingPoint point, PathVertex camera, MisVertex camera_mis, PathVertex light, MisVertex light_mis,
                        TechniqueCounts counts, Regularization regularization) {
  vec3 wi = to_local(point, light.direction);
  if (!sides_agree(point, light.direction, wi)) return vec3(0.0);
  BsdfEval bsdf = bsdf_connect(point.bsdf, point.wo, wi, TRANSPORT_RADIANCE, regularization);
  float weight = mis_weight_merge(counts, light_mis, bsdf.pdf_forward, camera_mis, bsdf.pdf_reverse);
  float correction = shading_correction(point, light.direction, wi.z);
  return camera.throughput * bsdf.value * light.throughput * (correction * weight / counts.merge);
}

void main() {
  uint i = item_index();
  if (i >= queue_count(QUEUE_BOUNCE + spec_material_class)) return;
  Frame frame = FRAME;
  uint slot = LOAD(WordBuffer, frame.bounce_queues, spec_material_class * frame.wave_capacity + i);
  PathVertex camera = LOAD(PathVertexBuffer, frame.camera_vertices, slot);
  if (camera.edges == 0u) return;
  Neighbourhood near = neighbourhood(frame, camera.position);
  uint skipped = stage.round * MERGE_ROUND_LENGTH;
  if (near.total <= skipped) return;

  ShadingPoint point = shading_point(frame, camera.triangle, camera.barycentrics, camera.direction, TRANSPORT_RADIANCE);
  TechniqueCounts counts = technique_counts(frame, stage.merge_radius);
  MisVertex camera_mis = mis_camera_vertex(counts, camera.mis_a, camera.mis_b, camera.edges & PATH_VERTEX_EDGES);
  uint range = 0u, place = skipped;
  for (uint r = 0u; r < 8u && place >= near.count[range]; ++r) {
    place -= near.count[range];
    range += 1u;
  }
  Path path = LOAD(PathBuffer, frame.paths, slot);
  bool camera_diffused = (camera.edges & PATH_VERTEX_DIFFUSED) != 0u;
  uint camera_edges = camera.edges & PATH_VERTEX_EDGES;
  Regularization regularization = regularization_of(frame, path.sample_index, camera_diffused);
  FixedSum sum = FIXED_SUM_ZERO;
  bool is_valid = true;
  uint visits = min(near.total - skipped, MERGE_ROUND_LENGTH);
  for (uint visit = 0u; visit < visits; ++visit) {
    GridEntry entry = LOAD(GridEntryBuffer, frame.grid_entries, near.first[range] + place);
    place += 1u;
    if (place == near.count[range]) {
      place = 0u;
      range += 1u;
    }
    vec3 offset = entry.position - camera.position;
    if (dot(offset, offset) > square(stage.merge_radius)) continue;
    PathVertex light = LOAD(PathVertexBuffer, frame.light_vertices, entry.vertex);
    if (camera_edges + (light.edges & PATH_VERTEX_EDGES) > frame.max_depth) continue;
    MisVertex light_mis = light_vertex_mis(frame, counts, light, entry.vertex, camera_diffused);
    vec3 contribution = merge_contribution(point, camera, camera_mis, light, light_mis, counts, regularization);
    if (is_valid_sample(contribution))
      fixed_sum_add(sum, contribution);
    else
      is_valid = false;
  }
  if (!is_valid) count_events(COUNTER_NON_FINITE, 1u);
  film_add_sum(frame.film, path.pixel & PATH_PIXEL, sum);
}
