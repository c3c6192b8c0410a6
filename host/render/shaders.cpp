#include "render/shaders.hpp"

#include <string>

namespace regulus::render {

std::span<const uint32_t> stage_spirv(const gpu::Device& device, std::string_view stage) {
  return shaders::spirv(std::string(stage) + (device.info().has_int64 ? "" : ".int32"));
}

}  // namespace regulus::render
