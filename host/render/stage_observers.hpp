// Observers of the wave core and the iteration of a real render: they copy what lies in the arrays
// (stage_recorder.hpp).
#pragma once

#include <algorithm>
#include <utility>

#include "render/recording_memory.hpp"
#include "render/stage_recorder.hpp"
#include "render/watch.hpp"

namespace regulus::render {

/// Records a wave of camera or light paths.
class WaveObserver : public StageObserver {
 public:
  WaveObserver(const RecordingMemory& memory, Recording& recording)
      : memory_(memory), recording_(recording) {}

  void before(Pass, Stage stage, const interface::StageArguments& arguments) override {
    if (stage != Stage::TraceClosest) return;
    RecordedBounce& bounce = recording_.bounces.emplace_back();
    bounce.slots = memory_.ray_queue(arguments.bounce);
    bounce.before = memory_.by_slot<interface::Path>(memory_.buffers().paths);
    bounce.media_before = memory_.path_media();
    memory_.fill(memory_.buffers().hits, interface::INVALID_INDEX);  // a ray that misses leaves no hit
  }

  void after(Pass pass, Stage stage, const interface::StageArguments& arguments) override {
    const WavefrontBuffers& buffers = memory_.buffers();
    if (stage == Stage::CameraGenerate || stage == Stage::LightGenerate || stage == Stage::StartMedia)
      recording_.generated = memory_.by_slot<interface::Path>(buffers.paths);
    if (recording_.bounces.empty()) return;
    RecordedBounce& bounce = recording_.bounces.back();
    if (stage == Stage::TraceClosest) {
      bounce.hits = memory_.by_slot<interface::Hit>(buffers.hits);
      bounce.media_on_arrival = memory_.path_media();
    } else if (stage == Stage::CameraBounce || stage == Stage::LightBounce) {
      bounce.after = memory_.by_slot<interface::Path>(buffers.paths);
      bounce.continuing = memory_.ray_queue(arguments.bounce + 1);
      if (pass == Pass::Camera) record_candidates(arguments, bounce);
    } else if (stage == Stage::TraceVisibility) {
      bounce.radiance = memory_.by_slot<glm::vec3>(buffers.radiance);
      for (const float share : {1 - PROBE_MARGIN, 1 + PROBE_MARGIN}) probe(arguments, share, bounce);
      memory_.upload(buffers.radiance, bounce.radiance);
    }
  }

 private:
  void record_candidates(const interface::StageArguments& arguments, RecordedBounce& bounce) const {
    const WavefrontBuffers& buffers = memory_.buffers();
    bounce.candidates = memory_.download<interface::VisibilityCandidate>(
        buffers.candidates, memory_.queue_count(arguments.bounce, Queue::Visibility));
    bounce.candidate_media = memory_.media(buffers.candidate_media, bounce.candidates.size());
    bounce.radiance_before_visibility = memory_.by_slot<glm::vec3>(buffers.radiance);
    bounce.radiance = bounce.radiance_before_visibility;  // the same, unless light samples add to it
  }

  // Probes segments along the bounce's rays, of `share` times the distance to what they hit. Each path has
  // one, and its radiance tells whether the segment is open.
  void probe(const interface::StageArguments& arguments, float share, RecordedBounce& bounce) {
    const WavefrontBuffers& buffers = memory_.buffers();
    std::vector<interface::VisibilityCandidate> segments;
    std::vector<interface::PathMedia> segment_media;
    for (const uint32_t slot : bounce.slots) {
      const interface::Path& path = bounce.before[slot];
      const interface::Hit& hit = bounce.hits[slot];
      if (hit.triangle == interface::INVALID_INDEX) continue;
      segments.push_back({path.origin, share * hit.t, path.direction, slot, glm::vec3(1)});
      if (!bounce.media_before.empty()) segment_media.push_back(bounce.media_before[slot]);
    }
    if (segments.empty()) return;
    const auto count = static_cast<uint32_t>(segments.size());
    const interface::QueueHead head {
      (count + interface::WORKGROUP_SIZE - 1) / interface::WORKGROUP_SIZE, 1, 1, count
    };
    memory_.upload(buffers.candidates, segments);
    if (!segment_media.empty()) memory_.upload(buffers.candidate_media, segment_media);
    memory_.upload(buffers.queue_heads, head, QueueHeads::offset_of(arguments.bounce, Queue::Visibility));
    memory_.fill(buffers.radiance, 0);
    memory_.run_again(Stage::TraceVisibility, arguments);
    const auto radiance = memory_.by_slot<glm::vec3>(buffers.radiance);
    for (const interface::VisibilityCandidate& segment : segments)
      bounce.probes.push_back({segment, radiance[segment.receiver].r > 0});
  }

  const RecordingMemory& memory_;
  Recording& recording_;
};

/// Records the light pass of an iteration; if its light paths are walked more than once, the last time.
class LightPassObserver : public StageObserver {
 public:
  LightPassObserver(const RecordingMemory& memory, ConnectionRecording& recording)
      : memory_(memory), recording_(recording) {}

