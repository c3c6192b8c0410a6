// What every stage starts with: workgroup size, push constants, the frame, counters.
#ifndef REGULUS_LIB_STAGE_GLSL
#define REGULUS_LIB_STAGE_GLSL

#include "lib/buffers.glsl"
#include "lib/specialization.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;

layout(push_constant, scalar) uniform PushConstants { StageArguments stage; };

#define FRAME (FrameBuffer(stage.frame).items[0])

// Invocation index, also item index of the queue that was dispatched.
uint item_index() { return gl_GlobalInvocationID.x; }

// Adds to a 64-bit counter.
void count_events(uint counter, uint amount) {
  DeviceAddress counters = FRAME.counters;
  uint before = ATOMIC_ADD(counters, 2u * counter, amount);
  if (before + amount < before) ATOMIC_ADD(counters, 2u * counter + 1u, 1u);
}

#endif
