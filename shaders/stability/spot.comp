// spot: the start of a light path at each spot light, and its light by next-event estimation.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "stability/batch.glsl"
#include "lib/emission.glsl"

REGULUS_BUFFER(SpotBuffer, StabilitySpot);
REGULUS_BUFFER(EmissionBuffer, StabilityEmission);

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= batch.count) return;
  StabilitySpot spot = LOAD(SpotBuffer, batch.inputs, i);
  Light light;
  light.kind = LIGHT_SPOT;
  light.position = vec3(0.0);
  light.direction = vec3(0.0, 0.0, 1.0);
  light.intensity = vec3(1.0);
  light.selection_pdf = 1.0;
  light.area = 0.0;
  light.inner_height = spot.inner_height;
  light.outer_height = spot.outer_height;
  Frame unused;
  Emission emission = emit_from_punctual(unused, light, vec2(0.5), spot.u);
  LightSample received = sample_punctual_light(unused, light, spot.receiver);
  STORE(EmissionBuffer, batch.outputs, i,
        StabilityEmission(emission.direction, emission.throughput.g, emission.inverse_pdf, received.radiance.g));
}
