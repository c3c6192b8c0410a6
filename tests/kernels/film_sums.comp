// film_sums: of two sums in words, inputs[6 i ..], their sum, their difference, and what a film's channel holds after both,
// in outputs[9 i ..].
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

uvec3 words_at(uint first) {
  return uvec3(LOAD(WordBuffer, inputs, first), LOAD(WordBuffer, inputs, first + 1u), LOAD(WordBuffer, inputs, first + 2u));
}

void store_words(uint first, uvec3 words) {
  for (uint k = 0u; k < 3u; ++k) STORE(WordBuffer, outputs, first + k, words[k]);
}

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  uvec3 a = words_at(6u * i), b = words_at(6u * i + 3u);
  store_words(9u * i, fixed_add(a, b));
  store_words(9u * i + 3u, fixed_subtract(a, b));
  film_add_words(outputs, 9u * i + 6u, a);
  film_add_words(outputs, 9u * i + 6u, b);
}