  void before(Pass, Stage stage, const interface::StageArguments& arguments) override {
    if (stage == Stage::TraceClosest) memory_.fill(memory_.buffers().hits, interface::INVALID_INDEX);
    if (stage != Stage::LightGenerate) return;
    recording_.light_hits.clear();
    if (arguments.is_repeated != 0) return;  // the walk is repeated: its splats are those that were recorded
    recording_.splats.clear();
    recording_.splat_media.clear();
  }

  void after(Pass pass, Stage stage, const interface::StageArguments& arguments) override {
    const WavefrontBuffers& buffers = memory_.buffers();
    const size_t paths = buffers.frame().light_path_count, cells = buffers.grid_cell_count() + size_t{1};
    if (stage == Stage::TraceClosest)
      recording_.light_hits.push_back(memory_.by_slot<interface::Hit>(buffers.hits));
    if (stage == Stage::LightBounce && arguments.is_repeated == 0) record_splats(arguments.bounce);
    if (stage == Stage::LightPathCounts)
      recording_.path_counts = memory_.download<uint32_t>(buffers.light_path_ends, paths);
    if (stage == Stage::GridCount) {
      recording_.cell_counts = memory_.download<uint32_t>(buffers.grid_cells, cells);
      recording_.ranks = memory_.download<uint32_t>(buffers.grid_ranks, light_vertices());
    }
    if (stage == Stage::ScanSums && pass == Pass::Cache)
      recording_.path_ends = memory_.download<uint32_t>(buffers.light_path_ends, paths);
    if (stage == Stage::ScanSums && pass == Pass::Grid)
      recording_.cell_ends = memory_.download<uint32_t>(buffers.grid_cells, cells);
    if (stage == Stage::GridScatter)
      recording_.entries = memory_.download<interface::GridEntry>(buffers.grid_entries, light_vertices());
  }

 private:
  uint32_t light_vertices() const {
    const WavefrontBuffers& buffers = memory_.buffers();
    return std::min(memory_.download<uint32_t>(buffers.light_vertex_count, 1).front(),
                    buffers.frame().light_vertex_capacity);
  }

  void record_splats(uint32_t bounce) {
    const WavefrontBuffers& buffers = memory_.buffers();
    const auto splats = memory_.download<interface::SplatCandidate>(
        buffers.splats, memory_.queue_count(bounce, Queue::Splats));
    const std::vector<interface::PathMedia> media = memory_.media(buffers.splat_media, splats.size());
    recording_.splats.insert(recording_.splats.end(), splats.begin(), splats.end());
    recording_.splat_media.insert(recording_.splat_media.end(), media.begin(), media.end());
  }

  const RecordingMemory& memory_;
  ConnectionRecording& recording_;
};

/// Records connections and merges of a wave of camera paths.
class ConnectionObserver : public StageObserver {
 public:
  ConnectionObserver(const RecordingMemory& memory, ConnectionRecording& recording)
      : memory_(memory), recording_(recording) {}

  void before(Pass, Stage stage, const interface::StageArguments& arguments) override {
    const WavefrontBuffers& buffers = memory_.buffers();
    if (stage == Stage::TraceClosest) {
      recording_.bounces.emplace_back().slots = memory_.ray_queue(arguments.bounce);
      memory_.fill(buffers.hits, interface::INVALID_INDEX);
    } else if (stage == Stage::Merge &&
               recording_.bounces.back().merged.empty()) {  // the first of its rounds
      film_before_ = memory_.film(buffers.film);
    }
  }

  void after(Pass, Stage stage, const interface::StageArguments& arguments) override {
    if (recording_.bounces.empty()) return;
    const WavefrontBuffers& buffers = memory_.buffers();
    RecordedConnections& bounce = recording_.bounces.back();
    if (stage == Stage::TraceClosest) {
      bounce.hits = memory_.by_slot<interface::Hit>(buffers.hits);
      memory_.fill(buffers.radiance, 0);
    } else if (stage == Stage::CameraBounce) {
      bounce.met = memory_.by_slot<glm::vec3>(buffers.radiance);
      bounce.camera_vertices = memory_.by_slot<interface::CameraVertex>(buffers.camera_vertices);
      bounce.pairs = memory_.pairs(arguments.bounce);
      bounce.light_samples = memory_.download<interface::VisibilityCandidate>(
          buffers.candidates, memory_.queue_count(arguments.bounce, Queue::Visibility));
    } else if (stage == Stage::Connect) {
      const size_t light_samples = bounce.light_samples.size();
      const size_t all = memory_.queue_count(arguments.bounce, Queue::Visibility);
      bounce.connections = memory_.download<interface::VisibilityCandidate>(
          buffers.candidates, all - light_samples, light_samples);
    } else if (stage == Stage::Merge) {
      bounce.merged = memory_.film(buffers.film);
      for (size_t i = 0; i < film_before_.size(); ++i) bounce.merged[i] -= film_before_[i];
    }
  }

 private:
  const RecordingMemory& memory_;
  ConnectionRecording& recording_;
  std::vector<glm::dvec3> film_before_;
};

}  // namespace regulus::render
