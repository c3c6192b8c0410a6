// The Vulkan device layer: device choice, buffers, kernels, command lists with device time per stage.
// Knows nothing of rendering. Only the .cpp files of this folder include Vulkan headers.
//
// Everything is reached by buffer device address: a kernel has push constants and specialization constants,
// no descriptors.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace regulus::gpu {

enum class DeviceKind { Discrete, Integrated, Virtual, Other, Software };

/// What is known of a Vulkan device before it is opened.
struct DeviceInfo {
  uint32_t index = 0;  ///< as printed by `regulus devices`, accepted by --device
  std::string name;
  std::string uuid;    ///< 32 hexadecimal digits, as accepted by --device uuid:...; empty before Vulkan 1.2
  std::string driver;  ///< driver name and version text
  DeviceKind kind = DeviceKind::Other;
  uint32_t api_version = 0;          ///< VK_MAKE_API_VERSION encoding
  std::vector<std::string> missing;  ///< needed features and limits it lacks, one phrase each; empty: usable
  bool has_int64 = false;            ///< shaderInt64
  bool has_ray_query = false;        ///< VK_KHR_ray_query and what it needs: AccelerationStructure
  uint32_t subgroup_size = 0;
  uint64_t heap_bytes = 0;            ///< size of the largest device-local heap
  uint64_t max_allocation_bytes = 0;  ///< maxMemoryAllocationSize
  uint32_t max_workgroup_size = 0;
  uint32_t max_groups = 0;  ///< most groups of one dispatch
  double timestamp_ns = 0;  ///< nanoseconds per timestamp tick; 0: no device time
  bool usable() const { return missing.empty(); }
};

/// All Vulkan devices, in order of preference: discrete first, software last. Empty if there is no Vulkan
/// loader or no driver.
std::vector<DeviceInfo> list_devices();

/// What DeviceOptions::select is for each device that the text names: `all` (that can be used), or several
/// choices with commas between them. One choice is handed back as it is, whether there is such a device or
/// not. @throws regulus::Error (NoDevice) if one of several is unknown, ambiguous or given twice
std::vector<std::string> split_device_list(const std::string& text);

/// A buffer in device memory, freed with the object. Its contents are reached by `address()`. Precondition of
/// freeing it: no submission that uses it is in flight. The same holds for a Kernel.
class Buffer {
 public:
  Buffer();
  ~Buffer();
  Buffer(Buffer&&) noexcept;
  Buffer& operator=(Buffer&&) noexcept;

  uint64_t size() const;     ///< bytes
  uint64_t address() const;  ///< device address; 0 for an empty buffer
  /// The contents themselves on devices of DeviceKind::Software, whose memory is the host's; null on others
  /// and for an empty buffer. To be read and written while no submission that uses the buffer is in flight.
  std::byte* host() const;

  struct Impl;
  std::unique_ptr<Impl> impl;
};

/// What the device's own ray queries search: triangles, or copies of structures of triangles. Freed with the
/// object, under the precondition of Buffer. The structures that are copied must live as long.
class AccelerationStructure {
 public:
  AccelerationStructure();
  ~AccelerationStructure();
  AccelerationStructure(AccelerationStructure&&) noexcept;
  AccelerationStructure& operator=(AccelerationStructure&&) noexcept;

  uint64_t address() const;  ///< what kernels make an accelerationStructureEXT of; 0 if there is none

  struct Impl;
  std::unique_ptr<Impl> impl;
};

/// Triangles of a structure, all of one geometry index.
struct StructureTriangles {
  const Buffer& vertices;  ///< each begins with its position, three floats
  uint32_t vertex_bytes;
  std::span<const uint32_t> corners;  ///< vertices of the triangles, three each
  bool is_opaque;                     ///< queries take hits as they are; else each is put to the kernel
};

/// A copy of a structure of triangles.
struct StructureCopy {
  const AccelerationStructure& of;
  std::array<float, 12> to_world;  ///< three rows of a matrix of four columns
  uint32_t id;                     ///< what queries call it, below 2^24
  bool is_opaque;                  ///< its triangles are what they say; else none is
};

/// A compute pipeline.
class Kernel {
 public:
  Kernel();
  ~Kernel();
  Kernel(Kernel&&) noexcept;
  Kernel& operator=(Kernel&&) noexcept;

  struct Impl;
  std::unique_ptr<Impl> impl;
};

/// Description of a kernel. `constants` are (specialization id, value) pairs.
struct KernelDescription {
  std::string name;  ///< stage name for timings and errors
  std::span<const uint32_t> spirv;
  std::vector<std::pair<uint32_t, uint32_t>> constants;
};

/// Device time of one recorded dispatch.
struct StageTime {
  std::string stage;     ///< the kernel's name
  double device_ms = 0;  ///< 0 if not measured; the times of a submission do not overlap
};

/// A sequence of commands. A full compute-to-compute memory barrier stands between any two commands, unless
/// `independent()` was called before the second. The first command of a list waits for all earlier
/// submissions. Preconditions are checked by std::logic_error: offsets and push constants (at most 128 bytes)
/// are multiples of 4, ranges lie inside their buffers, groups do not exceed DeviceInfo::max_groups.
class CommandList {
 public:
  explicit CommandList(class Device& device);
  ~CommandList();
  CommandList(CommandList&&) noexcept;
  CommandList& operator=(CommandList&&) noexcept;

