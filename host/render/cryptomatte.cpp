#include "render/cryptomatte.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <nlohmann/json.hpp>
#include <set>

#include "interface/wavefront.h"
#include "render/settings.hpp"

namespace regulus::render {

namespace {

using interface::AOV_RAYS;
using interface::INVALID_INDEX;

constexpr size_t LEVELS = 3;  // files' layers, of two ids each
constexpr const char* OBJECTS = "CryptoObject";
constexpr const char* MATERIALS = "CryptoMaterial";

/// By index of what has ids.
using Strings = std::vector<std::string>;

std::string material_name(const scene::Scene& scene, size_t index) {
  const bool has_name = index < scene.material_names.size() && !scene.material_names[index].empty();
  return has_name ? scene.material_names[index] : fmt::format("material {}", index);
}

Strings material_names(const scene::Scene& scene) {
  Strings names;
  for (size_t i = 0; i < scene.materials.size(); ++i) names.push_back(material_name(scene, i));
  return names;
}

Strings node_names(const scene::Scene& scene) {
  Strings names;
  for (const scene::SceneNode& node : scene.nodes) names.push_back(node.name);
  return names;
}

std::vector<float> ids_of(const Strings& names) {
  std::vector<float> ids;
  for (const std::string& name : names) ids.push_back(cryptomatte_id(name));
  return ids;
}

/// What a ray meets, or INVALID_INDEX.
uint32_t node_of(const scene::Scene& scene, const RayIds& ids) {
  return ids.instance < scene.place_nodes.size() ? scene.place_nodes[ids.instance] : INVALID_INDEX;
}

struct Share {
  float id;
  uint32_t rays;
};

/// Ids with the most rays first, then by their bits.
std::vector<Share> rank(const std::array<float, AOV_RAYS>& ids, size_t count) {
  std::vector<Share> shares;
  for (size_t i = 0; i < count; ++i) {
    const auto found = std::ranges::find(shares, ids[i], &Share::id);
    if (found == shares.end())
      shares.push_back({ids[i], 1});
    else
      ++found->rays;
  }
  std::ranges::sort(shares, [](const Share& a, const Share& b) {
    return a.rays != b.rays ? a.rays > b.rays : std::bit_cast<uint32_t>(a.id) < std::bit_cast<uint32_t>(b.id);
  });
  return shares;
}

template <typename IndexOf>
void add_matte(const char* name, const std::vector<float>& ids, const std::vector<RayIds>& rays,
               const IndexOf& index_of, image::Channels& channels) {
  const size_t pixels = rays.size() / AOV_RAYS;
  std::array<std::vector<float>, 4 * LEVELS> planes;
  planes.fill(std::vector<float>(pixels, 0.0F));
  for (size_t pixel = 0; pixel < pixels; ++pixel) {
    std::array<float, AOV_RAYS> met{};
    size_t count = 0;
    for (size_t ray = 0; ray < AOV_RAYS; ++ray) {
      const uint32_t index = index_of(rays[pixel * AOV_RAYS + ray]);
      if (index < ids.size()) met[count++] = ids[index];
    }
    const std::vector<Share> shares = rank(met, count);
    for (size_t i = 0; i < std::min(shares.size(), 2 * LEVELS); ++i) {
      planes[2 * i][pixel] = shares[i].id;
      planes[2 * i + 1][pixel] = static_cast<float>(shares[i].rays) / float{AOV_RAYS};
    }
  }
  for (size_t i = 0; i < planes.size(); ++i)
    channels[fmt::format("{}{:02}.{}", name, i / 4, "RGBA"[i % 4])] = std::move(planes[i]);
}

void add_entries(const char* name, const std::set<std::string>& members, image::Attributes& attributes) {
  nlohmann::json manifest = nlohmann::json::object();
  for (const std::string& member : members)
    manifest[member] = fmt::format("{:08x}", std::bit_cast<uint32_t>(cryptomatte_id(member)));
  const std::string prefix =
      fmt::format("cryptomatte/{}/", fmt::format("{:08x}", murmur3(name)).substr(0, 7));
  attributes[prefix + "name"] = name;
  attributes[prefix + "hash"] = "MurmurHash3_32";
  attributes[prefix + "conversion"] = "uint32_to_float32";
  attributes[prefix + "manifest"] = manifest.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

uint32_t murmur3(std::string_view bytes) {
  constexpr uint32_t C1 = 0xcc9e2d51, C2 = 0x1b873593;
  const auto mixed = [](uint32_t block) { return std::rotl(block * C1, 15) * C2; };
  uint32_t hash = 0;
  size_t i = 0;
  const auto byte = [&](size_t index) { return uint32_t{static_cast<unsigned char>(bytes[index])}; };
  for (; i + 4 <= bytes.size(); i += 4) {
    const uint32_t block = byte(i) | byte(i + 1) << 8 | byte(i + 2) << 16 | byte(i + 3) << 24;
    hash = std::rotl(hash ^ mixed(block), 13) * 5 + 0xe6546b64;
  }
  uint32_t tail = 0;
  for (size_t k = bytes.size(); k-- > i;) tail = tail << 8 | byte(k);
  hash ^= mixed(tail);
  hash ^= static_cast<uint32_t>(bytes.size());
  hash = (hash ^ hash >> 16) * 0x85ebca6b;
  hash = (hash ^ hash >> 13) * 0xc2b2ae35;
  return hash ^ hash >> 16;
}

float cryptomatte_id(std::string_view name) {
  uint32_t hash = murmur3(name);
  const uint32_t exponent = hash >> 23 & 0xFF;
  if (exponent == 0 || exponent == 0xFF) hash ^= 1U << 23;
  return std::bit_cast<float>(hash);
}

void add_cryptomattes(const scene::Scene& scene, const std::vector<RayIds>& rays, uint32_t aovs,
                      image::Channels& channels) {
  if ((aovs & AOV_CRYPTO_OBJECT) != 0)
    add_matte(
        OBJECTS, ids_of(node_names(scene)), rays, [&](const RayIds& ids) { return node_of(scene, ids); },
        channels);
  if ((aovs & AOV_CRYPTO_MATERIAL) != 0)
    add_matte(
        MATERIALS, ids_of(material_names(scene)), rays, [](const RayIds& ids) { return ids.material; },
        channels);
}

void add_cryptomatte_attributes(const scene::Scene& scene, uint32_t aovs, image::Attributes& attributes) {
  if ((aovs & AOV_CRYPTO_OBJECT) != 0) {
    const std::set<uint32_t> shown(scene.place_nodes.begin(), scene.place_nodes.end());
    std::set<std::string> names;
    for (const uint32_t node : shown)
      if (node < scene.nodes.size()) names.insert(scene.nodes[node].name);
    add_entries(OBJECTS, names, attributes);
  }
  if ((aovs & AOV_CRYPTO_MATERIAL) != 0) {
    const Strings names = material_names(scene);
    add_entries(MATERIALS, {names.begin(), names.end()}, attributes);
  }
}

}  // namespace regulus::render
