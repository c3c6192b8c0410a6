// basis: outputs[i] = the tangents that orthonormal_basis gives for the normal inputs[i].
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/buffers.glsl"
#include "lib/sampling.glsl"

layout(local_size_x = 64) in;

struct Tangents {
  vec3 tangent, bitangent;
};
REGULUS_BUFFER(NormalBuffer, vec3);
REGULUS_BUFFER(TangentBuffer, Tangents);

layout(push_constant, scalar) uniform BatchArguments {
  uvec2 inputs;
  uvec2 outputs;
  uint count;
  uint parameter;
};

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  Tangents tangents;
  orthonormal_basis(LOAD(NormalBuffer, inputs, i), tangents.tangent, tangents.bitangent);
  STORE(TangentBuffer, outputs, i, tangents);
}
