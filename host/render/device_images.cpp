#include "render/device_images.hpp"

namespace regulus::render {
namespace {

uint64_t bytes_of(const std::vector<uint32_t>& words) {
  return words.size() * sizeof(uint32_t);
}

}  // namespace

uint64_t texture_bytes(const scene::Scene& scene) {
  uint64_t bytes = scene.textures.size() * sizeof(interface::Texture);
  for (const auto& image : scene.images) bytes += bytes_of(image);
  return bytes;
}

std::vector<gpu::Buffer> upload_images(gpu::Device& device, const std::vector<std::vector<uint32_t>>& images,
                                       uint64_t largest_bytes, std::vector<interface::Texture>& textures) {
  std::vector<gpu::Buffer> buffers;
  std::vector<uint64_t> addresses;
  while (addresses.size() < images.size()) {
    const size_t first = addresses.size();
    size_t end = first + 1;
    uint64_t bytes = bytes_of(images[first]);
    for (; end < images.size() && bytes + bytes_of(images[end]) <= largest_bytes; ++end)
      bytes += bytes_of(images[end]);
    buffers.push_back(device.create_buffer(bytes, "texels"));
    uint64_t offset = 0;
    for (size_t i = first; i < end; ++i) {
      device.upload(buffers.back(), offset, gpu::bytes_of(images[i]));
      addresses.push_back(buffers.back().address() + offset);
      offset += bytes_of(images[i]);
    }
  }
  for (interface::Texture& texture : textures)
    texture.texels = interface::device_address(addresses.at(texture.image));
  return buffers;
}

}  // namespace regulus::render
