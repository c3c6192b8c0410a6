// camera_bounce: a path at the surface of one material class: emission, a light connection, the next ray.
// reads  bounce queue of spec_material_class, paths, hits
// writes radiance, candidates, paths, ray queue of the next bounce
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/shading.glsl"

void main() {
  uint i = item_index();
  if (i >= queue_count(QUEUE_BOUNCE + spec_material_class)) return;
  Frame frame = FRAME;
  uint slot = LOAD(WordBuffer, frame.bounce_queues, spec_material_class * frame.wave_capacity + i);
  Path path = LOAD(PathBuffer, frame.paths, slot);
  Hit hit = LOAD(HitBuffer, frame.hits, slot);

  ShadingPoint point = shading_point(frame, hit, -path.direction);
  path.throughput *= transmittance(frame, path.medium, hit.t);
  vec3 emitted = path.throughput * emission_towards(frame, point, path, hit.t);
  if (any(greaterThan(emitted, vec3(0.0))))
    STORE(Vec3Buffer, frame.radiance, slot, LOAD(Vec3Buffer, frame.radiance, slot) + emitted);

  // An edge to a light or to the next vertex would be edge bounce + 2 of the path.
  if (path.bounce + 2u > frame.max_depth || point.wo.z <= 0.0) return;
  uint block = DIMENSION_BLOCKS_FIRST + path.bounce * DIMENSION_BLOCKS_PER_BOUNCE;
  vec4 light_u = random_block(frame.seed, path.pixel, path.sample_index, block + DIMENSION_BLOCK_LIGHT);
  vec4 bsdf_u = random_block(frame.seed, path.pixel, path.sample_index, block + DIMENSION_BLOCK_BSDF);
  connect_to_light(frame, point, path, slot, light_u);
  scatter(frame, point, path, slot, bsdf_u);
}
