#include "fuzz/targets.hpp"

#include <unistd.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "base/error.hpp"
#include "image/image.hpp"
#include "render/film_file.hpp"
#include "scene/image_decoder.hpp"
#include "scene/scene.hpp"

namespace regulus::fuzz {
namespace {

using nlohmann::json;

// What a scene may take here: fuzzers look for more than that.
constexpr uint64_t MEMORY = uint64_t{256} << 20;
constexpr uint64_t MAX_PIXELS = uint64_t{1} << 20;

/// The bytes as a file of this process, for readers that want a path.
std::filesystem::path as_file(Bytes bytes, const char* extension) {
  static const std::filesystem::path folder = [] {
    std::string name = (std::filesystem::temp_directory_path() / "regulus-fuzz-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    return std::filesystem::path(name);
  }();
  const std::filesystem::path file = folder / (std::string("case") + extension);
  std::filesystem::remove(file);  // some file systems flush a file that is overwritten
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  return file;
}

template <typename Read>
bool is_read(const Read& read) {
  try {
    read();
    return true;
  } catch (const Error& error) {
    if (error.code() != ErrorCode::BadFile) throw;
    return false;
  }
}

bool read_scene(Bytes bytes) {
  return is_read([&] {
    scene::LoadOptions options;
    options.memory_bytes = MEMORY;
    scene::Scene scene = scene::load(as_file(bytes, ".gltf"), options);
    scene::build_lights(scene);
    scene::find_features(scene);
  });
}

bool read_exr(Bytes bytes) {
  return is_read([&] { image::decode_exr("case.exr", bytes, MAX_PIXELS); });
}

bool read_hdr(Bytes bytes) {
  return is_read([&] { image::decode_radiance("case.hdr", bytes, MAX_PIXELS); });
}

bool read_image(Bytes bytes) {
  std::string reason;
  const auto header = scene::read_image_header(bytes, reason);
  return header && header->pixels() <= MAX_PIXELS && scene::decode_image(bytes, *header, reason);
}

/// Checkpoints and parts.
bool read_checkpoint(Bytes bytes) {
  return is_read([&] {
    const std::filesystem::path file = as_file(bytes, ".exr");
    image::ExrContents contents = image::read_exr_contents(file);
    render::take_film(file, contents);
  });
}

void append_chunk(std::string& glb, const char* type, std::string content, char padding) {
  content.resize((content.size() + 3) / 4 * 4, padding);
  const auto size = static_cast<uint32_t>(content.size());
  glb.append(reinterpret_cast<const char*>(&size), 4).append(type, 4).append(content);
}

bool read_glb(const json& document, Bytes binary) {
  std::string chunks;
  append_chunk(chunks, "JSON", document.dump(), ' ');
  append_chunk(chunks, "BIN\0", std::string(binary.begin(), binary.end()), '\0');
  const std::array<uint32_t, 2> rest = {2, static_cast<uint32_t>(chunks.size() + 12)};
  const std::string glb =
      std::string("glTF").append(reinterpret_cast<const char*>(rest.data()), 8).append(chunks);
  return read_scene({reinterpret_cast<const unsigned char*>(glb.data()), glb.size()});
}

/// A mesh with positions, normals and coordinates as accessors without data.
json mesh_document(size_t bytes) {
  json document = {
      {"asset", {{"version", "2.0"}}},        {"scene", 0},
      {"scenes", {{{"nodes", {0}}}}},         {"nodes", {{{"mesh", 0}}}},
      {"buffers", {{{"byteLength", bytes}}}}, {"bufferViews", {{{"buffer", 0}, {"byteLength", bytes}}}}};
  const auto accessor = [&](const char* type, int component) {
    document["accessors"].push_back({{"type", type}, {"componentType", component}, {"count", 3}});
  };
  accessor("SCALAR", 5125);
  accessor("VEC3", 5126);
  accessor("VEC3", 5126);
  accessor("VEC2", 5126);
  document["meshes"][0]["primitives"][0] = {{"indices", 0}, {"attributes", {{"POSITION", 1}}}};
  return document;
}

/// The bytes are those of KHR_draco_mesh_compression.
bool read_draco(Bytes bytes) {
  json document = mesh_document(bytes.size());
  document["extensionsUsed"] = {"KHR_draco_mesh_compression"};
  json& primitive = document["meshes"][0]["primitives"][0];
  primitive["attributes"] = {{"POSITION", 1}, {"NORMAL", 2}};
  primitive["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", 0},
                                                           {"attributes", {{"POSITION", 0}, {"NORMAL", 1}}}};
  return read_glb(document, bytes);
}

/// Four bytes, mode and filter, stride, and count in two, then those of EXT_meshopt_compression.
bool read_meshopt(Bytes bytes) {
  if (bytes.size() < 4) return false;
  constexpr std::array MODES = {"ATTRIBUTES", "TRIANGLES", "INDICES"};
  constexpr std::array FILTERS = {"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"};
  const uint64_t stride = bytes[1], count = bytes[2] + 256u * bytes[3];
  const Bytes stream = bytes.subspan(4);
  json document = mesh_document(stream.size());
  document["extensionsUsed"] = {"EXT_meshopt_compression"};
  json view = {{"buffer", 0}, {"byteLength", stride * count}};
  if (stride > 0) view["byteStride"] = stride;
  view["extensions"]["EXT_meshopt_compression"] = {{"buffer", 0},
                                                   {"byteLength", stream.size()},
                                                   {"byteStride", stride},
                                                   {"count", count},
                                                   {"mode", MODES[bytes[0] % MODES.size()]},
                                                   {"filter", FILTERS[bytes[0] / 16 % FILTERS.size()]}};
  document["bufferViews"] = {view};
  // Positions where they fit; other views are decoded without being used.
  if (stride == 12)
    document["accessors"][1] = {
        {"bufferView", 0}, {"type", "VEC3"}, {"componentType", 5126}, {"count", count}};
  document["meshes"][0]["primitives"][0].erase("indices");
  return read_glb(document, stream);
}

}  // namespace

std::span<const Target> targets() {
  static constexpr std::array TARGETS = {
      Target{"gltf", read_scene},           Target{"exr", read_exr},     Target{"hdr", read_hdr},
      Target{"images", read_image},         Target{"draco", read_draco}, Target{"meshopt", read_meshopt},
      Target{"checkpoint", read_checkpoint}};
  return TARGETS;
}

const Target& target(const char* name) {
  for (const Target& target : targets())
    if (std::strcmp(target.name, name) == 0) return target;
  throw std::out_of_range(name);
}

}  // namespace regulus::fuzz
