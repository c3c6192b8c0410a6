#include "render/wave_core.hpp"

#include <algorithm>
#include <cstring>
#include <span>

namespace regulus::render {

using namespace interface;

namespace {

// After this many bounces the host asks how many paths are left, which bounds all later bounces. Most renders
// end before.
constexpr uint32_t BOUNCES_BETWEEN_COUNTS = 16;
constexpr uint64_t UNITS_OFFSET = LIGHT_COUNT_UNITS * sizeof(uint32_t);  // in the light vertex count
// Looking at a light vertex takes a 32nd of the time of a ray, finding those in reach an eighth.
constexpr uint64_t VISITS_PER_ITEM = 32, NEIGHBOURHOODS_PER_ITEM = 8;

uint32_t groups_of(uint64_t items) {
  return static_cast<uint32_t>((items + WORKGROUP_SIZE - 1) / WORKGROUP_SIZE);
}

uint64_t units_of(uint64_t visits) {
  return (visits + MERGE_UNIT - 1) / MERGE_UNIT;
}

uint64_t merge_items(uint64_t vertices, uint64_t visits) {
  return vertices / NEIGHBOURHOODS_PER_ITEM + 1 + visits / VISITS_PER_ITEM + 1;
}

}  // namespace

WaveCore::WaveCore(gpu::Device& device, WorkQueue& work, const Watch& watch,
                   const std::vector<PipelineStep>& pipeline, const WavefrontBuffers& buffers,
                   const Plan& plan, HostRays* host_rays)
    : device_(device),
      work_(work),
      watch_(watch),
      pipeline_(pipeline),
      buffers_(buffers),
      host_rays_(host_rays),
      max_depth_(plan.max_depth),
      connections_(plan.connections_per_vertex),
      has_merges_(plan.keeps(STATE_MERGES)) {}

uint64_t WaveCore::most_paths(uint64_t reach) {
  return std::max<uint64_t>(UINT32_MAX / std::max<uint64_t>(units_of(reach), 1), 1);
}

bool WaveCore::run(Pass pass, const StageArguments& arguments, uint64_t reach) {
  uint64_t live = arguments.wave_paths;
  work_.room_for(live).copy(buffers_.empty_heads, 0, buffers_.queue_heads, 0, buffers_.queue_heads.size());
  record_ends(pass, Extent::WaveStart, arguments);
  const bool counts_each = host_rays_ != nullptr || watch_.is_on();
  const uint32_t bounces = pass == Pass::Light ? std::max(max_depth_, 2u) - 1 : max_depth_;
  StageArguments own = arguments;
  for (own.bounce = 0; own.bounce < bounces && live > 0; ++own.bounce) {
    if (own.bounce > 0 && (counts_each || own.bounce % BOUNCES_BETWEEN_COUNTS == 0))
      live = read_heads(own.bounce)[Queue::Rays].count;
    if (work_.is_cancelled()) return false;
    if (live > 0) run_bounce(pass, own, live, pass == Pass::Camera ? reach : 0);
  }
  if (work_.is_cancelled()) return false;
  work_.room_for(2 * uint64_t{arguments.wave_paths});
  record_ends(pass, Extent::WaveEnd, arguments);
  own = arguments;
  own.counted_pass = pass == Pass::Light ? COUNTED_LIGHT_PASS : COUNTED_CAMERA_PASS;
  record_ends(pass, Extent::Once, own);
  return true;
}

// Calls record(entry, is_independent) for every step of the pass that is meant, in order. Steps of a stage
// that follow each other are independent; the stage as a whole may be watched.
template <typename IsMeant, typename Record>
void WaveCore::for_each_step(Pass pass, const StageArguments& arguments, const IsMeant& is_meant,
                             const Record& record) {
  const PipelineStep* previous = nullptr;
  for (const PipelineStep& entry : pipeline_) {
    if (entry.step.pass != pass || !is_meant(entry.step)) continue;
    const bool is_independent = previous != nullptr && previous->step.stage == entry.step.stage;
    if (!is_independent) {
      if (previous != nullptr) watch_.after(pass, previous->step.stage, arguments);
      watch_.before(pass, entry.step.stage, arguments);
    }
    record(entry, is_independent);
    previous = &entry;
  }
  if (previous != nullptr) watch_.after(pass, previous->step.stage, arguments);
}

// Records every step of this extent that runs once in a wave.
void WaveCore::record_ends(Pass pass, Extent extent, const StageArguments& arguments) {
  const uint32_t groups = extent == Extent::Once ? 1 : groups_of(arguments.wave_paths);
  for_each_step(
      pass, arguments, [&](const StageStep& step) { return step.extent == extent; },
      [&](const PipelineStep& entry, bool is_independent) {
        gpu::CommandList& commands = work_.room_for(0);
        if (is_independent) commands.independent();
        commands.dispatch(entry.kernel, gpu::bytes_of(arguments), groups);
      });
}

// Steps of a bounce, of `items` items in all. Queues are dispatched indirectly with exact counts.
template <typename IsMeant>
void WaveCore::record_bounce(Pass pass, const StageArguments& arguments, uint64_t items,
                             const IsMeant& is_meant) {
  work_.room_for(items);
  for_each_step(pass, arguments, is_meant, [&](const PipelineStep& entry, bool is_independent) {
    if (trace_on_host(entry.step, arguments.bounce)) work_.room_for(items);
    if (!entry.kernel.impl) return;
    gpu::CommandList& commands = work_.room_for(0);
    if (is_independent) commands.independent();
    record_over_queue(commands, entry, arguments, buffers_.queue_heads);
  });
}

// If the host traces the step's rays: does so, once everything recorded before has run.
bool WaveCore::trace_on_host(const StageStep& step, uint32_t bounce) {
  if (host_rays_ == nullptr || !HostRays::traces(step)) return false;
  work_.finish();
  host_rays_->trace(step, bounce);
  return true;
}

// Rays only grow fewer from bounce to bounce: `live` bounds what the bounce can make.
void WaveCore::run_bounce(Pass pass, StageArguments arguments, uint64_t live, uint64_t reach) {
  const bool is_camera = pass == Pass::Camera;
  const uint64_t connect_items = is_camera ? 2 * connections_ * live : 0;
  const bool merges = is_camera && has_merges_;
  const bool is_reach_short = reach <= MERGE_ROUND_LENGTH;
  const uint64_t others = ITEMS_PER_PATH * live + connect_items;
  const uint64_t all = others + (merges ? merge_items(live, live * reach) : 0);
  if (is_reach_short && all <= work_.bound())
    record_bounce(pass, arguments, all, [](const StageStep& step) { return step.extent == Extent::Bounce; });
  else
    run_counted_bounce(pass, arguments, live, merges, reach);
}

// Runs a bounce whose work may be too much for a submission: the work is counted once it is known, and cut.
void WaveCore::run_counted_bounce(Pass pass, const StageArguments& arguments, uint64_t live,
                                  bool counts_merges, uint64_t reach) {
  const auto is_walk = [&](const StageStep& step) {
    if (step.extent == Extent::MergeCount) return counts_merges;
    return step.extent == Extent::Bounce && step.stage != Stage::Connect &&
           step.stage != Stage::TraceVisibility && step.stage != Stage::Merge;
  };
  if (counts_merges) work_.room_for(1).fill(buffers_.light_vertex_count, UNITS_OFFSET, sizeof(uint32_t), 0);
  record_bounce(pass, arguments, ITEMS_PER_PATH * live, is_walk);
  QueueHeads heads = read_heads(arguments.bounce);
  const uint64_t units =
      counts_merges
          ? gpu::download_all<uint32_t>(device_, buffers_.light_vertex_count, 1, UNITS_OFFSET).front()
          : 0;
  run_over_queue(Stage::Connect, arguments, heads);
  // Connections that carry something become candidates.
  for (uint32_t c = 0; c < MATERIAL_CLASS_COUNT; ++c)
    heads[Queue::Visibility].count += heads[pair_queue(c)].count;
  run_over_queue(Stage::TraceVisibility, arguments, heads);
  run_merges(arguments, heads, units, reach);
}

void WaveCore::run_over_queue(Stage stage, const StageArguments& arguments, const QueueHeads& heads) {
  const uint64_t most_groups = device_.info().max_groups;
  for_each_step(
      Pass::Camera, arguments, [&](const StageStep& step) { return step.stage == stage; },
      [&](const PipelineStep& entry, bool) {
        trace_on_host(entry.step, arguments.bounce);
        const uint64_t count = heads[entry.step.queue].count;
        StageArguments own = arguments;
        for (uint64_t first = 0, items = 0; first < count && !work_.is_cancelled(); first += items) {
          items = std::min(work_.bound(), count - first);
          own.first_item = static_cast<uint32_t>(first);
          record_items(work_.room_for(items), entry, own, items, &StageArguments::first_item, most_groups);
        }
      });
}

// The steps of all merges of the bounce are numbered in units of MERGE_UNIT; each dispatch takes a range of
// them, and of one vertex no more than an invocation may.
void WaveCore::run_merges(StageArguments arguments, const QueueHeads& heads, uint64_t units, uint64_t reach) {
  const uint64_t units_at_once = std::max<uint64_t>(work_.bound() / 2 * VISITS_PER_ITEM / MERGE_UNIT, 1);
  for (uint64_t first = 0; first < units && !work_.is_cancelled(); first += units_at_once) {
    const uint64_t here = std::min(units_at_once, units - first);
    arguments.merge_first = static_cast<uint32_t>(first);
    arguments.merge_units = static_cast<uint32_t>(here);
    const uint64_t longest = std::min(reach, here * MERGE_UNIT);
    const auto turns = static_cast<uint32_t>((longest + MERGE_ROUND_LENGTH - 1) / MERGE_ROUND_LENGTH);
    for (arguments.merge_turn = 0; arguments.merge_turn < turns; ++arguments.merge_turn)
      for_each_step(
          Pass::Camera, arguments, [](const StageStep& step) { return step.stage == Stage::Merge; },
          [&](const PipelineStep& entry, bool) {
            const uint64_t count = heads[entry.step.queue].count;
            if (count == 0 || work_.is_cancelled()) return;
            const uint64_t visits = std::min(here * MERGE_UNIT, count * MERGE_ROUND_LENGTH);
            work_.room_for(merge_items(count, visits))
                .dispatch(entry.kernel, gpu::bytes_of(arguments), groups_of(count));
          });
  }
}

QueueHeads WaveCore::read_heads(uint32_t bounce) {
  work_.finish();
  QueueHeads heads;
  const uint64_t offset = QueueHeads::offset_of(bounce);
  if (const std::byte* in_place = buffers_.queue_heads.host())
    std::memcpy(&heads, in_place + offset, sizeof(heads));
  else
    device_.download(buffers_.queue_heads, offset, std::as_writable_bytes(std::span(heads.heads)));
  return heads;
}

}  // namespace regulus::render
