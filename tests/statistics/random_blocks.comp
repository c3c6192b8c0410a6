// random_blocks: outputs[i] = random_block of the counter inputs[i] = (seed, pixel, sample, block).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/buffers.glsl"
#include "lib/rng.glsl"

layout(local_size_x = 64) in;

REGULUS_BUFFER(CounterBuffer, uvec4);
REGULUS_BUFFER(BlockBuffer, vec4);

layout(push_constant, scalar) uniform BatchArguments {
  uvec2 inputs;
  uvec2 outputs;
  uint count;
  uint parameter;
};

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  uvec4 counter = LOAD(CounterBuffer, inputs, i);
  STORE(BlockBuffer, outputs, i, random_block(counter.x, counter.y, counter.z, counter.w));
}
