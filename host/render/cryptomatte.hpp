// Cryptomattes: which objects and materials a pixel shows, and how much of each (Friedman and Jones, "Fully
// automatic ID mattes with support for motion blur and transparency", 2015; Psyop's specification 1.2.0).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "image/image.hpp"
#include "scene/scene.hpp"

namespace regulus::render {

/// MurmurHash3_x86_32 of the bytes (Austin Appleby, public domain), seed 0.
uint32_t murmur3(std::string_view bytes);

/// The hash of a name as a cryptomatte's id: its bits but for one that is flipped where they would be a
/// denormal number, an infinity or none.
float cryptomatte_id(std::string_view name);

/// What each of the first rays of a pixel meets.
struct RayIds {
  uint32_t instance;  ///< place of a mesh, see interface::Triangle; INVALID_INDEX: nothing
  uint32_t material;  ///< index; INVALID_INDEX: nothing
};

/// Channels CryptoObject00.R ... and CryptoMaterial00.R ... of those CRYPTO_AOVS that `aovs` asks for: in R
/// and B the ids that most rays of the pixel meet, in descending order, in G and A their shares of all rays;
/// six of each, 0 where there are fewer. Objects are nodes with a mesh: copies of one node are one object.
/// @param rays interface::AOV_RAYS of each pixel, one pixel after the other
void add_cryptomattes(const scene::Scene& scene, const std::vector<RayIds>& rays, uint32_t aovs,
                      image::Channels& channels);

/// The header's entries that name them: cryptomatte/KEY/name, hash, conversion and manifest, of all nodes
/// with a mesh and all materials.
void add_cryptomatte_attributes(const scene::Scene& scene, uint32_t aovs, image::Attributes& attributes);

}  // namespace regulus::render
