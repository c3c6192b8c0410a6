// What a scene file refers to, whether it is read or not: files that no output may replace.
#pragma once

#include <filesystem>
#include <vector>

namespace regulus::scene {

/// The files that the URIs of a .gltf or .glb file name, and the environment maps of its scenes, as they are
/// written there: they need not exist. Precondition: `scene_file` has been loaded; of one that is no glTF
/// there are none.
std::vector<std::filesystem::path> referenced_files(const std::filesystem::path& scene_file);

}  // namespace regulus::scene
