// count_work: adds the lengths of all queues of the wave to the counters. One workgroup.
// reads  queue heads          writes  counters
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/queue.glsl"

void main() {
  uint heads = FRAME.max_depth * QUEUES_PER_BOUNCE;
  for (uint head = item_index(); head < heads; head += WORKGROUP_SIZE) {
    uint count = LOAD(QueueHeadBuffer, FRAME.queue_heads, head).count;
    if (count != 0u) count_events(COUNTER_QUEUE_ITEMS + stage.counted_pass * QUEUES_PER_BOUNCE + head % QUEUES_PER_BOUNCE, count);
  }
}
