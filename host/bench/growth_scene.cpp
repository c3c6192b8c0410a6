#include "bench/growth_scene.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <vector>

namespace regulus::bench {
namespace {

using Json = nlohmann::json;

constexpr double EXTENT = 12, LAMP_HEIGHT = 4;

/// A mesh that grows, and the buffer of all that were written.
class File {
 public:
  File() {
    gltf_ = {{"asset", {{"version", "2.0"}}}, {"scene", 0}};
    for (const char* list : {"nodes", "meshes", "accessors", "bufferViews"}) gltf_[list] = Json::array();
  }

  uint32_t point(const glm::vec3& position) {
    positions_.push_back(position);
    return static_cast<uint32_t>(positions_.size() - 1);
  }
  void triangle(uint32_t a, uint32_t b, uint32_t c) { corners_.insert(corners_.end(), {a, b, c}); }

  /// The index of a mesh of what has come since the last.
  size_t mesh(int material) {
    glm::vec3 low = positions_.front(), high = low;
    for (const glm::vec3& position : positions_) {
      low = glm::min(low, position);
      high = glm::max(high, position);
    }
    constexpr int FLOAT = 5126, UNSIGNED_INT = 5125;
    const size_t points = accessor(positions_, FLOAT, "VEC3", positions_.size());
    gltf_["accessors"].back()["min"] = {low.x, low.y, low.z};
    gltf_["accessors"].back()["max"] = {high.x, high.y, high.z};
    const size_t corners = accessor(corners_, UNSIGNED_INT, "SCALAR", corners_.size());
    gltf_["meshes"].push_back(
        {{"primitives",
          {{{"attributes", {{"POSITION", points}}}, {"indices", corners}, {"material", material}}}}});
    positions_.clear();
    corners_.clear();
    return gltf_["meshes"].size() - 1;
  }
  void node(Json node) { gltf_["nodes"].push_back(std::move(node)); }
  Json& gltf() { return gltf_; }

  std::filesystem::path write(const std::filesystem::path& folder) {
    Json nodes = Json::array();
    for (size_t i = 0; i < gltf_["nodes"].size(); ++i) nodes.push_back(i);
    gltf_["scenes"] = {{{"nodes", nodes}}};
    gltf_["buffers"] = {{{"byteLength", bytes_.size()}, {"uri", "growth.bin"}}};
    std::ofstream(folder / "growth.bin", std::ios::binary)
        .write(bytes_.data(), static_cast<std::streamsize>(bytes_.size()));
    std::ofstream(folder / "growth.gltf") << gltf_;
    return folder / "growth.gltf";
  }

 private:
  template <typename T>
  size_t accessor(const std::vector<T>& values, int component, const char* type, size_t count) {
    const size_t bytes = values.size() * sizeof(T);
    gltf_["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", bytes}});
    const auto* begin = reinterpret_cast<const char*>(values.data());
    bytes_.insert(bytes_.end(), begin, begin + bytes);
    gltf_["accessors"].push_back({{"bufferView", gltf_["bufferViews"].size() - 1},
                                  {"componentType", component},
                                  {"count", count},
                                  {"type", type}});
    return gltf_["accessors"].size() - 1;
  }

  Json gltf_;
  std::vector<char> bytes_;
  std::vector<glm::vec3> positions_;
  std::vector<uint32_t> corners_;
};

double height_at(double x, double z) {
  return 0.5 + 0.3 * std::sin(1.7 * x) * std::cos(1.3 * z) +
         0.2 * std::sin(4.1 * x + 0.5) * std::sin(3.7 * z);
}

void add_hills(File& file, uint64_t triangles) {
  const auto side =
      static_cast<uint32_t>(std::max(1.0, std::round(std::sqrt(static_cast<double>(triangles) / 2))));
  for (uint32_t row = 0; row <= side; ++row)
    for (uint32_t column = 0; column <= side; ++column) {
      const double x = EXTENT * (static_cast<double>(column) / side - 0.5);
      const double z = EXTENT * (static_cast<double>(row) / side - 0.5);
      file.point(glm::vec3(x, height_at(x, z), z));
    }
  for (uint32_t row = 0; row < side; ++row)
    for (uint32_t column = 0; column < side; ++column) {
      const uint32_t corner = row * (side + 1) + column, below = corner + side + 1;
      file.triangle(corner, below, corner + 1);
      file.triangle(corner + 1, below, below + 1);
    }
  file.node({{"mesh", file.mesh(0)}});
}

