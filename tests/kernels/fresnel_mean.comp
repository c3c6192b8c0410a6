// fresnel_mean: outputs[i] = fresnel_mean_position(inputs[i]).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/buffers.glsl"
#include "lib/fresnel.glsl"

layout(local_size_x = 64) in;

REGULUS_BUFFER(PositionBuffer, float);

layout(push_constant, scalar) uniform BatchArguments {
  uvec2 inputs;
  uvec2 outputs;
  uint count;
  uint parameter;
};

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  STORE(PositionBuffer, outputs, i, fresnel_mean_position(LOAD(PositionBuffer, inputs, i)));
}
