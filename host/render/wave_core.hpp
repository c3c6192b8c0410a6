// One wave of a pass on its way through the stages, cut into submissions of bounded work.
#pragma once

#include <cstdint>
#include <vector>

#include "gpu/gpu.hpp"
#include "render/host_rays.hpp"
#include "render/queues.hpp"
#include "render/stages.hpp"
#include "render/watch.hpp"
#include "render/wavefront_buffers.hpp"
#include "render/work_queue.hpp"

namespace regulus::render {

/// Largest number of items that one path in flight can make in a bounce, besides connections and merges: its
/// ray, the surface it meets, and a light sample or two splats.
inline constexpr uint64_t ITEMS_PER_PATH = 4;

class WaveCore {
 public:
  /// All must outlive the object. `host_rays`: traces rays instead of kernels, which the pipeline then lacks;
  /// may be null.
  WaveCore(gpu::Device& device, WorkQueue& work, const Watch& watch,
           const std::vector<PipelineStep>& pipeline, const WavefrontBuffers& buffers, const Plan& plan,
           HostRays* host_rays);

  /// Runs all steps of a light or camera pass over arguments.wave_paths paths. `reach`: the largest
  /// number of light vertices that one camera vertex may look at in a merge. Returns false if the wave was
  /// not recorded to its end because the work was cancelled. Preconditions: wave_paths times ITEMS_PER_PATH
  /// is within the queue's bound; the wave holds at most most_paths(reach).
  bool run(Pass pass, const interface::StageArguments& arguments, uint64_t reach = 0);

  /// Largest number of paths in a wave: the steps of its merges are numbered with 32 bits.
  static uint64_t most_paths(uint64_t reach);

 private:
  template <typename IsMeant, typename Record>
  void for_each_step(Pass pass, const interface::StageArguments& arguments, const IsMeant& is_meant,
                     const Record& record);
  void record_ends(Pass pass, Extent extent, const interface::StageArguments& arguments);
  template <typename IsMeant>
  void record_bounce(Pass pass, const interface::StageArguments& arguments, uint64_t items,
                     const IsMeant& is_meant);
  bool trace_on_host(const StageStep& step, uint32_t bounce);
  void run_bounce(Pass pass, interface::StageArguments arguments, uint64_t live, uint64_t reach);
  void run_counted_bounce(Pass pass, const interface::StageArguments& arguments, uint64_t live,
                          bool counts_merges, uint64_t reach);
  void run_over_queue(Stage stage, const interface::StageArguments& arguments, const QueueHeads& heads);
  void run_merges(interface::StageArguments arguments, const QueueHeads& heads, uint64_t units,
                  uint64_t reach);
  QueueHeads read_heads(uint32_t bounce);

  gpu::Device& device_;
  WorkQueue& work_;
  const Watch& watch_;
  const std::vector<PipelineStep>& pipeline_;
  const WavefrontBuffers& buffers_;
  HostRays* host_rays_;
  uint32_t max_depth_;
  uint64_t connections_;  // of one path in a bounce, at most
  bool has_merges_;
};

}  // namespace regulus::render
