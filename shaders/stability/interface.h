// What the kernels of `regulus bench stability` read and write, one item an invocation.
#ifndef REGULUS_STABILITY_INTERFACE_H
#define REGULUS_STABILITY_INTERFACE_H

#include "interface/scene.h"
#include "interface/types.h"

REGULUS_INTERFACE_BEGIN

REGULUS_CONSTANT STABILITY_GROUP_SIZE = 64u;

struct StabilityArguments {
  DeviceAddress inputs;
  DeviceAddress outputs;
  uint count;
};
REGULUS_LAYOUT(StabilityArguments, 20);

// Directions in the local frame of the shaders: z is the shading normal on the side of wo.
struct StabilityBsdfCase {
  Material material;
  vec2 alpha;     // of the microfacet lobe
  uint is_front;  // wo is on the front side
  float tau;      // bound of regularization, 1/sr
  vec3 wo;
  vec3 wi;
  float u_lobe;   // of the sample
  vec2 u;
};
REGULUS_LAYOUT(StabilityBsdfCase, 212);

struct StabilityBsdfResult {
  float value, pdf_forward, pdf_reverse;  // at (wo, wi), green
  float raised, raised_forward;           // the same regularized
  vec3 sampled_wi;
  float weight;                           // of the sample, green; negative: there is none
};
REGULUS_LAYOUT(StabilityBsdfResult, 36);

REGULUS_INTERFACE_END

#endif
