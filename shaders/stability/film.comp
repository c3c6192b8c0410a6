// film: adds all values to one sum of the film; what is no valid sample is counted in the word behind it.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "stability/batch.glsl"
#include "lib/film.glsl"

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= batch.count) return;
  float value = LOAD(FloatBuffer, batch.inputs, i);
  if (is_valid_sample(vec3(0.0, value, 0.0)))
    film_add_channel(batch.outputs, 0u, value);
  else
    ATOMIC_ADD(batch.outputs, 3u, 1u);
}
