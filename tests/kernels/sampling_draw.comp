// sampling_draw: maps the random pair of each input by the sampling function `parameter` selects; results as
// directions or, for points in the plane, as (x, y, 0).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/buffers.glsl"
#include "lib/sampling.glsl"
#include "bsdf_batch.h"

layout(local_size_x = 64) in;

REGULUS_BUFFER(PairBuffer, vec2);
REGULUS_BUFFER(DrawnBuffer, DrawnDirection);

layout(push_constant, scalar) uniform BatchArguments {
  uvec2 inputs;
  uvec2 outputs;
  uint count;
  uint parameter;
};

vec3 draw(vec2 u) {
  switch (parameter) {
    case SAMPLING_DISK: return vec3(sample_disk(u), 0.0);
    case SAMPLING_COSINE_HEMISPHERE: return sample_cosine_hemisphere(u);
    case SAMPLING_SPHERE: return sample_sphere(u);
    case SAMPLING_CONE: return sample_cone(u, SAMPLING_CONE_HEIGHT_TENTHS * 0.1);
    default: return vec3(sample_triangle(u), 0.0);
  }
}

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  STORE(DrawnBuffer, outputs, i, DrawnDirection(draw(LOAD(PairBuffer, inputs, i)), 1u));
}
