// The scene's triangles and copies in the device's own acceleration structure, for RAYS_HARDWARE.
#pragma once

#include <cstdint>
#include <vector>

#include "gpu/gpu.hpp"
#include "interface/wavefront.h"
#include "prepared/prepared_scene.hpp"

namespace regulus::render {

class SceneStructure {
 public:
  /// `vertices` are the scene's on the device, needed only here.
  /// @throws regulus::Error (Failed) if memory does not suffice or there are too many copies
  SceneStructure(gpu::Device& device, const PreparedScene& prepared, const gpu::Buffer& vertices);

  /// Writes its address in place of the tree's, and what its triangles are.
  void fill(interface::Frame& frame) const;

 private:
  void build_meshes(gpu::Device& device, const scene::Scene& scene, const gpu::Buffer& vertices);
  void build_placed(gpu::Device& device, const PreparedScene& prepared, const gpu::Buffer& vertices);

  std::vector<gpu::AccelerationStructure> meshes_;  // one for each shared mesh
  gpu::AccelerationStructure placed_, all_;
  gpu::Buffer placed_triangles_;
  uint32_t whole_ = 0, first_ = 0;
};

/// Triangles that stand for themselves and have no holes, in the device's own structure: for ray queries
/// without a scene around them.
class TriangleStructure {
 public:
  TriangleStructure() = default;
  TriangleStructure(gpu::Device& device, const std::vector<interface::BvhTriangle>& triangles);
  uint64_t address() const { return all_.address(); }

 private:
  gpu::AccelerationStructure triangles_, all_;
};

}  // namespace regulus::render
