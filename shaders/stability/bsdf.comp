// bsdf: value, pdfs, regularized value and one sample of each case.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "stability/batch.glsl"
#include "lib/regularization.glsl"

REGULUS_BUFFER(CaseBuffer, StabilityBsdfCase);
REGULUS_BUFFER(ResultBuffer, StabilityBsdfResult);

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= batch.count) return;
  StabilityBsdfCase c = LOAD(CaseBuffer, batch.inputs, i);
  Bsdf bsdf = make_bsdf(c.material, c.is_front != 0u);
  bsdf.alpha = c.alpha;
  bsdf.energy = EnergyTables(c.energy_tables, ENERGY_PER_INDEX, 0.0, 0.0);
  ConnectionEval at = bsdf_connect(bsdf, c.wo, c.wi, TRANSPORT_RADIANCE, Regularization(c.tau, 1.0, c.tau, 1.0), uvec4(0u));
  BsdfSample drawn = bsdf_sample(bsdf, c.wo, c.u_lobe, c.u, TRANSPORT_RADIANCE);
  float weight = (drawn.flags & BSDF_SAMPLE_VALID) != 0u ? drawn.weight.g : -1.0;
  STORE(ResultBuffer, batch.outputs, i,
        StabilityBsdfResult(at.plain.value.g, at.plain.pdf_forward, at.plain.pdf_reverse, at.eval.value.g,
                            at.eval.pdf_forward, drawn.wi, weight));
}
