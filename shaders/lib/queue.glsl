// The queues of a bounce, each with the type of its items. Everything that stages hand to each other goes through here; no
// other code takes places in queues.
#ifndef REGULUS_LIB_QUEUE_GLSL
#define REGULUS_LIB_QUEUE_GLSL

#include "lib/stage.glsl"

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

// QUEUE_RAYS: the slots of paths to trace at `bounce`. Two lists take turns.
uint ray_queue_base(uint bounce) { return (bounce & 1u) * FRAME.wave_capacity; }

uint queued_ray(uint i) { return LOAD(WordBuffer, FRAME.ray_queues, ray_queue_base(stage.bounce) + i); }

void append_ray(uint bounce, uint slot) {
  uint index = queue_reserve(bounce * QUEUES_PER_BOUNCE + QUEUE_RAYS);
  STORE(WordBuffer, FRAME.ray_queues, ray_queue_base(bounce) + index, slot);
}

// QUEUE_BOUNCE: the slots of paths that have met a surface of a material class.
uint queued_arrival(uint i) {
  return LOAD(WordBuffer, FRAME.bounce_queues, spec_material_class * FRAME.wave_capacity + i);
}

void append_arrival(uint material_class, uint slot) {
  uint index = queue_reserve(queue_head(QUEUE_BOUNCE + material_class));
  STORE(WordBuffer, FRAME.bounce_queues, material_class * FRAME.wave_capacity + index, slot);
}

// QUEUE_ESCAPED: the slots of paths that have met nothing.
uint queued_escape(uint i) { return LOAD(WordBuffer, FRAME.escaped, i); }

void append_escape(uint slot) {
  uint index = queue_reserve(queue_head(QUEUE_ESCAPED));
  STORE(WordBuffer, FRAME.escaped, index, slot);
}

// QUEUE_PAIRS: by the more general of the two vertices' classes.
ConnectionPair queued_pair(uint i) {
  return LOAD(ConnectionPairBuffer, FRAME.pairs, spec_material_class * FRAME.pair_capacity + i);
}

void append_connection(uint material_class, ConnectionPair pair) {
  uint place = queue_reserve(queue_head(QUEUE_PAIRS + material_class));
  STORE(ConnectionPairBuffer, FRAME.pairs, material_class * FRAME.pair_capacity + place, pair);
}

// QUEUE_VISIBILITY. Returns the candidate's place, at which other arrays hold more about it.
uint append_candidate(VisibilityCandidate candidate) {
  uint index = queue_reserve(queue_head(QUEUE_VISIBILITY));
  STORE(CandidateBuffer, FRAME.candidates, index, candidate);
  return index;
}

// QUEUE_SPLATS, likewise.
uint append_splat(SplatCandidate splat) {
  uint index = queue_reserve(queue_head(QUEUE_SPLATS));
  STORE(SplatBuffer, FRAME.splats, index, splat);
  return index;
}

#endif