/// On a square grid, facing down.
void add_lamps(File& file, uint64_t lights) {
  const double side = std::ceil(std::sqrt(static_cast<double>(lights)));
  const double size = 1 / std::sqrt(static_cast<double>(lights));  // metres
  for (uint64_t i = 0; i < lights; ++i) {
    const double x = EXTENT * ((std::fmod(static_cast<double>(i), side) + 0.5) / side - 0.5);
    const double z = EXTENT * ((std::floor(static_cast<double>(i) / side) + 0.5) / side - 0.5);
    const uint32_t a = file.point(glm::vec3(x, LAMP_HEIGHT, z)),
                   b = file.point(glm::vec3(x + size, LAMP_HEIGHT, z)),
                   c = file.point(glm::vec3(x, LAMP_HEIGHT, z + size));
    file.triangle(a, b, c);
  }
  file.node({{"mesh", file.mesh(1)}});
}

/// Four walls and a ceiling.
void add_room(File& file) {
  constexpr double HALF = EXTENT / 2, TOP = LAMP_HEIGHT + 1;
  for (int corner = 0; corner < 8; ++corner)
    file.point(glm::vec3((corner & 1) != 0 ? HALF : -HALF, (corner & 2) != 0 ? TOP : 0,
                         (corner & 4) != 0 ? HALF : -HALF));
  const uint32_t faces[][4] = {{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 4, 6, 2}, {1, 5, 7, 3}, {2, 3, 7, 6}};
  for (const auto& face : faces) {
    file.triangle(face[0], face[1], face[2]);
    file.triangle(face[0], face[2], face[3]);
  }
  file.node({{"mesh", file.mesh(0)}});
}

/// Octahedra on the hills.
void add_stones(File& file, uint64_t stones) {
  if (stones == 0) return;
  for (int axis = 0; axis < 3; ++axis)
    for (const float sign : {1.0F, -1.0F}) {
      glm::vec3 tip(0);
      tip[axis] = sign;
      file.point(tip);
    }
  for (const uint32_t x : {0u, 1u})
    for (const uint32_t y : {2u, 3u})
      for (const uint32_t z : {4u, 5u})
        if ((x + y + z) % 2 == 0)
          file.triangle(x, y, z);
        else
          file.triangle(x, z, y);
  const size_t mesh = file.mesh(0);
  const double side = std::ceil(std::sqrt(static_cast<double>(stones))), size = 0.3 * EXTENT / side;
  for (uint64_t i = 0; i < stones; ++i) {
    const double x = EXTENT * ((std::fmod(static_cast<double>(i), side) + 0.5) / side - 0.5);
    const double z = EXTENT * ((std::floor(static_cast<double>(i) / side) + 0.5) / side - 0.5);
    file.node({{"mesh", mesh}, {"translation", {x, height_at(x, z), z}}, {"scale", {size, size, size}}});
  }
}

}  // namespace

std::filesystem::path write_growth_scene(const GrowthScene& what, const std::filesystem::path& folder) {
  File file;
  const double albedo = what.is_closed ? 0.9 : 0.6;
  file.gltf()["materials"] = {
      {{"pbrMetallicRoughness",
        {{"baseColorFactor", {albedo, albedo, albedo, 1}}, {"metallicFactor", 0}, {"roughnessFactor", 1}}}},
      {{"pbrMetallicRoughness", {{"baseColorFactor", {0, 0, 0, 1}}, {"metallicFactor", 0}}},
       {"emissiveFactor", {1, 1, 1}},
       {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 24}}}}}}};
  file.gltf()["extensionsUsed"] = {"KHR_materials_emissive_strength"};
  file.gltf()["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.9}, {"znear", 0.1}}}}};
  // 9 m behind the middle, or within the room, and 3.9 m above it, looking down by 0.45 rad.
  file.node({{"camera", 0},
             {"translation", {0, 3.9, what.is_closed ? 5.5 : 9}},
             {"rotation", {std::sin(-0.225), 0, 0, std::cos(0.225)}}});
  add_hills(file, what.triangles);
  add_lamps(file, what.lights);
  add_stones(file, what.instances);
  if (what.is_closed) add_room(file);
  return file.write(folder);
}

scene::Scene load_growth_scene(const std::filesystem::path& file) {
  scene::LoadOptions options;
  options.sharing_gain = 0;
  return scene::load(file, options);
}

}  // namespace regulus::bench
