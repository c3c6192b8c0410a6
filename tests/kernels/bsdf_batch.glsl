// Common part of the batch kernels of the scattering model: arguments and the material of a case.
#ifndef REGULUS_TESTS_BSDF_BATCH_GLSL
#define REGULUS_TESTS_BSDF_BATCH_GLSL

#include "lib/buffers.glsl"
#include "lib/bsdf.glsl"
#include "bsdf_batch.h"

layout(local_size_x = 64) in;

REGULUS_BUFFER(CaseBuffer, BsdfCase);

layout(push_constant, scalar) uniform BatchArguments {
  uvec2 inputs;
  uvec2 outputs;
  uint count;
  uint parameter;
};

Bsdf bsdf_of(BsdfCase c) {
  Bsdf bsdf = make_bsdf(c.material, c.is_front != 0u);
  if (c.alpha.x >= 0.0) bsdf.alpha = c.alpha;
  if (c.sheen != uvec2(0u)) add_sheen(c.sheen, c.material, c.is_front != 0u, bsdf);
  if (c.tables != uvec2(0u)) {
    find_tables(c.tables, c.material, bsdf);
    cover_base(c.material, bsdf);
  }
  return bsdf;
}

#endif
