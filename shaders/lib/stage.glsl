// What every stage starts with: workgroup size, push constants, the frame, and the queues.
#ifndef REGULUS_LIB_STAGE_GLSL
#define REGULUS_LIB_STAGE_GLSL

#include "lib/buffers.glsl"
#include "lib/specialization.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;

layout(push_constant, scalar) uniform PushConstants { StageArguments stage; };

#define FRAME (FrameBuffer(stage.frame).items[0])

// Invocation index, also item index of the queue that was dispatched.
uint item_index() { return gl_GlobalInvocationID.x; }

uint queue_head(uint queue) { return stage.bounce * QUEUES_PER_BOUNCE + queue; }

// Number of items in a queue of the current bounce.
uint queue_count(uint queue) { return LOAD(QueueHeadBuffer, FRAME.queue_heads, queue_head(queue)).count; }

// Reserves one item of the queue with the given head and returns its index. Raises the group count of the
// head's dispatch command with the first item of each workgroup.
uint queue_reserve(uint head) {
  DeviceAddress heads = FRAME.queue_heads;
  uint index = atomicAdd(QueueHeadBuffer(heads).items[head].count, 1u);
  if (index % WORKGROUP_SIZE == 0u) atomicAdd(QueueHeadBuffer(heads).items[head].groups_x, 1u);
  return index;
}

// The list of path slots to trace at `bounce`: two lists take turns.
uint ray_queue_base(uint bounce) { return (bounce & 1u) * FRAME.wave_capacity; }

void append_ray(uint bounce, uint slot) {
  uint index = queue_reserve(bounce * QUEUES_PER_BOUNCE + QUEUE_RAYS);
  STORE(WordBuffer, FRAME.ray_queues, ray_queue_base(bounce) + index, slot);
}

// Adds to a 64-bit counter.
void count_events(uint counter, uint amount) {
  DeviceAddress counters = FRAME.counters;
  uint before = ATOMIC_ADD(counters, 2u * counter, amount);
  if (before + amount < before) ATOMIC_ADD(counters, 2u * counter + 1u, 1u);
}

#endif
