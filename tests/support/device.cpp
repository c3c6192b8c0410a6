#include "support/device.hpp"

#include <cstdio>
#include <cstdlib>
#include <memory>

namespace regulus::test {

gpu::Device* device() {
  static const std::unique_ptr<gpu::Device> opened = []() -> std::unique_ptr<gpu::Device> {
    if (gpu::list_devices().empty()) return nullptr;
    const char* select = std::getenv("REGULUS_TEST_DEVICE");
    gpu::DeviceOptions options;
    options.select = select != nullptr ? select : "";
    auto result = std::make_unique<gpu::Device>(options);
    std::printf("device: %s (%s)\n", result->info().name.c_str(), result->info().driver.c_str());
    return result;
  }();
  return opened.get();
}

void run_batch(const gpu::Kernel& kernel, const BatchArguments& arguments) {
  constexpr uint32_t GROUP_SIZE = 64;
  gpu::CommandList commands(*device());
  commands.dispatch(kernel, gpu::bytes_of(arguments), (arguments.count + GROUP_SIZE - 1) / GROUP_SIZE);
  gpu::Submission submission = device()->submit(std::move(commands));
  device()->wait(submission);
}

bool is_slow_device() {
  // Under validation layers every command is checked on the host: there the layers are what is tested.
  return device()->info().name.find("SwiftShader") != std::string::npos ||
         std::getenv("VK_INSTANCE_LAYERS") != nullptr;
}

}  // namespace regulus::test
