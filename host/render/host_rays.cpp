#include "render/host_rays.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>

namespace regulus::render {

using namespace interface;

namespace {

constexpr uint32_t RAYS_AT_ONCE = 512;  // of a thread
constexpr float ENDLESS = 3.4e38F;

template <typename T>
T* contents(const gpu::Buffer& buffer) {
  return reinterpret_cast<T*>(buffer.host());
}

// Path slots on their way into a queue. (Nothing is allocated: threads that share a loop must not throw.)
class Slots {
 public:
  void add(uint32_t slot) { slots_[count_++] = slot; }
  void append_to(QueueHead& head, uint32_t* queue) const {
    if (count_ == 0) return;
    const uint32_t first = std::atomic_ref(head.count).fetch_add(count_);
    std::copy_n(slots_.begin(), count_, queue + first);
  }

 private:
  std::array<uint32_t, RAYS_AT_ONCE> slots_;
  uint32_t count_ = 0;
};

void set_groups(QueueHead& head) {
  head.groups_x = (head.count + WORKGROUP_SIZE - 1) / WORKGROUP_SIZE;
}

VisibilityCandidate& segment_of(VisibilityCandidate& candidate) {
  return candidate;
}
VisibilityCandidate& segment_of(SplatCandidate& candidate) {
  return candidate.segment;
}

}  // namespace

HostRays::HostRays(const PreparedScene& prepared, const Plan& plan, const WavefrontBuffers& buffers,
                   RenderStatistics& statistics)
    : query_(prepared),
      buffers_(buffers),
      statistics_(statistics),
      has_escapes_(plan.keeps(STATE_ESCAPES)),
      capacity_(buffers.frame().wave_capacity) {}

bool HostRays::traces(const StageStep& step) {
  return step.stage == Stage::TraceClosest || step.stage == Stage::TraceVisibility ||
         step.stage == Stage::TraceSplats;
}

bool HostRays::needs_kernel(const StageStep& step) {
  return step.stage != Stage::TraceClosest;
}

void HostRays::trace(const StageStep& step, uint32_t bounce) {
  const auto begin = std::chrono::steady_clock::now();
  const uint32_t count = heads_of(bounce)[step.queue].count;
  if (step.queue == Queue::Rays)
    trace_closest(step.pass, bounce);
  else if (step.queue == Queue::Visibility)
    trace_segments<VisibilityCandidate>(buffers_.candidates, count);
  else
    trace_segments<SplatCandidate>(buffers_.splats, count);
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - begin;
  StageStatistics& stage = statistics_.stages[step.name];
  stage.host_ms += took.count();
  if (!needs_kernel(step)) ++stage.dispatches;
}

QueueHeads& HostRays::heads_of(uint32_t bounce) const {
  return contents<QueueHeads>(buffers_.queue_heads)[bounce];
}

// Does what shaders/stages/trace_closest.comp does.
void HostRays::trace_closest(Pass pass, uint32_t bounce) {
  QueueHeads& heads = heads_of(bounce);
  const uint32_t* queue = contents<uint32_t>(buffers_.ray_queues) + uint64_t{bounce & 1} * capacity_;
  const Path* paths = contents<Path>(buffers_.paths);
  Hit* hits = contents<Hit>(buffers_.hits);
  const bool has_escapes = has_escapes_ && pass == Pass::Camera;
  workers_.run(heads[Queue::Rays].count, RAYS_AT_ONCE, [&](uint32_t begin, uint32_t end) {
    std::array<Slots, MATERIAL_CLASS_COUNT> met;
    Slots escaped;
    for (uint32_t i = begin; i < end; ++i) {
      const uint32_t slot = queue[i];
      uint32_t tag = 0;
      const Hit hit = query_.closest(paths[slot].origin, paths[slot].direction, ENDLESS, tag);
      if (hit.triangle == INVALID_INDEX) {
        escaped.add(slot);
        continue;
      }
      hits[slot] = hit;
      met[tag & 0xFF].add(slot);
    }
    for (uint32_t c = 0; c < MATERIAL_CLASS_COUNT; ++c)
      met[c].append_to(heads[bounce_queue(c)],
                       contents<uint32_t>(buffers_.bounce_queues) + uint64_t{c} * capacity_);
    if (has_escapes) escaped.append_to(heads[Queue::Escaped], contents<uint32_t>(buffers_.escaped));
  });
  for (uint32_t c = 0; c < MATERIAL_CLASS_COUNT; ++c) set_groups(heads[bounce_queue(c)]);
  set_groups(heads[Queue::Escaped]);
}

template <typename Candidate>
void HostRays::trace_segments(const gpu::Buffer& candidates, uint32_t count) {
  auto* all = contents<Candidate>(candidates);
  workers_.run(count, RAYS_AT_ONCE, [&](uint32_t begin, uint32_t end) {
    for (uint32_t i = begin; i < end; ++i) {
      VisibilityCandidate& segment = segment_of(all[i]);
      if (!query_.is_open(segment.origin, segment.direction, segment.t_max))
        segment.t_max = -1;
      else if (segment.t_max < 0)
        segment.t_max = 0;
    }
  });
}

}  // namespace regulus::render
