// The images of textures in device memory.
#pragma once

#include <cstdint>
#include <vector>

#include "gpu/gpu.hpp"
#include "scene/scene.hpp"

namespace regulus::render {

/// Bytes of the scene's textures on a device.
uint64_t texture_bytes(const scene::Scene& scene);

/// Uploads the images, one after the other, into buffers of at most `largest_bytes` (or of one image that is
/// larger), and writes into each of the textures where its texels are.
std::vector<gpu::Buffer> upload_images(gpu::Device& device, const std::vector<std::vector<uint32_t>>& images,
                                       uint64_t largest_bytes, std::vector<interface::Texture>& textures);

}  // namespace regulus::render
