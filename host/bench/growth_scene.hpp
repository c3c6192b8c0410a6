// The scenes of `bench growth`: hills of so many triangles under so many lamps, with so many stones.
#pragma once

#include <cstdint>
#include <filesystem>

#include "scene/scene.hpp"

namespace regulus::bench {

struct GrowthScene {
  uint64_t triangles = 2000;  ///< of the hills, to the next 2 k^2
  uint64_t lights = 1;        ///< emissive triangles, which have 12 W/(m^2 sr) over all their area together
  uint64_t instances = 0;     ///< stones, copies of one mesh of 8 triangles
  bool is_closed = false;     ///< walls and a ceiling keep the light in, the camera stands inside
};

/// Writes the scene as glTF into `folder`. Metres: hills of 12 x 12, up to 1 high, lamps 4 above them; walls
/// and hills have an albedo of 0.6, those of a closed scene 0.9.
std::filesystem::path write_growth_scene(const GrowthScene& what, const std::filesystem::path& folder);

/// Reads it back; stones are shared.
scene::Scene load_growth_scene(const std::filesystem::path& file);

}  // namespace regulus::bench
