// Scenes for `regulus bench kernels`: procedural ones, and the geometry of a file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bvh/bvh.hpp"
#include "interface/scene.h"

namespace regulus::cli {

struct BenchScene {
  std::string name;
  std::vector<bvh::InputTriangle> triangles;
  interface::Camera camera;
  glm::vec3 light;  ///< shadow rays end here
};

/// `hall`: a closed room with 512 spheres of 960 triangles. `boulder`: a rough ball of a million triangles in
/// a closed room. `terrain`: open hills of half a million triangles under a low light.
std::vector<BenchScene> procedural_bench_scenes();

/// The geometry of a glTF file, its first camera, and a light above the middle of its bounds.
/// @throws regulus::Error (BadFile)
BenchScene load_bench_scene(const std::filesystem::path& path);

}  // namespace regulus::cli
