// A glTF document in memory: the container (.gltf or .glb) opened, its JSON checked and mapped to tinygltf's
// structures, its buffers read. Nothing of it is interpreted yet.
#pragma once

#include <tiny_gltf.h>

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "scene/files.hpp"

namespace regulus::scene {

struct Document {
  Files files;
  nlohmann::json json;         ///< as written, extras included (types unchecked)
  tinygltf::Model model;       ///< checked by check_and_reduce; without buffers, images, skins and animations
  nlohmann::json images;       ///< json["images"], checked
  nlohmann::json skins;        ///< json["skins"], checked
  std::vector<Bytes> storage;  ///< owns what `buffers` points into
  std::vector<std::span<const unsigned char>> buffers;  ///< contents of json["buffers"]
  std::map<int, std::span<const unsigned char>>
      decoded_views;  ///< by buffer view: in place of its buffer's bytes
  /// By accessor: its elements, tightly packed, in place of its buffer view.
  std::map<size_t, std::span<const unsigned char>> decoded_accessors;
  std::vector<std::string> warnings;

  /// The names in extensionsUsed.
  std::vector<std::string> extensions_used() const;

  /// Adds a warning unless the same was given before.
  void warn(const std::string& message);

  /// The bytes of a buffer view. @throws Error naming `element` if it leaves its buffer.
  std::span<const unsigned char> view(int buffer_view, const std::string& element) const;

  [[noreturn]] void fail(const std::string& message) const { scene::fail(files.scene_file(), message); }
};

/// Opens a .gltf or .glb file and everything its buffers refer to.
/// @throws Error(BadFile)
Document open_document(const std::filesystem::path& path, bool allow_external);

/// Converts to float. @throws Error naming `element` if the value is not finite as a float.
float finite_float(const Document& document, double value, const std::string& element);

/// "mesh 3 'chair'" or "mesh 3".
std::string element_name(const char* kind, size_t index, const std::string& name);

}  // namespace regulus::scene
