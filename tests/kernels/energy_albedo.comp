// energy_albedo: one of `parameter` samples of what a surface, compensated or with a covered base, sends towards a
// direction in light of radiance 1 from everywhere; case by case. The host takes the mean: in a loop around the whole
// BSDF SwiftShader's compiler spends minutes.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/bsdf.glsl"
#include "lib/buffers.glsl"
#include "energy_case.h"

layout(local_size_x = 64) in;

REGULUS_BUFFER(EnergyCaseBuffer, EnergyCase);

layout(push_constant, scalar) uniform BatchArguments {
  uvec2 inputs;
  uvec2 outputs;
  uint count;
  uint parameter;
};

void main() {
  uint index = gl_GlobalInvocationID.x;
  if (index >= count) return;
  EnergyCase c = LOAD(EnergyCaseBuffer, inputs, index / parameter);
  Bsdf bsdf = make_bsdf(c.material, c.is_front != 0u);
  find_tables(c.tables, c.material, bsdf);
  if (compensates_energy()) compensate_energy(c.material, bsdf);
  if (has_rough_base()) cover_base(c.material, bsdf);
  vec3 wo = vec3(safe_sqrt((1.0 - c.cosine) * (1.0 + c.cosine)), 0.0, c.cosine);
  // R3 sequence (Roberts 2018).
  uint i = index % parameter;
  vec3 u = vec3(((i + 1u) * uvec3(3518319155u, 2882110345u, 2360945575u)) >> 8u) * (1.0 / 16777216.0);
  BsdfSample event = bsdf_sample(bsdf, wo, u.z, u.xy, TRANSPORT_RADIANCE);
  // Radiance is that of the same light on the other side of an interface.
  STORE(Vec3Buffer, outputs, index, event.weight * event.eta_scale);
}
