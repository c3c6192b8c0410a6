// rng_bits: outputs[i] = the bits that `parameter` selects of inputs[i] = (seed, stream, sample, block); of the Sobol
// point alone, (index, unused...).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/buffers.glsl"
#include "lib/rng.glsl"
#include "rng_batch.h"

layout(local_size_x = 64) in;

REGULUS_BUFFER(BitsBuffer, uvec4);

layout(push_constant, scalar) uniform BatchArguments {
  uvec2 inputs;
  uvec2 outputs;
  uint count;
  uint parameter;
};

uvec4 bits_of(uvec4 v) {
  switch (parameter) {
    case RNG_POINT: return bitfieldReverse(sobol_reversed(v.x));
    case RNG_SOBOL: return sobol_bits(v.x, v.y, v.z, v.w);
    default: return hash_bits(v.x, v.y, v.z, v.w);
  }
}

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  STORE(BitsBuffer, outputs, i, bits_of(LOAD(BitsBuffer, inputs, i)));
}
