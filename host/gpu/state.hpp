// What stands behind the handles of gpu.hpp. Internal to host/gpu.
//
// Every handle shares ownership of the device's state, so handles may be destroyed in any order.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "gpu/gpu.hpp"
#include "gpu/instance.hpp"
#include "gpu/pipeline_cache.hpp"

namespace regulus::gpu {

/// Fills write whole words, so a buffer's memory is a whole number of them.
constexpr uint64_t whole_words(uint64_t bytes) {
  return (bytes + 3) & ~uint64_t{3};
}

/// A Vulkan buffer with memory of its own.
struct Allocation {
  vk::raii::DeviceMemory memory{nullptr};
  vk::raii::Buffer buffer{nullptr};
  uint64_t bytes = 0;  ///< of the memory
  std::byte* mapped =
      nullptr;  ///< only for host-visible memory that was asked for; always on software devices
};

/// What one command list needs of Vulkan. Used again for the next list, because making it costs more than
/// recording.
struct Recording {
  vk::raii::CommandBuffer commands{nullptr};
  vk::raii::Fence fence{nullptr};
  std::vector<vk::raii::QueryPool> timestamps;
};

/// A dispatch whose time is asked for: names two timestamps.
struct TimedStage {
  uint32_t begin = 0;
  uint32_t end = 0;
};

struct DeviceState {
  explicit DeviceState(const DeviceOptions& options);

  std::shared_ptr<Instance> instance;
  Candidate chosen;
  bool has_memory_budget = false;
  bool measures_time = false;     ///< around every dispatch
  bool tells_statistics = false;  ///< the driver tells KernelStatistics, and they are wanted
  uint64_t memory_bytes = 0;      ///< most that is ever allocated
  vk::PhysicalDeviceMemoryProperties memory;
  vk::raii::Device device{nullptr};
  vk::raii::Queue queue{nullptr};
  vk::raii::CommandPool pool{nullptr};
  vk::raii::PipelineLayout layout{nullptr};  ///< push constants only, the same for every kernel
  std::vector<std::unique_ptr<Recording>> idle;
  /// By kernel_key: a kernel asked for again, by the next render on this device, is not compiled again.
  std::map<uint64_t, std::shared_ptr<vk::raii::Pipeline>> pipelines;
  Allocation staging;                  ///< made at the first copy between host and device
  std::filesystem::path cache_folder;  ///< empty: no pipeline cache
  DriverIdentity driver;
  bool has_new_pipelines = false;
  uint64_t allocated_bytes = 0;
  uint64_t peak_allocated_bytes = 0;
  double pipeline_seconds = 0;
  std::function<void(size_t done, size_t total)> kernel_watcher;  // may be empty
  std::vector<KernelStatistics> kernel_statistics;
  bool is_lost = false;

  const DeviceInfo& info() const { return chosen.info; }

  /// An idle recording or a new one, its command buffer begun.
  std::unique_ptr<Recording> begin_recording();

  /// Allocates whole words and binds them; throws Error (Failed) naming the buffer when there is no room.
  Allocation allocate(uint64_t bytes, vk::BufferUsageFlags usage, bool host_visible, std::string_view name);
  void release(const Allocation& allocation) { allocated_bytes -= allocation.bytes; }
  uint64_t free_bytes() const;

  /// Remembers that the device is gone and throws Error (NoDevice). See lost_message() for `completed`.
  [[noreturn]] void throw_lost(std::span<const std::string> stages, int completed);

 private:
  uint32_t memory_type(uint32_t allowed_types, bool host_visible) const;
  uint64_t device_heap_free() const;
  [[noreturn]] void throw_out_of_memory(uint64_t bytes, std::string_view name) const;
};

struct Buffer::Impl {
  std::shared_ptr<DeviceState> state;
  std::string name;
  uint64_t size = 0;
  uint64_t address = 0;
  Allocation allocation;

  ~Impl() { state->release(allocation); }
};

/// The Vulkan buffer; throws std::logic_error unless bytes [offset, offset + bytes) lie inside.
vk::Buffer checked_range(const Buffer& buffer, uint64_t offset, uint64_t bytes);

struct AccelerationStructure::Impl {
  std::shared_ptr<DeviceState> state;
  Allocation storage;
  vk::raii::AccelerationStructureKHR handle{nullptr};
  uint64_t address = 0;

  ~Impl() { state->release(storage); }
};

struct Kernel::Impl {
  std::shared_ptr<DeviceState> state;
  std::string name;
  std::shared_ptr<vk::raii::Pipeline> pipeline;
};

struct CommandList::Impl {
  explicit Impl(std::shared_ptr<DeviceState> device);
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl();

  std::shared_ptr<DeviceState> state;
  std::unique_ptr<Recording> recording;
  std::vector<std::string> stages;
  std::vector<TimedStage> times;  ///< parallel to `stages`; empty without timestamps
  uint32_t timestamps = 0;
  bool ended_with_timestamp = false;  ///< the last command was followed by one
  bool is_empty = true;
  bool next_is_independent = false;

  /// Everything of a dispatch but the dispatch itself, which comes between the two.
  void begin_dispatch(const Kernel& kernel, std::span<const std::byte> push_constants);
  void end_dispatch(const Kernel& kernel);
  void copy(vk::Buffer from, uint64_t from_offset, vk::Buffer to, uint64_t to_offset, uint64_t bytes);
  /// Makes everything written so far visible to the host once the fence is signalled.
  void publish_to_host();
  /// Comes before every command that is not a dispatch.
  void begin_transfer();

 private:
  void order_after_previous();
  uint32_t write_timestamp();
};

struct Submission::Impl {
  std::shared_ptr<DeviceState> state;
  std::unique_ptr<Recording> recording;
  std::vector<std::string> stages;
  std::vector<TimedStage> times;
  uint32_t timestamps = 0;

  /// Waits for the device if nobody did, since the recording is in use until then.
  ~Impl();
  void wait();
  std::vector<StageTime> stage_times() const;

 private:
  int completed_stages() const;
};

struct Device::Impl {
  std::shared_ptr<DeviceState> state;
};

}  // namespace regulus::gpu
