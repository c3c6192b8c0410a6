// Small glTF files made in code: a folder that removes itself, a builder of documents with their data inline,
// and PNG files without compression.
#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "scene/scene.hpp"

namespace regulus::scene::test {

using nlohmann::json;
using Bytes = std::vector<unsigned char>;

/// A fresh folder, removed with all it holds.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "regulus-scene-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

  std::filesystem::path write(const std::string& name, const void* data, size_t size) const {
    const std::filesystem::path file = path_ / name;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary)
        .write(static_cast<const char*>(data), static_cast<std::streamsize>(size));
    return file;
  }
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    return write(name, text.data(), text.size());
  }

 private:
  std::filesystem::path path_;
};

inline std::string base64(const Bytes& bytes) {
  const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t group = static_cast<uint32_t>(bytes[i]) << 16;
    if (i + 1 < bytes.size()) group |= static_cast<uint32_t>(bytes[i + 1]) << 8;
    if (i + 2 < bytes.size()) group |= bytes[i + 2];
    for (size_t k = 0; k < 4; ++k) text += k <= bytes.size() - i ? digits[(group >> (18 - 6 * k)) & 63] : '=';
  }
  return text;
}

template <typename T>
Bytes to_bytes(const std::vector<T>& values) {
  Bytes bytes(values.size() * sizeof(T));
  if (!bytes.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

/// A PNG of stored (uncompressed) rows. `samples` are channel values in row order; bits is 8 or 16; channels
/// 1, 3, 4.
Bytes make_png(uint32_t width, uint32_t height, uint32_t channels, uint32_t bits,
               const std::vector<uint16_t>& samples);

/// A grey PNG of one bit a pixel, all black, as small as deflate makes it.
Bytes make_blank_png(uint32_t width, uint32_t height);

constexpr int BYTE = 5120, UNSIGNED_BYTE = 5121, SHORT = 5122, UNSIGNED_SHORT = 5123, UNSIGNED_INT = 5125,
              FLOAT = 5126;

/// A glTF document under construction; `root` may be edited freely.
class Gltf {
 public:
  Gltf() {
    root = {{"asset", {{"version", "2.0"}}},
            {"scene", 0},
            {"scenes", {{{"nodes", json::array()}}}},
            {"nodes", json::array()},
            {"meshes", json::array()},
            {"accessors", json::array()},
            {"bufferViews", json::array()},
            {"buffers", json::array()}};
  }

  /// A buffer view of its own buffer; returns its index.
  size_t view(const Bytes& bytes) {
    root["buffers"].push_back(
        {{"byteLength", bytes.size()}, {"uri", "data:application/octet-stream;base64," + base64(bytes)}});
    root["bufferViews"].push_back({{"buffer", root["buffers"].size() - 1}, {"byteLength", bytes.size()}});
    return root["bufferViews"].size() - 1;
  }

  template <typename T>
  size_t accessor(const std::vector<T>& values, const std::string& type, int component_type) {
    const size_t components = type == "SCALAR" ? 1 : static_cast<size_t>(type.back() - '0');
    root["accessors"].push_back({{"bufferView", view(to_bytes(values))},
                                 {"componentType", component_type},
                                 {"type", type},
                                 {"count", values.size() / components}});
    return root["accessors"].size() - 1;
  }

  size_t positions(const std::vector<float>& values) { return accessor(values, "VEC3", FLOAT); }

  /// A mesh of one primitive.
  size_t mesh(const json& primitive) {
    root["meshes"].push_back({{"primitives", {primitive}}});
    return root["meshes"].size() - 1;
  }

  /// A root node of the scene.
  size_t node(const json& content) {
    root["nodes"].push_back(content);
    root["scenes"][0]["nodes"].push_back(root["nodes"].size() - 1);
    return root["nodes"].size() - 1;
  }

  /// The triangle (0,0,0) (1,0,0) (0,1,0), unindexed, without normals, with uv = xy; area 1/2.
  size_t triangle(const json& primitive_members = json::object(), const json& node_members = json::object()) {
    json primitive = {{"attributes",
                       {{"POSITION", positions({0, 0, 0, 1, 0, 0, 0, 1, 0})},
                        {"TEXCOORD_0", accessor(std::vector<float>{0, 0, 1, 0, 0, 1}, "VEC2", FLOAT)}}}};
    if (!primitive_members.empty()) primitive.update(primitive_members);
    json content = {{"mesh", mesh(primitive)}};
    if (!node_members.empty()) content.update(node_members);
    return node(content);
  }

  /// The same triangle with a material.
  size_t triangle_of(const json& material) {
    root["materials"].push_back(material);
    return triangle({{"material", root["materials"].size() - 1}});
  }

  /// A texture of an inline PNG; returns its index.
  size_t texture(const Bytes& png, const json& sampler = json()) {
    root["images"].push_back({{"uri", "data:image/png;base64," + base64(png)}});
    json texture = {{"source", root["images"].size() - 1}};
    if (!sampler.is_null()) {
      root["samplers"].push_back(sampler);
      texture["sampler"] = root["samplers"].size() - 1;
    }
    root["textures"].push_back(texture);
    return root["textures"].size() - 1;
  }

  /// A node with a light of KHR_lights_punctual.
  size_t light(const json& light, const json& node_members = json::object()) {
    json& lights = root["extensions"]["KHR_lights_punctual"]["lights"];
    lights.push_back(light);
    json content = {{"extensions", {{"KHR_lights_punctual", {{"light", lights.size() - 1}}}}}};
    if (!node_members.empty()) content.update(node_members);
    return node(content);
  }

  Scene load(const LoadOptions& options = {}) const {
    const TemporaryFolder folder;
    return scene::load(folder.write("test.gltf", root.dump()), options);
  }

  json root;
};

/// The message of the Error that `action` throws; empty if it throws none. Fails on any other status.
inline std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    if (error.code() != ErrorCode::BadFile) return "wrong error code";
    const std::string message = error.what();
    return message.find('\n') == std::string::npos ? message : "more than one line: " + message;
  }
  return {};
}

/// What `--strict` says of a file.
inline std::string load_error(const Gltf& file) {
  return error_of([&] { file.load({.is_strict = true}); });
}

inline bool has_warning(const Scene& scene, const std::string& part) {
  for (const std::string& warning : scene.warnings)
    if (warning.find(part) != std::string::npos) return true;
  return false;
}

/// The triangle (0,0,0) (1,0,0) (0,1,0) as an accessor holds it.
inline const std::vector<float> TRIANGLE = {0, 0, 0, 1, 0, 0, 0, 1, 0};

/// Position of corner i of a triangle, as it is stored.
inline glm::vec3 corner(const Scene& scene, size_t triangle, int i) {
  const interface::Triangle& t = scene.triangles.at(triangle);
  const uint32_t vertices[3] = {t.v0, t.v1, t.v2};
  return scene.vertices.at(vertices[i]).position;
}

}  // namespace regulus::scene::test
