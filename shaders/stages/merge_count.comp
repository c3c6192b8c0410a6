// merge_count: numbers the light vertices that the camera vertices of one material class have in reach, so that merges
// can be cut into dispatches of known size. (The numbers depend on timing; the sums of merges do not, see film.glsl.)
// reads  bounce queue of spec_material_class, camera vertices, grid          writes  merge starts, number of units
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/grid.glsl"
#include "lib/queue.glsl"

void main() {
  uint i = item_index();
  if (i >= queue_count(QUEUE_BOUNCE + spec_material_class)) return;
  Frame frame = FRAME;
  uint slot = queued_arrival(i);
  CameraVertex camera = LOAD(CameraVertexBuffer, frame.camera_vertices, slot);
  if (camera.edges == 0u) return;
  uint units = merge_units(neighbourhood(frame, stage.merge_radius, camera.position).total);
  STORE(WordBuffer, frame.merge_starts, slot, ATOMIC_ADD(frame.light_vertex_count, LIGHT_COUNT_UNITS, units));
}
