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
  float u_lobe;  // of the sample
  vec2 u;
  DeviceAddress energy_tables;  // in which nothing is lost: formulas stand against formulas
};
REGULUS_LAYOUT(StabilityBsdfCase, 272);

struct StabilityBsdfResult {
  float value, pdf_forward, pdf_reverse;  // at (wo, wi), green
  float raised, raised_forward;           // the same regularized
  vec3 sampled_wi;
  float weight;  // of the sample, green; negative: there is none
};
REGULUS_LAYOUT(StabilityBsdfResult, 36);

struct StabilitySpot {
  float inner_height, outer_height;  // 1 - cos of the half angles
  vec2 u;                            // of the ray that light tracing starts with
  vec3 receiver;                     // of next-event estimation
};
REGULUS_LAYOUT(StabilitySpot, 28);

// What light tracing starts with, and what reaches the receiver; the spot lies at the origin and shines along
// z with an intensity of 1.
struct StabilityEmission {
  vec3 direction;
  float throughput;   // intensity over pdf
  float inverse_pdf;  // solid-angle
  float irradiance;   // at the receiver, across the ray
};
REGULUS_LAYOUT(StabilityEmission, 24);

// A path x_0 ... x_K as weights see it. steps[i]: pdfs of vertex x_i (unused at x_0) and the edge from x_i to
// x_{i+1}.
REGULUS_CONSTANT STABILITY_MAX_EDGES = 64u;

struct StabilityStep {
  float forward;  // solid-angle pdf of going on from x_i to x_{i+1}
  float reverse;  // and of going back to x_{i-1}
  float distance;
  float cos_light_end;   // at x_i
  float cos_camera_end;  // at x_{i+1}
};
REGULUS_LAYOUT(StabilityStep, 20);

struct StabilityPath {
  uint edges;           // K, 2 .. STABILITY_MAX_EDGES
  float light_paths;    // N
  float merge;          // N pi r^2
  float connect_pdf;    // area pdf of x_0 by nee
  float point_pdf;      // and for emission
  float direction_pdf;  // solid-angle pdf of emitting towards x_1
  float camera_pdf;     // solid-angle pdf of the camera's ray to x_{K-1}
  StabilityStep steps[STABILITY_MAX_EDGES];
};
REGULUS_LAYOUT(StabilityPath, 1308);

// Of all techniques: hit at 0, nee, connections and splat at s = 1 .. K, merges at STABILITY_MAX_EDGES + j, j
// = 1 .. K - 1.
REGULUS_CONSTANT STABILITY_WEIGHTS = 2u * STABILITY_MAX_EDGES;

struct StabilityWeights {
  float weights[STABILITY_WEIGHTS];
};
REGULUS_LAYOUT(StabilityWeights, 512);

REGULUS_INTERFACE_END

#endif
