#include "render/wavefront_buffers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <stdexcept>

#include "base/error.hpp"
#include "render/strategies.hpp"

namespace regulus::render {

using namespace interface;

namespace {

constexpr uint64_t MAX_GRID_CELLS = 1u << 24;

// Arrays that are made anew when there are more light vertices than there was room for.
bool is_by_light_vertex(const StateArray& array, const Plan& plan) {
  if (array.per == PER_PAIR || array.per == PER_CANDIDATE) return connects_own_paths(plan);
  return array.per == PER_LIGHT_VERTEX || array.per == PER_CELL_SUM;
}

// Kernels count the words of strategies' images with 32 bits.
void check_strategy_images(const gpu::Device& device, const Plan& plan) {
  const uint64_t strategies = list_strategies(plan.techniques, plan.max_depth).size();
  const uint64_t words = 2 * strategies * plan.window().pixels() * FILM_WORDS_PER_PIXEL;
  const uint64_t bytes = words * sizeof(uint32_t);
  if (words >= INVALID_INDEX || bytes > device.free_bytes())
    throw Error(
        ErrorCode::Failed,
        fmt::format("images of {} strategies need {} MiB of device memory, {} MiB are free; use a smaller "
                    "picture or shorter paths",
                    strategies, bytes >> 20, device.free_bytes() >> 20));
}

// Likewise of layers.
void check_layers(const gpu::Device& device, const Plan& plan) {
  const uint64_t layers = plan.layers.names.size() * ((plan.techniques & TECHNIQUE_SPLAT) != 0 ? 2 : 1);
  const uint64_t words = layers * plan.window().pixels() * FILM_WORDS_PER_PIXEL;
  const uint64_t bytes = words * sizeof(uint32_t);
  if (words >= INVALID_INDEX || bytes > device.free_bytes())
    throw Error(
        ErrorCode::Failed,
        fmt::format(
            "{} kinds and groups of light need {} MiB of device memory, {} MiB are free; use a smaller "
            "picture, or put nodes into one extras.regulus.light_group",
            plan.layers.names.size(), bytes >> 20, device.free_bytes() >> 20));
}

}  // namespace

WavefrontBuffers::WavefrontBuffers(gpu::Device& device, const DeviceScene& scene, const Camera& camera,
                                   const Plan& plan, uint32_t capacity)
    : plan_(plan), sizes_(sizes_of(plan, capacity, 0)) {
  const gpu::DeviceInfo& info = device.info();
  if (capacity > most_paths(plan, info.max_groups, info.max_allocation_bytes))
    throw std::logic_error(fmt::format(
        "{} path slots: a queue could hold more than a dispatch of device {} runs", capacity, info.name));
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
  frame_.shadow_roulette = plan.shadow_roulette;
  frame_.light_path_count = plan.light_paths;
  frame_.light_head_modulus = plan.is_per_wave ? 0 : plan.light_paths;
  frame_.pair_capacity = static_cast<uint32_t>(sizes_.pairs);
  frame_.cache_connections = plan.cache_connections;
  frame_.layer_count = static_cast<uint32_t>(plan.layers.names.size());
  const auto& kinds = plan.layers.of_kind;
  frame_.kind_layers = {kinds[0], kinds[1], kinds[2], kinds[3]};
  frame_.first_group_layer = plan.layers.first_group;
  if (plan.keeps(STATE_STRATEGIES)) check_strategy_images(device, plan);
  if (plan.keeps(STATE_LAYERS)) check_layers(device, plan);
  allocate(device, false);
  if (plan.keeps(STATE_LAYERS)) device.upload(light_groups, 0, gpu::bytes_of(plan.layers.group_of_light));
  const std::vector<QueueHead> heads((uint64_t{plan.max_depth} + 1) * QUEUES_PER_BOUNCE, {0, 1, 1, 0});
  empty_heads = gpu::upload_new(device, heads, "empty queue heads");
  if (plan.keeps(STATE_STRATEGIES))
    device.upload(strategy_layers, 0,
                  gpu::bytes_of(render::strategy_layers(list_strategies(plan.techniques, plan.max_depth),
                                                        plan.max_depth)));
  frame_buffer_ = device.create_buffer(sizeof(Frame), "frame");
  if (plan.keeps(STATE_VERTICES)) {
    grow_light_vertices(device,
                        expected_light_vertices(plan, plan.is_per_wave ? capacity : plan.light_paths));
  } else {
    device.upload(frame_buffer_, 0, gpu::bytes_of(frame_));
  }
}

// Calls visit(row, buffer, address in the frame) for each row of the table.
template <typename Visit>
void WavefrontBuffers::for_each_array(const Visit& visit) {
  const StateArray* row = STATE_ARRAYS.data();
#define STATE(name, element, times, per, when) visit(*row++, name, frame_.name);
#include "interface/state_table.h"
#undef STATE
}

// Allocates the arrays that grow with the light vertices, or all others. What they held before is freed
// first.
void WavefrontBuffers::allocate(gpu::Device& device, bool by_light_vertex) {
  for_each_array([&](const StateArray& row, gpu::Buffer& buffer, DeviceAddress& address) {
    if (is_by_light_vertex(row, plan_) != by_light_vertex) return;
    buffer = device.create_buffer(bytes_of_array(row, plan_, sizes_), row.name);
    address = device_address(buffer.address());
  });
}

void WavefrontBuffers::grow_light_vertices(gpu::Device& device, uint64_t vertices) {
  for_each_array([&](const StateArray& row, gpu::Buffer& buffer, DeviceAddress&) {
    if (is_by_light_vertex(row, plan_)) buffer = {};
  });
  const uint64_t bytes = vertices * bytes_per_light_vertex(plan_);
  if (vertices >= INVALID_INDEX || bytes > device.free_bytes())
    throw Error(
        ErrorCode::Failed,
        fmt::format("{} light vertices need {} MiB of device memory, {} MiB are free; use fewer light paths",
                    vertices, bytes >> 20, device.free_bytes() >> 20));
  sizes_ = sizes_of(plan_, sizes_.paths, vertices);
  sizes_.grid_cells = std::clamp<uint64_t>(std::bit_ceil(vertices), 64, MAX_GRID_CELLS);
  frame_.light_vertex_capacity = static_cast<uint32_t>(vertices);
  frame_.pair_capacity = static_cast<uint32_t>(sizes_.pairs);
  frame_.grid_cell_mask = static_cast<uint32_t>(sizes_.grid_cells - 1);
  allocate(device, true);
  device.upload(frame_buffer_, 0, gpu::bytes_of(frame_));
}

void WavefrontBuffers::expect_light_vertices(gpu::Device& device, uint64_t vertices) {
  frame_.cache_connect_count =
      static_cast<float>(static_cast<double>(frame_.cache_connections) * frame_.light_path_count /
                         std::max<double>(1, static_cast<double>(vertices)));
  device.upload(frame_buffer_, 0, gpu::bytes_of(frame_));
}

void WavefrontBuffers::connect_to_cache(gpu::Device& device, uint32_t connections) {
  frame_.cache_connections = connections;
  device.upload(frame_buffer_, 0, gpu::bytes_of(frame_));
}

}  // namespace regulus::render
