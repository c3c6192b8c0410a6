// A glTF document in memory: the container (.gltf or .glb) opened, its JSON checked and mapped to tinygltf's
// structures, its buffers read. Nothing of it is interpreted yet.
#pragma once

#include <tiny_gltf.h>

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "scene/files.hpp"
#include "scene/whole.hpp"

namespace regulus::scene {

struct Document {
  explicit Document(Files its_files) : files(std::move(its_files)) {}

  Files files;
  bool is_strict = false;      ///< faults that could be mended are errors
  nlohmann::json json;         ///< as written, extras included (types unchecked)
  nlohmann::json checked;      ///< json after check_and_reduce, what the model is made of
  tinygltf::Model model;       ///< checked by check_and_reduce; without buffers, images, skins and animations
  nlohmann::json images;       ///< json["images"], checked
  nlohmann::json skins;        ///< json["skins"], checked
  std::vector<Bytes> storage;  ///< owns what `buffers` points into
  std::vector<std::span<const unsigned char>> buffers;  ///< contents of json["buffers"]
  std::map<int, std::span<const unsigned char>>
      decoded_views;  ///< by buffer view: in place of its buffer's bytes
  /// By accessor: its elements, tightly packed, in place of its buffer view.
  std::map<size_t, std::span<const unsigned char>> decoded_accessors;
  std::map<std::pair<std::string, size_t>, std::string> broken;  ///< by array and index: why
  std::vector<std::string> warnings;
  std::vector<std::string> edits;  ///< what apply_edits did
  uint64_t unsaid_warnings = 0;    ///< beyond MAX_WARNINGS
  std::string first_loss;          ///< why the first primitive that is left out is

  /// The names in extensionsUsed.
  std::vector<std::string> extensions_used() const;

  /// See Files::hold.
  void hold(uint64_t bytes, const std::string& element) { files.hold(bytes, element); }

  /// Adds a warning, made printable, unless the same was given before. After MAX_WARNINGS they are only
  /// counted: a hostile file may have any number of faults, and nobody reads more lines than that.
  void warn(const std::string& message);

  /// A fault of the file that need not cost the whole scene. `fault` names the element, what is wrong and
  /// what to do; `shown` says what is shown nevertheless. A warning of both.
  /// @throws Error of the fault if the document is strict.
  void mend(const std::string& fault, const std::string& shown);

  /// mend() with the fault that an Error of this document tells of.
  void mend(const Error& error, const std::string& shown);

  /// mend() of an element that has given way to its stand-in, which require_whole() then refuses.
  void mark_broken(const BrokenElement& element);

  /// @throws Error naming `user` if the element is broken.
  void require_whole(const char* array, size_t index, const std::string& user) const;

  /// mend() of a primitive that cannot be read.
  void leave_out(const Error& error);

  /// What a URI refers to: Files::read_uri, with a warning about one that is not written as it should be.
  Bytes read_uri(const std::string& uri, const std::string& element);

  /// The bytes of a buffer view. @throws Error naming `element` if it leaves its buffer.
  std::span<const unsigned char> view(int buffer_view, const std::string& element) const;

  [[noreturn]] void fail(const std::string& message) const { scene::fail(files.scene_file(), message); }
};

inline constexpr size_t MAX_WARNINGS = 100;

/// Opens a .gltf or .glb file and everything its buffers refer to.
/// @param is_strict see Document
/// @param edits see apply_edits; the rules for files hold for what they say, too
/// @throws Error(BadFile)
Document open_document(const std::filesystem::path& path, bool allow_external, bool is_strict,
                       uint64_t memory_bytes = default_memory_bytes(),
                       const std::vector<std::string>& edits = {});

/// Makes the model of what has been written into Document::checked since it was opened. Accessors, and which
/// of them and which materials primitives have, stay as they are.
void rebuild_model(Document& document);

/// Converts to float. @throws Error naming `element` if the value is not finite as a float.
float finite_float(const Document& document, double value, const std::string& element);

/// "mesh 3 'chair'" or "mesh 3".
std::string element_name(const char* kind, size_t index, const std::string& name);

}  // namespace regulus::scene
