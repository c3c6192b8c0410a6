// What the batch kernels of the scattering model read and write; included by GLSL and C++.
#ifndef REGULUS_TESTS_BSDF_BATCH_H
#define REGULUS_TESTS_BSDF_BATCH_H

#include "interface/scene.h"
#include "interface/types.h"

REGULUS_INTERFACE_BEGIN

// One evaluation or one sample. Directions in the local frame of the shaders: z is the shading normal on the
// side of wo.
struct BsdfCase {
  Material material;
  vec2 alpha;     // replaces roughness^2 where alpha.x >= 0
  uint is_front;  // wo is on the front side
  uint mode;      // 0 radiance, 1 importance
  vec3 wo;
  vec3 wi;        // evaluation only
  float u_lobe;   // sampling only
  vec2 u;         // sampling only
  DeviceAddress sheen;   // table of sheen (interface/sheen.h); zero: without sheen
  DeviceAddress tables;  // covers of diffuse bases (interface/energy.h); zero: as under smooth interfaces
};
REGULUS_LAYOUT(BsdfCase, 280);

struct BsdfEvaluated {
  vec3 value;
  float pdf_forward, pdf_reverse;
};
REGULUS_LAYOUT(BsdfEvaluated, 20);

REGULUS_CONSTANT BSDF_SAMPLED_VALID = 1u;
REGULUS_CONSTANT BSDF_SAMPLED_DELTA = 2u;
REGULUS_CONSTANT BSDF_SAMPLED_TRANSMITTED = 4u;

struct BsdfSampled {
  vec3 wi;
  vec3 weight;
  float pdf_forward, pdf_reverse;
  uint flags;  // BSDF_SAMPLED_*
};
REGULUS_LAYOUT(BsdfSampled, 36);

// A direction and whether it counts.
struct DrawnDirection {
  vec3 direction;
  uint is_valid;
};
REGULUS_LAYOUT(DrawnDirection, 16);

// Functions of lib/sampling.glsl.
REGULUS_CONSTANT SAMPLING_DISK = 0u;
REGULUS_CONSTANT SAMPLING_COSINE_HEMISPHERE = 1u;
REGULUS_CONSTANT SAMPLING_SPHERE = 2u;
REGULUS_CONSTANT SAMPLING_CONE = 3u;
REGULUS_CONSTANT SAMPLING_TRIANGLE = 4u;
REGULUS_CONSTANT SAMPLING_CONE_HEIGHT_TENTHS = 3u;  // 1 - cos(angle), in tenths

REGULUS_INTERFACE_END

#endif
