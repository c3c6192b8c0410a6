// Scenes of image tests, loaded and with their acceleration structure: ready for a renderer or the reference.
#pragma once

#include <filesystem>
#include <string>

#include "image/image.hpp"
#include "images/support/gltf_scene.hpp"
#include "prepared/prepared_scene.hpp"
#include "scene/scene.hpp"

namespace regulus::test {

PreparedScene prepare(const std::filesystem::path& path, const scene::LoadOptions& options = {});
PreparedScene prepare(const GltfScene& scene, const scene::LoadOptions& options = {});
/// With a latitude-longitude map as environment, turned by `rotation` degrees.
PreparedScene prepare(GltfScene scene, const image::Image& environment, double rotation = 0);

/// An entry of scenes[0].extras.regulus_expected of a scene of ours.
nlohmann::json expected_of(const std::filesystem::path& gltf);

/// The folder of our own scenes and of the real assets.
std::filesystem::path own_scenes();
std::filesystem::path assets();

}  // namespace regulus::test
