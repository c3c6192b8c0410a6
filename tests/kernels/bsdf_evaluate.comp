// bsdf_evaluate: value and pdfs of each case.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "bsdf_batch.glsl"

REGULUS_BUFFER(EvaluatedBuffer, BsdfEvaluated);

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  BsdfCase c = LOAD(CaseBuffer, inputs, i);
  BsdfEval result = bsdf_evaluate(bsdf_of(c), c.wo, c.wi, c.mode == 0u ? TRANSPORT_RADIANCE : TRANSPORT_IMPORTANCE);
  STORE(EvaluatedBuffer, outputs, i, BsdfEvaluated(result.value, result.pdf_forward, result.pdf_reverse));
}
