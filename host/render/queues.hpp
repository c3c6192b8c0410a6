// The queues of a bounce (shaders/interface/queues.h) as types.
#pragma once

#include <array>
#include <cstdint>

#include "interface/wavefront.h"

namespace regulus::render {

/// A queue. Queues of which each material class has its own are named by bounce_queue() and pair_queue().
enum class Queue : uint32_t {
  Rays = interface::QUEUE_RAYS,              ///< path slots to trace
  Visibility = interface::QUEUE_VISIBILITY,  ///< VisibilityCandidate
  Splats = interface::QUEUE_SPLATS,          ///< SplatCandidate
  Escaped = interface::QUEUE_ESCAPED,        ///< path slots whose ray met nothing
  None = interface::INVALID_INDEX,
};

/// Slots of paths that have met a surface of the class.
constexpr Queue bounce_queue(uint32_t material_class) {
  return Queue{interface::QUEUE_BOUNCE + material_class};
}

/// ConnectionPair, by the more general class of the two vertices.
constexpr Queue pair_queue(uint32_t material_class) {
  return Queue{interface::QUEUE_PAIRS + material_class};
}

/// The heads of all queues of a bounce, as they lie in WavefrontBuffers::queue_heads.
struct QueueHeads {
  std::array<interface::QueueHead, interface::QUEUES_PER_BOUNCE> heads;

  interface::QueueHead& operator[](Queue queue) {
    return heads[static_cast<uint32_t>(queue)];
  }
  const interface::QueueHead& operator[](Queue queue) const { return heads[static_cast<uint32_t>(queue)]; }

  /// Where the heads of a bounce begin, and the head of one queue, in bytes.
  static constexpr uint64_t offset_of(uint32_t bounce) { return bounce * sizeof(QueueHeads); }
  static constexpr uint64_t offset_of(uint32_t bounce, Queue queue) {
    return offset_of(bounce) + static_cast<uint32_t>(queue) * sizeof(interface::QueueHead);
  }
};

}  // namespace regulus::render
