// The bytes of a scene: its file and what it refers to by URI. Decides which paths may be opened and hashes
// everything that was read. Knows nothing of glTF's structure.
#pragma once

#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/machine_memory.hpp"

namespace regulus::scene {

using Bytes = std::vector<unsigned char>;

/// Throws Error(BadFile) "file: message".
[[noreturn]] void fail(const std::filesystem::path& file, const std::string& message);

/// What an error says of a file, without the file's name.
std::string message_of(const Error& error, const std::filesystem::path& file);

/// More memory than a scene may take; load() makes it an Error of the file. No Error itself, for it must not
/// be mended.
class OutOfMemory : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

class Files {
 public:
  /// @param allow_external URIs may leave the folder of `scene_file`.
  /// @param memory_bytes what the scene may take in all, see hold().
  Files(std::filesystem::path scene_file, bool allow_external,
        uint64_t memory_bytes = default_memory_bytes());

  /// Counts memory before it is taken. @throws OutOfMemory naming `element` and both numbers if that is more
  /// than the scene may take beside what is held already.
  void hold(uint64_t bytes, const std::string& element);
  uint64_t held_bytes() const { return held_bytes_; }
  /// Takes back what was counted since held_bytes() was `held`: it is no longer there.
  void release_to(uint64_t held) { held_bytes_ = held; }
  /// What is left of the memory that the scene may take.
  uint64_t free_bytes() const { return memory_bytes_ - held_bytes_; }

  /// The scene file itself. @throws Error if it cannot be read.
  Bytes read_scene();

  /// What a URI refers to.
  struct Content {
    Bytes bytes;
    std::string fault;  ///< how the URI was understood, if it is not written as it should be; else empty
  };

  /// Decodes `data:`, else reads the file below the scene's folder. A file whose name stands in the URI
  /// without being encoded, or with backslashes between its folders, is found too.
  /// @param element names the user of the URI in errors, e.g. "image 3".
  /// @throws Error if the URI is malformed, remote, outside the folder, or cannot be read.
  Content read_uri(const std::string& uri, const std::string& element);

  /// A file wherever it lies. @throws Error naming `element`, if it is not empty, and what is wrong.
  Bytes read_file(const std::filesystem::path& path, const std::string& element);

  /// FNV-1a (64 bit) of all bytes read so far, in the order of reading.
  uint64_t hash() const { return hash_; }
  /// The hash with what else decides about a scene.
  uint64_t hash_with(const std::string& text) const;

  const std::filesystem::path& scene_file() const { return scene_file_; }

 private:
  /// The file that a relative path names. @throws Error if it lies outside the folder and may not.
  std::filesystem::path locate(const std::string& relative, const std::string& element) const;

  std::filesystem::path scene_file_;
  bool allow_external_;
  uint64_t memory_bytes_, held_bytes_ = 0;
  uint64_t hash_ = 0xcbf29ce484222325u;
};

/// A URI with its %XX escapes decoded. Malformed escapes stay as they are.
std::string percent_decode(const std::string& text);

}  // namespace regulus::scene
