// Two overlapping fills of one buffer without a barrier: a hazard that synchronization validation must
// report. tests/support/run-on-drivers runs this first and trusts the silence of the layers only if this
// program was stopped.
#include <bit>
#include <cstdio>
#include <vulkan/vulkan_raii.hpp>

namespace {

void provoke_write_after_write() {
  const vk::raii::Context context;
  const vk::ApplicationInfo application("validation_control", 0, nullptr, 0, VK_API_VERSION_1_2);
  const vk::raii::Instance instance(context, vk::InstanceCreateInfo({}, &application));
  const vk::raii::PhysicalDevice physical = vk::raii::PhysicalDevices(instance).front();
  const float priority = 1;
  const vk::DeviceQueueCreateInfo queue_info({}, 0, 1, &priority);
  const vk::raii::Device device(physical, vk::DeviceCreateInfo({}, queue_info));

  const vk::raii::Buffer buffer(device, vk::BufferCreateInfo({}, 256, vk::BufferUsageFlagBits::eTransferDst));
  const vk::MemoryRequirements needs = buffer.getMemoryRequirements();
  const auto first_type = static_cast<uint32_t>(std::countr_zero(needs.memoryTypeBits));
  const vk::raii::DeviceMemory memory(device, vk::MemoryAllocateInfo(needs.size, first_type));
  buffer.bindMemory(*memory, 0);

  const vk::raii::CommandPool pool(device, vk::CommandPoolCreateInfo({}, 0));
  const vk::raii::CommandBuffers buffers(
      device, vk::CommandBufferAllocateInfo(*pool, vk::CommandBufferLevel::ePrimary, 1));
  const vk::raii::CommandBuffer& commands = buffers.front();
  commands.begin(vk::CommandBufferBeginInfo());
  commands.fillBuffer(*buffer, 0, 256, 1);
  commands.fillBuffer(*buffer, 0, 256, 2);
  commands.end();
}

}  // namespace

int main() {
  provoke_write_after_write();
  std::puts("validation_control: the hazard was not reported");
  return 0;
}
