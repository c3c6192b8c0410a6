// film_filter: outputs[i] = sample_filter(u, radius, sigma) for inputs[i] = (u, radius, sigma).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/camera.glsl"

layout(local_size_x = 64) in;

REGULUS_BUFFER(FilterInputBuffer, vec4);
REGULUS_BUFFER(OffsetBuffer, vec2);

layout(push_constant, scalar) uniform BatchArguments {
  uvec2 inputs;
  uvec2 outputs;
  uint count;
  uint parameter;
};

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  vec4 u = LOAD(FilterInputBuffer, inputs, i);
  STORE(OffsetBuffer, outputs, i, sample_filter(u.xy, u.z, u.w));
}
