// What the ray query kernels share: arguments and buffers.
#ifndef REGULUS_BENCH_GLSL
#define REGULUS_BENCH_GLSL

#include "bench/bench_interface.h"
#define TRAVERSAL_OF_A_BARE_TREE
#include "lib/traversal.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;

layout(push_constant, scalar) uniform PushConstants { BenchArguments bench; };

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer BenchRays { BenchRay rays[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer BenchHits { Hit hits[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer BenchWords { uint words[]; };

#endif
