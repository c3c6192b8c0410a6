// footprint: outputs[i] = the footprint of inputs[i] after its distance and its event.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/footprint.glsl"

layout(local_size_x = 64) in;

struct Encounters {
  vec3 footprint;
  float distance;
  float curvature;
  float e;  // refraction: eta_i / eta_t; 0: reflection
};
REGULUS_BUFFER(EncountersBuffer, Encounters);

layout(push_constant, scalar) uniform BatchArguments {
  uvec2 inputs;
  uvec2 outputs;
  uint count;
  uint parameter;
};

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  Encounters input_i = LOAD(EncountersBuffer, inputs, i);
  vec3 footprint = travelled(input_i.footprint, input_i.distance);
  footprint = input_i.e > 0.0 ? refracted(footprint, input_i.e, input_i.curvature)
                              : reflected(footprint, input_i.curvature);
  STORE(Vec3Buffer, outputs, i, footprint);
}
