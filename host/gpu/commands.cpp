// Recording of command lists: order of commands, and the timestamps around dispatches.
#include <fmt/format.h>

#include <stdexcept>

#include "base/error.hpp"
#include "gpu/limits.hpp"
#include "gpu/state.hpp"

namespace regulus::gpu {
namespace {

using Access = vk::AccessFlagBits;
using Stage = vk::PipelineStageFlagBits;

void check_words(uint64_t value, const char* what) {
  if (value % 4 != 0) throw std::logic_error(fmt::format("{} {} is not a multiple of 4", what, value));
}

}  // namespace

std::unique_ptr<Recording> DeviceState::begin_recording() {
  std::unique_ptr<Recording> recording;
  if (idle.empty()) {
    recording = std::make_unique<Recording>();
    vk::raii::CommandBuffers buffers(device, {*pool, vk::CommandBufferLevel::ePrimary, 1});
    recording->commands = std::move(buffers.front());
    recording->fence = vk::raii::Fence(device, vk::FenceCreateInfo());
  } else {
    recording = std::move(idle.back());
    idle.pop_back();
  }
  recording->commands.begin({vk::CommandBufferUsageFlagBits::eOneTimeSubmit});
  return recording;
}

CommandList::CommandList(Device& device) : impl(std::make_unique<Impl>(device.impl->state)) {}
CommandList::~CommandList() = default;
CommandList::CommandList(CommandList&&) noexcept = default;
CommandList& CommandList::operator=(CommandList&&) noexcept = default;

CommandList::Impl::Impl(std::shared_ptr<DeviceState> device) : state(std::move(device)) {
  recording = state->begin_recording();
}

CommandList::Impl::~Impl() {
  if (!recording) return;  // it was submitted
  recording->commands.reset();
  state->idle.push_back(std::move(recording));
}

void CommandList::Impl::order_after_previous() {
  // The first command of a list always waits: its barrier reaches back through all earlier submissions.
  const bool is_independent = next_is_independent && !is_empty;
  next_is_independent = false;
  is_empty = false;
  if (is_independent) return;
  const vk::PipelineStageFlags of_commands = Stage::eComputeShader | Stage::eTransfer | Stage::eDrawIndirect;
  const vk::MemoryBarrier barrier(Access::eShaderWrite | Access::eTransferWrite,
                                  Access::eShaderRead | Access::eShaderWrite | Access::eTransferRead |
                                      Access::eTransferWrite | Access::eIndirectCommandRead);
  recording->commands.pipelineBarrier(of_commands, of_commands, {}, barrier, {}, {});
}

uint32_t CommandList::Impl::write_timestamp() {
  const uint32_t pool = timestamps / TIMESTAMPS_PER_POOL;
  const uint32_t slot = timestamps % TIMESTAMPS_PER_POOL;
  if (pool == recording->timestamps.size())
    recording->timestamps.emplace_back(
        state->device, vk::QueryPoolCreateInfo({}, vk::QueryType::eTimestamp, TIMESTAMPS_PER_POOL));
  const vk::QueryPool queries = *recording->timestamps[pool];
  if (slot == 0) recording->commands.resetQueryPool(queries, 0, TIMESTAMPS_PER_POOL);
  recording->commands.writeTimestamp(Stage::eBottomOfPipe, queries, slot);
  return timestamps++;
}

void CommandList::Impl::begin_transfer() {
  order_after_previous();
  ended_with_timestamp = false;
}

void CommandList::Impl::begin_dispatch(const Kernel& kernel, std::span<const std::byte> push_constants) {
  if (push_constants.size() > PUSH_CONSTANT_BYTES)
    throw std::logic_error(fmt::format("stage {} has {} bytes of push constants, {} are possible",
                                       kernel.impl->name, push_constants.size(), PUSH_CONSTANT_BYTES));
  check_words(push_constants.size(), "push constant size");
  order_after_previous();
  const vk::raii::CommandBuffer& commands = recording->commands;
  commands.bindPipeline(vk::PipelineBindPoint::eCompute, **kernel.impl->pipeline);
  if (!push_constants.empty())
    commands.pushConstants<std::byte>(*state->layout, vk::ShaderStageFlagBits::eCompute, 0,
                                      {static_cast<uint32_t>(push_constants.size()), push_constants.data()});
  // A dispatch's time begins where the one before it ended.
  if (state->measures_time && !ended_with_timestamp) write_timestamp();
}

void CommandList::Impl::end_dispatch(const Kernel& kernel) {
  stages.push_back(kernel.impl->name);
  if (!state->measures_time) return;
  const uint32_t end = write_timestamp();
  times.push_back({end - 1, end});
  ended_with_timestamp = true;
}

void CommandList::Impl::copy(vk::Buffer from, uint64_t from_offset, vk::Buffer to, uint64_t to_offset,
                             uint64_t bytes) {
  begin_transfer();
  recording->commands.copyBuffer(from, to, vk::BufferCopy(from_offset, to_offset, bytes));
}

void CommandList::Impl::publish_to_host() {
  const vk::MemoryBarrier barrier(Access::eShaderWrite | Access::eTransferWrite,
                                  Access::eHostRead | Access::eHostWrite);
  recording->commands.pipelineBarrier(Stage::eComputeShader | Stage::eTransfer, Stage::eHost, {}, barrier, {},
                                      {});
}

void CommandList::dispatch(const Kernel& kernel, std::span<const std::byte> push_constants, uint32_t groups) {
  if (groups > impl->state->info().max_groups)
    throw std::logic_error(fmt::format("stage {} wants {} groups, device {} runs at most {}",
                                       kernel.impl->name, groups, impl->state->info().name,
                                       impl->state->info().max_groups));
  impl->begin_dispatch(kernel, push_constants);
  impl->recording->commands.dispatch(groups, 1, 1);
  impl->end_dispatch(kernel);
}

void CommandList::dispatch_indirect(const Kernel& kernel, std::span<const std::byte> push_constants,
                                    const Buffer& buffer, uint64_t offset) {
  check_words(offset, "indirect offset");
  const vk::Buffer arguments = checked_range(buffer, offset, sizeof(vk::DispatchIndirectCommand));
  impl->begin_dispatch(kernel, push_constants);
  impl->recording->commands.dispatchIndirect(arguments, offset);
  impl->end_dispatch(kernel);
}

void CommandList::fill(const Buffer& buffer, uint64_t offset, uint64_t bytes, uint32_t word) {
  if (bytes == 0) return;
  check_words(offset, "fill offset");
  const vk::Buffer target = checked_range(buffer, offset, bytes);
  impl->begin_transfer();
  // The memory of a buffer is padded to whole words.
  impl->recording->commands.fillBuffer(target, offset, whole_words(bytes), word);
}

void CommandList::copy(const Buffer& from, uint64_t from_offset, const Buffer& to, uint64_t to_offset,
                       uint64_t bytes) {
  if (bytes == 0) return;
  impl->copy(checked_range(from, from_offset, bytes), from_offset, checked_range(to, to_offset, bytes),
             to_offset, bytes);
}

void CommandList::independent() {
  impl->next_is_independent = true;
}

}  // namespace regulus::gpu
