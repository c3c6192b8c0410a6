#include "render/wavefront_buffers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

#include "base/error.hpp"
#include "render/scan.hpp"
#include "render/strategies.hpp"

namespace regulus::render {

using namespace interface;

namespace {

// Light vertices per light path that are made room for before the first count is known.
constexpr uint64_t EXPECTED_VERTICES = 4;
constexpr uint64_t MAX_GRID_CELLS = 1u << 24;

DeviceAddress address(const gpu::Buffer& buffer) {
  return device_address(buffer.address());
}

bool has(const Plan& plan, uint32_t techniques) {
  return (plan.techniques & techniques) != 0;
}

// Most light vertices of one path: one edge at least leads to the camera.
uint64_t vertices_per_path(const Plan& plan) {
  return std::max(plan.max_depth, 2u) - 1;
}

// Most splat candidates of one path in one bounce: without `hit` the first bounce holds the emitter's own,
// too.
uint64_t splats_per_path(const Plan& plan) {
  if (!has(plan, TECHNIQUE_SPLAT)) return 0;
  return has(plan, TECHNIQUE_HIT) ? 1 : 2;
}

}  // namespace

uint64_t pairs_per_path(const Plan& plan) {
  if (!has(plan, TECHNIQUE_CONNECT)) return 0;
  return plan.cache_connections != 0 ? plan.cache_connections : vertices_per_path(plan);
}

uint64_t most_paths(const Plan& plan, uint64_t most_groups, uint64_t most_bytes) {
  const uint64_t pairs = pairs_per_path(plan), splats = splats_per_path(plan);
  const uint64_t most_items = std::min<uint64_t>(most_groups * WORKGROUP_SIZE, UINT32_MAX);
  const LightVertexPlan& kept = plan.light_vertices;
  const uint64_t own_vertices = kept.has_vertices && kept.is_per_wave ? vertices_per_path(plan) : 0;
  const uint64_t bytes = std::max({uint64_t{sizeof(Path)}, (1 + pairs) * sizeof(VisibilityCandidate),
                                   MATERIAL_CLASS_COUNT * pairs * sizeof(ConnectionPair),
                                   splats * sizeof(SplatCandidate), own_vertices * sizeof(PathVertex)});
  return std::min(most_items / std::max(1 + pairs, splats), most_bytes / bytes);
}

uint64_t bytes_per_path(const Plan& plan) {
  const LightVertexPlan& kept = plan.light_vertices;
  const uint64_t pairs = pairs_per_path(plan);
  uint64_t bytes = sizeof(Path) + sizeof(Hit) + sizeof(vec3) + 2 * sizeof(uint32_t) +
                   MATERIAL_CLASS_COUNT * sizeof(uint32_t) + (1 + pairs) * sizeof(VisibilityCandidate) +
                   MATERIAL_CLASS_COUNT * pairs * sizeof(ConnectionPair);
  bytes += splats_per_path(plan) * sizeof(SplatCandidate);
  if (plan.has_strategy_images) bytes += (1 + pairs + splats_per_path(plan)) * sizeof(StrategyCandidate);
  if ((plan.features.bits & FEATURE_ENVIRONMENT) != 0) bytes += sizeof(uint32_t);
  if (kept.has_media) {
    bytes += (2 + pairs + splats_per_path(plan)) * sizeof(PathMedia);
    if (kept.has_vertices) bytes += sizeof(MediaSet) * (1 + (kept.is_per_wave ? vertices_per_path(plan) : 0));
  }
  if (kept.has_receivers) bytes += sizeof(LightReceiver);
  if (kept.has_vertices) bytes += sizeof(PathVertex);
  if (kept.has_histories)
    bytes +=
        sizeof(PathHistory) * (kept.has_vertices ? 2 + (kept.is_per_wave ? vertices_per_path(plan) : 0) : 1);
  if (kept.has_merges) bytes += sizeof(uint32_t);
  if (kept.has_footprints) bytes += sizeof(vec3);
  if (kept.has_sharp) bytes += sizeof(vec2) * (kept.is_per_wave ? 1 + vertices_per_path(plan) : 1);
  if (kept.has_vertices && kept.is_per_wave)
    bytes += vertices_per_path(plan) * sizeof(PathVertex) + sizeof(LightPathHead);
  return bytes;
}

WavefrontBuffers::WavefrontBuffers(gpu::Device& device, const DeviceScene& scene, const Camera& camera,
                                   const Plan& plan, uint32_t capacity)
    : vertex_plan_(plan.light_vertices) {
  scene.fill(frame_);
  frame_.width = plan.width;
  frame_.height = plan.height;
  const Window window = plan.window();
  frame_.crop = {window.x, window.y, window.width, window.height};
  frame_.seed = plan.seed;
  frame_.max_depth = plan.max_depth;
  frame_.wave_capacity = capacity;
  frame_.filter_radius = plan.filter_radius;
  frame_.filter_sigma = plan.filter_sigma;
  frame_.camera = camera;
  frame_.tau = plan.tau;
  frame_.largest_contribution = plan.largest_contribution;
  frame_.light_path_count = plan.light_paths;
  frame_.light_head_modulus = vertex_plan_.is_per_wave ? 0 : plan.light_paths;
  frame_.pair_capacity = static_cast<uint32_t>(capacity * pairs_per_path(plan));
  frame_.cache_connections = plan.cache_connections;
  create_path_buffers(device, plan);
  if (vertex_plan_.has_media) create_media_buffers(device, plan);
  create_light_buffers(device, plan);
  if (plan.has_strategy_images) create_strategy_buffers(device, plan);
  frame_buffer_ = gpu::upload_new(device, std::vector<Frame>{frame_}, "frame");
}

void WavefrontBuffers::create_path_buffers(gpu::Device& device, const Plan& plan) {
  const auto per_path = [&](uint64_t bytes, const char* name, DeviceAddress& target) {
    gpu::Buffer buffer = device.create_buffer(frame_.wave_capacity * bytes, name);
    target = address(buffer);
    return buffer;
  };
  const uint64_t pairs = pairs_per_path(plan);
  paths_ = per_path(sizeof(Path), "paths", frame_.paths);
  hits_ = per_path(sizeof(Hit), "hits", frame_.hits);
  radiance_ = per_path(sizeof(vec3), "radiance", frame_.radiance);
  ray_queues_ = per_path(2 * sizeof(uint32_t), "ray queues", frame_.ray_queues);
  bounce_queues_ = per_path(MATERIAL_CLASS_COUNT * sizeof(uint32_t), "bounce queues", frame_.bounce_queues);
  candidates_ =
      per_path((1 + pairs) * sizeof(VisibilityCandidate), "visibility candidates", frame_.candidates);
  pairs_ = per_path(MATERIAL_CLASS_COUNT * pairs * sizeof(ConnectionPair), "connection pairs", frame_.pairs);
  splats_ = per_path(splats_per_path(plan) * sizeof(SplatCandidate), "splats", frame_.splats);
  if ((plan.features.bits & FEATURE_ENVIRONMENT) != 0)
    escaped_ = per_path(sizeof(uint32_t), "escaped paths", frame_.escaped);
  if (vertex_plan_.has_receivers)
    light_receivers_ = per_path(sizeof(LightReceiver), "light receivers", frame_.light_receivers);
  if (vertex_plan_.has_sharp)
    light_path_sharp_ = per_path(sizeof(vec2), "sharp accumulators", frame_.light_path_sharp);
  if (vertex_plan_.has_footprints)
    path_footprints = per_path(sizeof(vec3), "footprints", frame_.path_footprints);
  if (vertex_plan_.has_histories)
    path_histories_ = per_path(sizeof(PathHistory), "path histories", frame_.path_histories);
  if (vertex_plan_.has_histories && vertex_plan_.has_vertices)
    camera_vertex_histories_ =
        per_path(sizeof(PathHistory), "camera vertex histories", frame_.camera_vertex_histories);
  if (vertex_plan_.has_merges)
    merge_starts_ = per_path(sizeof(uint32_t), "merge starts", frame_.merge_starts);
  if (vertex_plan_.has_vertices)
    camera_vertices_ = per_path(sizeof(PathVertex), "camera vertices", frame_.camera_vertices);

  // One head more than bounces: the last bounce still names the queue after it.
  const std::vector<QueueHead> heads((uint64_t{plan.max_depth} + 1) * QUEUES_PER_BOUNCE, {0, 1, 1, 0});
  empty_heads = gpu::upload_new(device, heads, "empty queue heads");
  queue_heads = gpu::upload_new(device, heads, "queue heads");
  const uint64_t pixels = plan.window().pixels();
  const uint64_t film_bytes = pixels * FILM_WORDS_PER_PIXEL * sizeof(uint32_t);
  film = device.create_buffer(film_bytes, "film");
  if (has(plan, TECHNIQUE_SPLAT)) splat_film = device.create_buffer(film_bytes, "splat film");
  if ((plan.aovs & AOV_VARIANCE) != 0) {
    film_earlier = device.create_buffer(film_bytes, "earlier film");
    film_squares = device.create_buffer(film_bytes, "film of squares");
  }
  if ((plan.aovs & SURFACE_AOVS) != 0) aovs = device.create_buffer(pixels * sizeof(AovPixel), "aovs");
  counters = device.create_buffer(COUNTER_COUNT * 2 * sizeof(uint32_t), "counters");
  frame_.queue_heads = address(queue_heads);
  frame_.film = address(film);
  frame_.splat_film = address(splat_film);
  frame_.film_earlier = address(film_earlier);
  frame_.film_squares = address(film_squares);
  frame_.aovs = address(aovs);
  frame_.counters = address(counters);
}

void WavefrontBuffers::create_media_buffers(gpu::Device& device, const Plan& plan) {
  const auto per_path = [&](uint64_t bytes, const char* name, DeviceAddress& target) {
    gpu::Buffer buffer = device.create_buffer(frame_.wave_capacity * bytes, name);
    target = address(buffer);
    return buffer;
  };
  path_media_ = per_path(sizeof(PathMedia), "media of paths", frame_.path_media);
  candidate_media_ =
      per_path((1 + pairs_per_path(plan)) * sizeof(PathMedia), "media of candidates", frame_.candidate_media);
  splat_media_ = per_path(splats_per_path(plan) * sizeof(PathMedia), "media of splats", frame_.splat_media);
  if (vertex_plan_.has_vertices)
    camera_vertex_media_ = per_path(sizeof(MediaSet), "media of camera vertices", frame_.camera_vertex_media);
}

void WavefrontBuffers::create_strategy_buffers(gpu::Device& device, const Plan& plan) {
  const std::vector<Strategy> strategies = list_strategies(plan.techniques, plan.max_depth);
  const uint64_t words = 2 * strategies.size() * plan.window().pixels() * FILM_WORDS_PER_PIXEL;
  const uint64_t bytes = words * sizeof(uint32_t);
  // Kernels count the words with 32 bits.
  if (words >= INVALID_INDEX || bytes > device.free_bytes())
    throw Error(
        ErrorCode::Failed,
        fmt::format("images of {} strategies need {} MiB of device memory, {} MiB are free; use a smaller "
                    "picture or shorter paths",
                    strategies.size(), bytes >> 20, device.free_bytes() >> 20));
  strategy_film = device.create_buffer(bytes, "strategy films");
  strategy_layers_ = gpu::upload_new(device, strategy_layers(strategies, plan.max_depth), "strategy layers");
  const uint64_t candidates = frame_.wave_capacity * (1 + pairs_per_path(plan));
  candidate_strategies_ =
      device.create_buffer(candidates * sizeof(StrategyCandidate), "strategies of candidates");
  splat_strategies_ = device.create_buffer(
      frame_.wave_capacity * splats_per_path(plan) * sizeof(StrategyCandidate), "strategies of splats");
  frame_.strategy_film = address(strategy_film);
  frame_.strategy_layers = address(strategy_layers_);
  frame_.candidate_strategies = address(candidate_strategies_);
  frame_.splat_strategies = address(splat_strategies_);
}

void WavefrontBuffers::create_light_buffers(gpu::Device& device, const Plan& plan) {
  light_vertex_count = device.create_buffer(LIGHT_COUNT_WORDS * sizeof(uint32_t), "light vertex count");
  frame_.light_vertex_count = address(light_vertex_count);
  if (!vertex_plan_.has_vertices) return;
  const uint64_t heads = vertex_plan_.is_per_wave ? frame_.wave_capacity : plan.light_paths;
  light_heads_ = device.create_buffer(heads * sizeof(LightPathHead), "light path heads");
  frame_.light_heads = address(light_heads_);
  if (has(plan, TECHNIQUE_CONNECT) && plan.cache_connections != 0) {
    light_path_ends = device.create_buffer(Scan::words_needed(heads) * sizeof(uint32_t), "light path ends");
    frame_.light_path_ends = address(light_path_ends);
  }
  const uint64_t most = vertices_per_path(plan);
  grow_light_vertices(device, heads * (vertex_plan_.is_per_wave ? most : std::min(most, EXPECTED_VERTICES)));
}

void WavefrontBuffers::grow_light_vertices(gpu::Device& device, uint64_t vertices) {
  const uint64_t bytes_each = sizeof(PathVertex) + (vertex_plan_.has_sharp ? sizeof(vec2) : 0) +
                              (vertex_plan_.has_histories ? sizeof(PathHistory) : 0) +
                              (vertex_plan_.has_media ? sizeof(MediaSet) : 0) +
                              (vertex_plan_.has_merges ? sizeof(GridEntry) + sizeof(uint32_t) : 0);
  light_vertices_ = {};
  light_vertex_sharp_ = {};
  light_vertex_histories_ = {};
  light_vertex_media_ = {};
  grid_ranks_ = {};
  grid_entries_ = {};
  if (vertices >= INVALID_INDEX || vertices * bytes_each > device.free_bytes())
    throw Error(
        ErrorCode::Failed,
        fmt::format("{} light vertices need {} MiB of device memory, {} MiB are free; use fewer light paths",
                    vertices, vertices * bytes_each >> 20, device.free_bytes() >> 20));
  frame_.light_vertex_capacity = static_cast<uint32_t>(vertices);
  light_vertices_ = device.create_buffer(vertices * sizeof(PathVertex), "light vertices");
  frame_.light_vertices = address(light_vertices_);
  if (vertex_plan_.has_sharp) {
    light_vertex_sharp_ = device.create_buffer(vertices * sizeof(vec2), "sharp light vertices");
    frame_.light_vertex_sharp = address(light_vertex_sharp_);
  }
  if (vertex_plan_.has_histories) {
    light_vertex_histories_ = device.create_buffer(vertices * sizeof(PathHistory), "light vertex histories");
    frame_.light_vertex_histories = address(light_vertex_histories_);
  }
  if (vertex_plan_.has_media) {
    light_vertex_media_ = device.create_buffer(vertices * sizeof(MediaSet), "media of light vertices");
    frame_.light_vertex_media = address(light_vertex_media_);
  }
  if (vertex_plan_.has_merges) {
    const uint64_t cells = std::clamp<uint64_t>(std::bit_ceil(vertices), 64, MAX_GRID_CELLS);
    frame_.grid_cell_mask = static_cast<uint32_t>(cells - 1);
    grid_cells = device.create_buffer(Scan::words_needed(cells + 1) * sizeof(uint32_t), "grid cells");
    grid_ranks_ = device.create_buffer(vertices * sizeof(uint32_t), "grid ranks");
    grid_entries_ = device.create_buffer(vertices * sizeof(GridEntry), "grid entries");
    frame_.grid_cells = address(grid_cells);
    frame_.grid_ranks = address(grid_ranks_);
    frame_.grid_entries = address(grid_entries_);
  }
  if (frame_buffer_.size() != 0) device.upload(frame_buffer_, 0, gpu::bytes_of(frame_));
}

void WavefrontBuffers::expect_light_vertices(gpu::Device& device, uint64_t vertices) {
  frame_.cache_connect_count =
      static_cast<float>(static_cast<double>(frame_.cache_connections) * frame_.light_path_count /
                         std::max<double>(1, static_cast<double>(vertices)));
  device.upload(frame_buffer_, 0, gpu::bytes_of(frame_));
}

}  // namespace regulus::render
