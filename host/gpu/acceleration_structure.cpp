// Structures for the device's own ray queries, built on the device.
#include <stdexcept>

#include "gpu/state.hpp"

namespace regulus::gpu {
namespace {

using Access = vk::AccessFlagBits;
using Stage = vk::PipelineStageFlagBits;
using Type = vk::AccelerationStructureTypeKHR;

constexpr const char* NAME = "acceleration structure of hardware rays";

/// Builds in order with everything around it on the queue, and waits.
void run_build(Device& device, const vk::AccelerationStructureBuildGeometryInfoKHR& build,
               const std::vector<vk::AccelerationStructureBuildRangeInfoKHR>& ranges) {
  CommandList list(device);
  const vk::raii::CommandBuffer& commands = list.impl->recording->commands;
  commands.pipelineBarrier(Stage::eTransfer | Stage::eComputeShader, Stage::eAccelerationStructureBuildKHR,
                           {},
                           vk::MemoryBarrier(Access::eTransferWrite | Access::eShaderWrite,
                                             Access::eShaderRead | Access::eAccelerationStructureReadKHR |
                                                 Access::eAccelerationStructureWriteKHR),
                           {}, {});
  commands.buildAccelerationStructuresKHR(build, ranges.data());
  commands.pipelineBarrier(
      Stage::eAccelerationStructureBuildKHR, Stage::eAccelerationStructureBuildKHR | Stage::eComputeShader,
      {}, vk::MemoryBarrier(Access::eAccelerationStructureWriteKHR, Access::eAccelerationStructureReadKHR),
      {}, {});
  Submission submission = device.submit(std::move(list));
  device.wait(submission);
}

/// counts: primitives of each geometry.
AccelerationStructure build(Device& device, Type type,
                            const std::vector<vk::AccelerationStructureGeometryKHR>& geometries,
                            const std::vector<uint32_t>& counts) {
  const std::shared_ptr<DeviceState>& state = device.impl->state;
  vk::AccelerationStructureBuildGeometryInfoKHR info(
      type, vk::BuildAccelerationStructureFlagBitsKHR::ePreferFastTrace);
  info.setGeometries(geometries);
  const vk::AccelerationStructureBuildSizesInfoKHR sizes =
      state->device.getAccelerationStructureBuildSizesKHR(vk::AccelerationStructureBuildTypeKHR::eDevice,
                                                          info, counts);
  AccelerationStructure structure;
  structure.impl.reset(new AccelerationStructure::Impl{
      state, state->allocate(sizes.accelerationStructureSize,
                             vk::BufferUsageFlagBits::eAccelerationStructureStorageKHR |
                                 vk::BufferUsageFlagBits::eShaderDeviceAddress,
                             false, NAME)});
  structure.impl->handle = vk::raii::AccelerationStructureKHR(
      state->device, {{}, *structure.impl->storage.buffer, 0, sizes.accelerationStructureSize, type});
  structure.impl->address = state->device.getAccelerationStructureAddressKHR({*structure.impl->handle});

  const uint64_t alignment = state->chosen.scratch_alignment;
  const Buffer scratch =
      device.create_buffer(sizes.buildScratchSize + alignment, "building of acceleration structures");
  info.setDstAccelerationStructure(*structure.impl->handle);
  info.setScratchData((scratch.address() + alignment - 1) / alignment * alignment);
  std::vector<vk::AccelerationStructureBuildRangeInfoKHR> ranges;
  ranges.reserve(counts.size());
  for (const uint32_t count : counts) ranges.emplace_back(count);
  run_build(device, info, ranges);
  return structure;
}

vk::GeometryFlagsKHR flags_of(bool is_opaque) {
  return is_opaque ? vk::GeometryFlagBitsKHR::eOpaque : vk::GeometryFlagsKHR{};
}

vk::AccelerationStructureInstanceKHR instance_of(const StructureCopy& copy) {
  vk::AccelerationStructureInstanceKHR instance;
  for (size_t i = 0; i < copy.to_world.size(); ++i)
    instance.transform.matrix[i / 4][i % 4] = copy.to_world[i];
  instance.setInstanceCustomIndex(copy.id).setMask(0xFF).setAccelerationStructureReference(copy.of.address());
  vk::GeometryInstanceFlagsKHR flags = vk::GeometryInstanceFlagBitsKHR::eTriangleFacingCullDisable;
  if (!copy.is_opaque) flags |= vk::GeometryInstanceFlagBitsKHR::eForceNoOpaque;
  instance.setFlags(flags);
  return instance;
}

}  // namespace

AccelerationStructure::AccelerationStructure() = default;
AccelerationStructure::~AccelerationStructure() = default;
AccelerationStructure::AccelerationStructure(AccelerationStructure&&) noexcept = default;
AccelerationStructure& AccelerationStructure::operator=(AccelerationStructure&&) noexcept = default;
uint64_t AccelerationStructure::address() const {
  return impl ? impl->address : 0;
}

AccelerationStructure Device::build_structure(std::span<const StructureTriangles> triangles) {
  std::vector<Buffer> corners;
  std::vector<vk::AccelerationStructureGeometryKHR> geometries;
  std::vector<uint32_t> counts;
  for (const StructureTriangles& one : triangles) {
    corners.push_back(create_buffer(one.corners.size_bytes(), "corners of hardware rays"));
    upload(corners.back(), 0, std::as_bytes(one.corners));
    const auto vertices = static_cast<uint32_t>(one.vertices.size() / one.vertex_bytes);
    const vk::AccelerationStructureGeometryTrianglesDataKHR data(
        vk::Format::eR32G32B32Sfloat, one.vertices.address(), one.vertex_bytes, vertices - 1,
        vk::IndexType::eUint32, corners.back().address());
    geometries.emplace_back(vk::GeometryTypeKHR::eTriangles, data, flags_of(one.is_opaque));
    counts.push_back(static_cast<uint32_t>(one.corners.size() / 3));
  }
  return build(*this, Type::eBottomLevel, geometries, counts);
}

AccelerationStructure Device::build_structure(std::span<const StructureCopy> copies) {
  std::vector<vk::AccelerationStructureInstanceKHR> instances;
  instances.reserve(copies.size());
  for (const StructureCopy& copy : copies) instances.push_back(instance_of(copy));
  const Buffer records = upload_new(*this, instances, "copies of hardware rays");
  const vk::AccelerationStructureGeometryInstancesDataKHR data(false, records.address());
  return build(*this, Type::eTopLevel, {{vk::GeometryTypeKHR::eInstances, data}},
               {static_cast<uint32_t>(copies.size())});
}

}  // namespace regulus::gpu
