#include "image/exr_header.hpp"

#include <fmt/format.h>

#include <map>
#include <string>

#include "base/error.hpp"
#include "base/printable.hpp"

namespace regulus::image {

namespace {

constexpr uint32_t MULTI_PART = 0x1000;  // a flag of the version
constexpr uint64_t CHANNEL_BYTES = 16;   // after its name

// Types of a fixed size, in bytes (openexr.com, "OpenEXR File Layout").
const std::map<std::string, uint64_t> FIXED_SIZES = {
    {"box2i", 16},      {"box2f", 16},   {"chromaticities", 32},
    {"compression", 1}, {"double", 8},   {"envmap", 1},
    {"float", 4},       {"int", 4},      {"keycode", 28},
    {"lineOrder", 1},   {"m33f", 36},    {"m33d", 72},
    {"m44f", 64},       {"m44d", 128},   {"rational", 8},
    {"tiledesc", 9},    {"timecode", 8}, {"v2i", 8},
    {"v2f", 8},         {"v2d", 16},     {"v3i", 12},
    {"v3f", 12},        {"v3d", 24},     {"deepImageState", 1}};

class HeaderReader {
 public:
  HeaderReader(const std::filesystem::path& path, std::istream& stream, uint64_t file_bytes)
      : path_(path), stream_(stream), file_bytes_(file_bytes) {}

  void check() {
    stream_.seekg(4);  // after the magic number
    const bool has_parts = (word() & MULTI_PART) != 0;
    // A header ends with an empty name; after the last of several parts there is an empty header.
    uint32_t attributes = 0;
    do {
      for (attributes = 0; stream_; ++attributes) {
        const std::string name = text();
        if (name.empty()) break;
        check_attribute(name);
      }
    } while (has_parts && attributes > 0 && stream_);
  }

 private:
  [[noreturn]] void fail(const std::string& name, const std::string& what) const {
    throw Error(ErrorCode::BadFile, fmt::format("{}: attribute {} {}; the file is cut off or corrupt",
                                                path_.string(), printable(name.substr(0, 100)), what));
  }

  void check_attribute(const std::string& name) {
    const std::string type = text();
    const uint64_t size = word();
    const auto begin = static_cast<uint64_t>(stream_.tellg());
    if (!stream_ || size > file_bytes_ - begin) fail(name, "is longer than the file");
    const uint64_t used = used_bytes(name, type, size);
    if (used != size) fail(name, fmt::format("has {} bytes where {} are meant", size, used));
    stream_.seekg(static_cast<std::streamoff>(begin + size));
  }

  /// What the library will read, if it stays within the attribute; at least more than `size` otherwise.
  uint64_t used_bytes(const std::string& name, const std::string& type, uint64_t size) {
    if (const auto fixed = FIXED_SIZES.find(type); fixed != FIXED_SIZES.end()) return fixed->second;
    if (type == "preview") {
      const uint64_t width = word(), height = word();
      return width * height > size ? size + 1 : 8 + 4 * width * height;
    }
    uint64_t used = 0;
    if (type == "chlist") {
      for (std::string channel = text(); !channel.empty() && used <= size; channel = text()) {
        used += channel.size() + 1 + CHANNEL_BYTES;
        stream_.seekg(CHANNEL_BYTES, std::ios::cur);
      }
      return used + 1;
    }
    if (type == "stringvector") {
      while (used < size) {
        const uint64_t length = word();
        used += 4 + length;
        if (!stream_ || used > size) fail(name, "is longer than it says");
        stream_.seekg(static_cast<std::streamoff>(length), std::ios::cur);
      }
      return used;
    }
    return size;
  }

  std::string text() {
    std::string characters;
    for (int c = stream_.get(); c > 0; c = stream_.get()) characters += static_cast<char>(c);
    return characters;
  }

  uint32_t word() {
    uint32_t value = 0;
    for (int shift = 0; shift < 32; shift += 8) value |= static_cast<uint32_t>(stream_.get() & 0xFF) << shift;
    return value;
  }

  const std::filesystem::path& path_;
  std::istream& stream_;
  uint64_t file_bytes_;
};

}  // namespace

void check_exr_header(const std::filesystem::path& path, std::istream& stream, uint64_t file_bytes) {
  HeaderReader(path, stream, file_bytes).check();
}

}  // namespace regulus::image
