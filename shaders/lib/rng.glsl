// Counter-based random numbers: PCG4D (Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 2020).
// A block of four numbers is a pure function of (seed, pixel, sample, block), so any order of evaluation,
// wave size or sample range gives the same sequence.
#ifndef REGULUS_LIB_RNG_GLSL
#define REGULUS_LIB_RNG_GLSL

uvec4 pcg4d(uvec4 v) {
  v = v * 1664525u + 1013904223u;
  v.x += v.y * v.w;
  v.y += v.z * v.x;
  v.z += v.x * v.y;
  v.w += v.y * v.z;
  v ^= v >> 16u;
  v.x += v.y * v.w;
  v.y += v.z * v.x;
  v.z += v.x * v.y;
  v.w += v.y * v.z;
  return v;
}

// Uniform in [0, 1): the upper 24 bits, so every value is a float and 1 is never reached.
vec4 random_block(uint seed, uint pixel, uint sample_index, uint block) {
  return vec4(pcg4d(uvec4(pixel, sample_index, block, seed)) >> 8u) * (1.0 / 16777216.0);
}

#endif
