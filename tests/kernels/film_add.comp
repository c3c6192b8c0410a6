// film_add: adds inputs[i] to channel `i % parameter` of the film whose first word is outputs[0].
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/film.glsl"

layout(local_size_x = 64) in;


layout(push_constant, scalar) uniform BatchArguments {
  uvec2 inputs;
  uvec2 outputs;
  uint count;
  uint parameter;
};

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  film_add_channel(outputs, 3u * (i % parameter), LOAD(FloatBuffer, inputs, i));
}
