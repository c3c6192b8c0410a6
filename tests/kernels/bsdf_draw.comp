// bsdf_draw: many samples of each case, with independent random numbers, as chi-square tests need them; `parameter` per case.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "bsdf_batch.glsl"
#include "lib/rng.glsl"

REGULUS_BUFFER(DrawnBuffer, DrawnDirection);

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  BsdfCase c = LOAD(CaseBuffer, inputs, i / parameter);
  vec4 u = unit_interval(hash_bits(c.mode, i / parameter, i % parameter, 0u));
  BsdfSample result = bsdf_sample(bsdf_of(c), c.wo, u.x, u.yz, TRANSPORT_RADIANCE);
  STORE(DrawnBuffer, outputs, i, DrawnDirection(result.wi, result.flags & BSDF_SAMPLE_VALID));
}
