// Buffers and the copies between host and device.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "gpu/faults.hpp"
#include "gpu/limits.hpp"
#include "gpu/state.hpp"

namespace regulus::gpu {
namespace {

using enum vk::BufferUsageFlagBits;

std::byte* staging_memory(DeviceState& state) {
  if (!state.staging.mapped)
    state.staging = state.allocate(STAGING_BYTES, eTransferSrc | eTransferDst, true, "staging");
  return state.staging.mapped;
}

/// Calls `copy_piece(offset, bytes)` for every piece of `bytes` that staging memory can hold.
template <typename CopyPiece>
void for_each_piece(uint64_t bytes, CopyPiece&& copy_piece) {
  for (uint64_t done = 0; done < bytes; done += STAGING_BYTES)
    copy_piece(done, std::min(STAGING_BYTES, bytes - done));
}

}  // namespace

Buffer::Buffer() = default;
Buffer::~Buffer() = default;
Buffer::Buffer(Buffer&&) noexcept = default;
Buffer& Buffer::operator=(Buffer&&) noexcept = default;
uint64_t Buffer::size() const {
  return impl ? impl->size : 0;
}
uint64_t Buffer::address() const {
  return impl ? impl->address : 0;
}
std::byte* Buffer::host() const {
  return impl ? impl->allocation.mapped : nullptr;
}

vk::Buffer checked_range(const Buffer& buffer, uint64_t offset, uint64_t bytes) {
  if (offset > buffer.size() || bytes > buffer.size() - offset)
    throw std::logic_error(fmt::format("bytes {} + {} lie outside buffer {} of {} bytes", offset, bytes,
                                       buffer.impl ? buffer.impl->name : "(empty)", buffer.size()));
  return buffer.impl ? *buffer.impl->allocation.buffer : vk::Buffer();
}

Buffer Device::create_buffer(uint64_t bytes, std::string_view name) {
  Buffer buffer;
  if (bytes == 0) return buffer;
  DeviceState& state = *impl->state;
  vk::BufferUsageFlags usage =
      eStorageBuffer | eIndirectBuffer | eTransferSrc | eTransferDst | eShaderDeviceAddress;
  if (info().has_ray_query) usage |= eAccelerationStructureBuildInputReadOnlyKHR;
  Allocation allocation = state.allocate(bytes, usage, info().kind == DeviceKind::Software, name);
  const uint64_t address = state.device.getBufferAddress({*allocation.buffer});
  buffer.impl.reset(new Buffer::Impl{impl->state, std::string(name), bytes, address, std::move(allocation)});

  CommandList commands(*this);
  commands.fill(buffer, 0, bytes, 0);
  Submission submission = submit(std::move(commands));
  wait(submission);
  return buffer;
}

void Device::upload(const Buffer& buffer, uint64_t offset, std::span<const std::byte> data) {
  if (data.empty()) return;
  const vk::Buffer target = checked_range(buffer, offset, data.size());
  std::byte* staging = staging_memory(*impl->state);
  for_each_piece(data.size(), [&](uint64_t done, uint64_t bytes) {
    std::memcpy(staging, data.data() + done, bytes);
    CommandList commands(*this);
    commands.impl->copy(*impl->state->staging.buffer, 0, target, offset + done, bytes);
    Submission submission = submit(std::move(commands));
    wait(submission);
  });
}

void Device::download(const Buffer& buffer, uint64_t offset, std::span<std::byte> data) {
  if (data.empty()) return;
  const vk::Buffer source = checked_range(buffer, offset, data.size());
  const std::byte* staging = staging_memory(*impl->state);
  for_each_piece(data.size(), [&](uint64_t done, uint64_t bytes) {
    CommandList commands(*this);
    commands.impl->copy(source, offset + done, *impl->state->staging.buffer, 0, bytes);
    commands.impl->publish_to_host();
    Submission submission = submit(std::move(commands));
    wait(submission);
    std::memcpy(data.data() + done, staging, bytes);
  });
  if (faults().downloads_before_loss.value_or(0) > 0) --*faults().downloads_before_loss;
}

}  // namespace regulus::gpu
