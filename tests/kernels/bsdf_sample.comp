// bsdf_sample: the sample of each case, with everything it returns.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "bsdf_batch.glsl"

REGULUS_BUFFER(SampledBuffer, BsdfSampled);

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  BsdfCase c = LOAD(CaseBuffer, inputs, i);
  uint mode = c.mode == 0u ? TRANSPORT_RADIANCE : TRANSPORT_IMPORTANCE;
  BsdfSample result = bsdf_sample(bsdf_of(c), c.wo, c.u_lobe, c.u, mode);
  uint flags = ((result.flags & BSDF_SAMPLE_VALID) != 0u ? BSDF_SAMPLED_VALID : 0u) |
               ((result.flags & BSDF_SAMPLE_DELTA) != 0u ? BSDF_SAMPLED_DELTA : 0u) |
               ((result.flags & BSDF_SAMPLE_TRANSMITTED) != 0u ? BSDF_SAMPLED_TRANSMITTED : 0u);
  STORE(SampledBuffer, outputs, i,
        BsdfSampled(result.wi, result.weight, result.pdf_forward, result.pdf_reverse, flags));
}
