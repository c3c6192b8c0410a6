// What the stages hand to each other in queues, and the queues themselves.
#ifndef REGULUS_INTERFACE_QUEUES_H
#define REGULUS_INTERFACE_QUEUES_H

#include "types.h"

REGULUS_INTERFACE_BEGIN

// Head of a queue: an indirect dispatch command followed by the number of items. Producers raise `groups_x`
// with every WORKGROUP_SIZE-th item, so the queue can be dispatched without a stage in between.
struct QueueHead {
  uint groups_x, groups_y, groups_z;
  uint count;
};
REGULUS_LAYOUT(QueueHead, 16);

REGULUS_CONSTANT WORKGROUP_SIZE = 64u;

// Queues of one bounce; head index = bounce * QUEUES_PER_BOUNCE + QUEUE_*.
REGULUS_CONSTANT QUEUE_RAYS = 0u;        // path slots to trace
REGULUS_CONSTANT QUEUE_VISIBILITY = 1u;  // candidates
REGULUS_CONSTANT QUEUE_BOUNCE = 2u;      // + material class: path slots that hit it
REGULUS_CONSTANT QUEUE_PAIRS = 5u;       // + the more general of the two vertices' classes: connection pairs
REGULUS_CONSTANT QUEUE_SPLATS = 8u;      // splat candidates
REGULUS_CONSTANT QUEUE_ESCAPED = 9u;     // path slots whose ray hit nothing
REGULUS_CONSTANT QUEUES_PER_BOUNCE = 10u;

// A contribution that counts if its segment is unoccluded.
struct VisibilityCandidate {
  vec3 origin;
  float t_max;
  vec3 direction;  // unit
  uint receiver;   // number of the sum that receives it: the radiance of a slot, or with connections a pixel of the film
  vec3 contribution;
};
REGULUS_LAYOUT(VisibilityCandidate, 44);

// A light vertex that the lens may see.
struct SplatCandidate {
  VisibilityCandidate segment;  // `receiver` is not used
  vec2 film;                    // pixels, see Camera
};
REGULUS_LAYOUT(SplatCandidate, 52);

// Beside a visibility or splat candidate: its strategy, and its contribution without the weight.
struct StrategyCandidate {
  vec3 unweighted;
  uint layer;  // of the strategy's images, or INVALID_INDEX
};
REGULUS_LAYOUT(StrategyCandidate, 16);

// A camera vertex and a light vertex to connect.
struct ConnectionPair {
  uint slot;    // of the camera path
  uint vertex;  // light vertex
};
REGULUS_LAYOUT(ConnectionPair, 8);

// Light vertices that one merge invocation looks at: an invocation may not loop longer than 65,535 times on
// stock lavapipe.
REGULUS_CONSTANT MERGE_ROUND_LENGTH = 32768u;
// Where the merges of a bounce are counted, this many light vertices to look at are one unit. Each camera vertex begins
// with a unit of its own.
REGULUS_CONSTANT MERGE_UNIT = 64u;

// Words of Frame.light_vertex_count.
REGULUS_CONSTANT LIGHT_COUNT_VERTICES = 0u;  // of the light paths at hand
REGULUS_CONSTANT LIGHT_COUNT_CROWD = 1u;     // light vertices in the fullest cell of the grid, if that cell is crowded
REGULUS_CONSTANT LIGHT_COUNT_UNITS = 2u;     // units of the bounce's merges, where they are counted
REGULUS_CONSTANT LIGHT_COUNT_WORDS = 3u;
// A cell with this many light vertices is crowded.
REGULUS_CONSTANT CROWDED_CELL = 16u;

REGULUS_INTERFACE_END

#endif