  void dispatch(const Kernel& kernel, std::span<const std::byte> push_constants, uint32_t groups);
  /// Group counts are the three words at `offset` of `buffer`.
  void dispatch_indirect(const Kernel& kernel, std::span<const std::byte> push_constants,
                         const Buffer& buffer, uint64_t offset);
  void fill(const Buffer& buffer, uint64_t offset, uint64_t bytes, uint32_t word);
  void copy(const Buffer& from, uint64_t from_offset, const Buffer& to, uint64_t to_offset, uint64_t bytes);
  /// The next command does not depend on the previous one: no barrier between them.
  void independent();

  struct Impl;
  std::unique_ptr<Impl> impl;
};

/// Commands that were handed to the device. Several may be in flight; they run in the order of submission.
/// The destructor waits for them.
class Submission {
 public:
  Submission();
  ~Submission();
  Submission(Submission&&) noexcept;
  Submission& operator=(Submission&&) noexcept;

  struct Impl;
  std::unique_ptr<Impl> impl;
};

/// What a driver tells of one of its executables for a kernel (VK_KHR_pipeline_executable_properties):
/// registers, spills, shared memory, under the driver's own names.
struct KernelStatistics {
  std::string kernel;      ///< the kernel's name
  std::string executable;  ///< the driver's name of it
  uint32_t subgroup_size = 0;
  std::vector<std::pair<std::string, double>> values;
};

struct DeviceOptions {
  std::string select;          ///< index, uuid:... or part of the name; empty: the first usable device
  bool pipeline_cache = true;  ///< keep compiled pipelines in the user's cache folder
  /// Measure the time of every dispatch on software devices too, where it costs lavapipe about 20 us a
  /// dispatch. Without, their times are 0; other devices are always timed, which costs them nearly nothing.
  bool software_stage_times = true;
  bool kernel_statistics = false;  ///< ask the driver for KernelStatistics, where it can tell them
  uint64_t memory_bytes = 0;       ///< most that is ever allocated; 0: what the device has
};

/// An opened device with one compute queue. Not thread-safe.
/// Errors are regulus::Error with ErrorCode::NoDevice (no usable device, device lost) or Failed (out of
/// memory); the message names the stage that ran when a device was lost.
class Device {
 public:
  explicit Device(const DeviceOptions& options = {});
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  const DeviceInfo& info() const;

  /// Device-local, zero-initialized memory, usable as storage, indirect arguments, and source or
  /// destination of copies. `bytes` may be 0.
  Buffer create_buffer(uint64_t bytes, std::string_view name);
  /// Blocking copies through staging memory, in pieces.
  void upload(const Buffer& buffer, uint64_t offset, std::span<const std::byte> data);
  void download(const Buffer& buffer, uint64_t offset, std::span<std::byte> data);

  /// Builds on the device and waits. Geometry indices are places in `geometries`, primitive indices places in
  /// their `corners`. Precondition: DeviceInfo::has_ray_query.
  AccelerationStructure build_structure(std::span<const StructureTriangles> geometries);
  AccelerationStructure build_structure(std::span<const StructureCopy> copies);

  Kernel create_kernel(const KernelDescription& description);
  /// The same for several at once, compiled by as many threads as the machine has; in the order of
  /// `descriptions`.
  std::vector<Kernel> create_kernels(std::span<const KernelDescription> descriptions);

  /// From now on `watch` is told how many of the kernels that are being compiled are done, first with 0: by
  /// whichever thread compiled one, one at a time. Kernels made before are not counted. Must not throw.
  void watch_kernels(std::function<void(size_t done, size_t total)> watch);

  Submission submit(CommandList&& commands);
  /// Blocks until the submission has run; returns the time of each dispatch, in recording order, once.
  std::vector<StageTime> wait(Submission& submission);

  uint64_t allocated_bytes() const;       ///< device memory held now
  uint64_t peak_allocated_bytes() const;  ///< the most ever held
  uint64_t free_bytes() const;            ///< estimate of what can still be allocated
  /// Of every kernel made so far; empty unless asked for and told.
  const std::vector<KernelStatistics>& kernel_statistics() const;
  double pipeline_seconds() const;  ///< time that went by while pipelines were made

  struct Impl;
  std::unique_ptr<Impl> impl;
};

/// Bytes of a trivially copyable value or contiguous range, for push constants and uploads.
template <typename T>
std::span<const std::byte> bytes_of(const T& value) {
  return std::as_bytes(std::span<const T, 1>(&value, 1));
}
template <typename T>
std::span<const std::byte> bytes_of(const std::vector<T>& values) {
  return std::as_bytes(std::span<const T>(values));
}

/// A buffer filled with `values`.
template <typename T>
Buffer upload_new(Device& device, const std::vector<T>& values, std::string_view name) {
  Buffer buffer = device.create_buffer(values.size() * sizeof(T), name);
  if (!values.empty()) device.upload(buffer, 0, bytes_of(values));
  return buffer;
}

/// The first `count` values of type T from byte `offset` of a buffer.
template <typename T>
std::vector<T> download_all(Device& device, const Buffer& buffer, size_t count, uint64_t offset = 0) {
  std::vector<T> values(count);
  if (count > 0) device.download(buffer, offset, std::as_writable_bytes(std::span<T>(values)));
  return values;
}

}  // namespace regulus::gpu
