// Device memory: which kind a buffer gets, how much is left.
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <optional>

#include "base/error.hpp"
#include "gpu/faults.hpp"
#include "gpu/state.hpp"

namespace regulus::gpu {
namespace {

using enum vk::MemoryPropertyFlagBits;

double mebibytes(uint64_t bytes) {
  return static_cast<double>(bytes) / (1 << 20);
}

/// Memory that Linux could give to programs without swapping.
uint64_t host_free_bytes() {
  std::ifstream file("/proc/meminfo");
  std::string field, unit;
  uint64_t kibibytes = 0;
  while (file >> field >> kibibytes) {
    if (field == "MemAvailable:") return kibibytes << 10;
    std::getline(file, unit);
  }
  return std::numeric_limits<uint64_t>::max();
}

}  // namespace

uint32_t DeviceState::memory_type(uint32_t allowed_types, bool host_visible) const {
  const auto first_with = [&](vk::MemoryPropertyFlags wanted) -> std::optional<uint32_t> {
    // Memory that only exists on demand, or that must be asked for, is never what a buffer wants.
    const vk::MemoryPropertyFlags unwanted = eLazilyAllocated | eProtected | eDeviceCoherentAMD;
    for (uint32_t i = 0; i < memory.memoryTypeCount; ++i) {
      const vk::MemoryPropertyFlags has = memory.memoryTypes[i].propertyFlags;
      if ((allowed_types >> i & 1) && (has & wanted) == wanted && !(has & unwanted)) return i;
    }
    return std::nullopt;
  };
  // Vulkan orders types so that the first match is the plainest one, and guarantees the last of each list.
  if (host_visible) {
    // Reading memory that the host does not cache is slow.
    if (const auto cached = first_with(eHostVisible | eHostCoherent | eHostCached)) return *cached;
    return first_with(eHostVisible | eHostCoherent).value();
  }
  if (const auto local = first_with(eDeviceLocal)) return *local;
  return first_with({}).value();
}

void DeviceState::throw_out_of_memory(uint64_t bytes, std::string_view name) const {
  throw Error(
      ErrorCode::Failed,
      fmt::format("device {} has no memory for buffer {}: it needs {:.1f} MiB, {:.1f} MiB are in use "
                  "and about {:.1f} MiB are free; render a smaller image or scene, or crops of it",
                  info().name, name, mebibytes(bytes), mebibytes(allocated_bytes), mebibytes(free_bytes())));
}

Allocation DeviceState::allocate(uint64_t bytes, vk::BufferUsageFlags usage, bool host_visible,
                                 std::string_view name) {
  if (bytes > info().max_allocation_bytes)
    throw Error(ErrorCode::Failed,
                fmt::format("buffer {} needs {:.1f} MiB, device {} allocates at most {:.1f} MiB at once; "
                            "render a smaller image or scene, or crops of it",
                            name, mebibytes(bytes), info().name, mebibytes(info().max_allocation_bytes)));
  if (bytes > memory_bytes - std::min(memory_bytes, allocated_bytes)) throw_out_of_memory(bytes, name);
  try {
    if (faults().out_of_memory || Faults::is_due(faults().allocations_before_failure))
      throw vk::OutOfDeviceMemoryError("fault asked for by a test");
    Allocation allocation;
    allocation.buffer = vk::raii::Buffer(device, vk::BufferCreateInfo({}, whole_words(bytes), usage));
    const vk::MemoryRequirements needs = allocation.buffer.getMemoryRequirements();
    const bool has_address = static_cast<bool>(usage & vk::BufferUsageFlagBits::eShaderDeviceAddress);
    const vk::MemoryAllocateFlagsInfo flags(has_address ? vk::MemoryAllocateFlagBits::eDeviceAddress
                                                        : vk::MemoryAllocateFlags{});
    const vk::MemoryAllocateInfo allocate(needs.size, memory_type(needs.memoryTypeBits, host_visible),
                                          &flags);
    allocation.memory = vk::raii::DeviceMemory(device, allocate);
    allocation.buffer.bindMemory(*allocation.memory, 0);
    if (host_visible)
      allocation.mapped = static_cast<std::byte*>(allocation.memory.mapMemory(0, VK_WHOLE_SIZE));
    allocation.bytes = needs.size;
    allocated_bytes += needs.size;
    peak_allocated_bytes = std::max(peak_allocated_bytes, allocated_bytes);
    return allocation;
  } catch (const vk::SystemError& error) {
    if (error.code() == vk::Result::eErrorDeviceLost) throw_lost({}, 0);
    throw_out_of_memory(bytes, name);
  }
}

uint64_t DeviceState::device_heap_free() const {
  const uint32_t heap = memory.memoryTypes[memory_type(~0u, false)].heapIndex;
  if (has_memory_budget) {
    const auto chain = chosen.physical.getMemoryProperties2<vk::PhysicalDeviceMemoryProperties2,
                                                            vk::PhysicalDeviceMemoryBudgetPropertiesEXT>();
    const auto& budget = chain.get<vk::PhysicalDeviceMemoryBudgetPropertiesEXT>();
    return budget.heapBudget[heap] - std::min(budget.heapBudget[heap], budget.heapUsage[heap]);
  }
  const uint64_t size = memory.memoryHeaps[heap].size;
  return size - std::min(size, allocated_bytes);
}

uint64_t DeviceState::free_bytes() const {
  const uint64_t heap_free =
      std::min(device_heap_free(), memory_bytes - std::min(memory_bytes, allocated_bytes));
  // A software device shares the machine's memory with everything else that runs.
  if (info().kind == DeviceKind::Software) return std::min(heap_free, host_free_bytes() / 2);
  return heap_free;
}

}  // namespace regulus::gpu
