// Arguments that the kernels of stability share.
#ifndef REGULUS_STABILITY_BATCH_GLSL
#define REGULUS_STABILITY_BATCH_GLSL

#include "lib/buffers.glsl"
#include "stability/interface.h"

layout(local_size_x = STABILITY_GROUP_SIZE) in;

layout(push_constant, scalar) uniform PushConstants { StabilityArguments batch; };

#endif
