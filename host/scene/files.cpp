#include "scene/files.hpp"

#include <fmt/core.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <utility>

namespace regulus::scene {
namespace fs = std::filesystem;

namespace {

/// FNV-1a of 64 bits over further bytes.
template <typename Sequence>
uint64_t continue_hash(uint64_t hash, const Sequence& bytes) {
  for (const auto byte : bytes) hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3u;
  return hash;
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/// "http", "file", ... of an absolute URI, else empty. One letter is not a scheme but a drive.
std::string uri_scheme(const std::string& uri) {
  const size_t colon = uri.find(':');
  if (colon == std::string::npos || colon < 2) return {};
  const bool is_scheme = std::all_of(
      uri.begin(), uri.begin() + static_cast<std::ptrdiff_t>(colon),
      [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '+' || c == '-' || c == '.'; });
  return is_scheme ? uri.substr(0, colon) : std::string();
}

bool is_below(const fs::path& path, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end();
}

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

std::string with_slashes(std::string path) {
  std::replace(path.begin(), path.end(), '\\', '/');
  return path;
}

/// The base64 payload of a data URI, whatever its media type.
Bytes decode_data_uri(const std::string& uri, const fs::path& file, const std::string& element) {
  const size_t comma = uri.find(',');
  const std::string marker = ";base64";
  if (comma == std::string::npos || comma < marker.size() ||
      uri.compare(comma - marker.size(), marker.size(), marker) != 0)
    fail(file,
         element + ": the data URI is not base64; write it as data:application/octet-stream;base64,...");
  // tinygltf knows a fixed list of media types; ours is the one it accepts for any content.
  const std::string canonical =
      "data:application/octet-stream;base64," + percent_decode(uri.substr(comma + 1));
  Bytes bytes;
  std::string media_type;
  if (comma + 1 < uri.size() && !tinygltf::DecodeDataURI(&bytes, media_type, canonical, 0, false))
    fail(file, element + ": the data URI holds no valid base64; export the file again");
  return bytes;
}

}  // namespace

void fail(const fs::path& file, const std::string& message) {
  throw Error(ErrorCode::BadFile, fmt::format("{}: {}", file.string(), message));
}

std::string message_of(const Error& error, const fs::path& file) {
  const std::string message = error.what();
  const std::string prefix = file.string() + ": ";
  return message.starts_with(prefix) ? message.substr(prefix.size()) : message;
}

std::string percent_decode(const std::string& text) {
  std::string decoded;
  decoded.reserve(text.size());
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '%' && i + 2 < text.size() && hex_digit(text[i + 1]) >= 0 && hex_digit(text[i + 2]) >= 0) {
      decoded += static_cast<char>(hex_digit(text[i + 1]) * 16 + hex_digit(text[i + 2]));
      i += 2;
    } else {
      decoded += text[i];
    }
  }
  return decoded;
}

Files::Files(fs::path scene_file, bool allow_external, uint64_t memory_bytes)
    : scene_file_(std::move(scene_file)), allow_external_(allow_external), memory_bytes_(memory_bytes) {}

void Files::hold(uint64_t bytes, const std::string& element) {
  if (bytes > free_bytes()) {
    const auto mebibytes = [](uint64_t value) { return static_cast<double>(value) / (1 << 20); };
    throw OutOfMemory(fmt::format(
        "{} needs {:.1f} MiB, with the rest of the scene {:.1f} MiB, but {:.1f} MiB of memory are allowed; "
        "reduce the scene or allow more",
        element, mebibytes(bytes), mebibytes(held_bytes_) + mebibytes(bytes), mebibytes(memory_bytes_)));
  }
  held_bytes_ += bytes;
}

Bytes Files::read_scene() {
  return read_file(scene_file_, "");
}

Files::Content Files::read_uri(const std::string& uri, const std::string& element) {
  const bool is_data = uri.rfind("data:", 0) == 0;
  if (is_data) hold(uri.size(), element);
  if (is_data) return {decode_data_uri(uri, scene_file_, element), {}};
  const std::string scheme = uri_scheme(uri);
  if (!scheme.empty())
    fail(scene_file_,
         fmt::format("{}: cannot read '{}' URIs; store the file beside the scene", element, scheme));
  const std::string decoded = percent_decode(uri);
  if (decoded.empty() || decoded.find('\0') != std::string::npos)
    fail(scene_file_, fmt::format("{}: empty or malformed URI; name a file beside the scene", element));

  const fs::path as_written = locate(decoded, element);
  if (is_file(as_written)) return {read_file(as_written, element), {}};
  // What exporters write instead: names that nobody encoded, and Windows' separators.
  for (const std::string& candidate : {uri, with_slashes(decoded), with_slashes(uri)}) {
    const fs::path path = candidate == decoded ? as_written : locate(candidate, element);
    if (!is_file(path)) continue;
    return {read_file(path, element),
            fmt::format("{}: '{}' is no URI of a file beside the scene; encode it, with / between folders",
                        element, uri)};
  }
  return {read_file(as_written, element), {}};  // says why not
}

fs::path Files::locate(const std::string& relative, const std::string& element) const {
  const fs::path folder = scene_file_.has_parent_path() ? scene_file_.parent_path() : fs::path(".");
  const fs::path path = folder / fs::path(relative);
  std::error_code error;
  const fs::path real_folder = fs::weakly_canonical(folder, error);
  fs::path real_path = error ? fs::path() : fs::weakly_canonical(path, error);
  if (error)
    fail(scene_file_, fmt::format("{}: cannot resolve '{}': {}", element, relative, error.message()));
  if (!allow_external_ && !is_below(real_path, real_folder))
    fail(scene_file_, fmt::format("{}: '{}' lies outside the scene's folder; allow external files to read it",
                                  element, relative));
  return real_path;
}

Bytes Files::read_file(const fs::path& path, const std::string& element) {
  const auto refuse = [&](const std::string& problem) {
    if (element.empty()) fail(path, problem);
    fail(scene_file_, fmt::format("{}: '{}': {}", element, path.string(), problem));
  };
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) refuse("no such file; check the path");
  if (!fs::is_regular_file(status))
    refuse(element.empty() ? "not a file; name a .gltf or .glb file" : "not a file; name one");
  std::ifstream stream(path, std::ios::binary);
  if (!stream) refuse("cannot be opened; check its permissions");
  const uint64_t size = fs::file_size(path, error);
  if (error) refuse("its size cannot be read: " + error.message());
  hold(size, element.empty() ? "the file" : fmt::format("{}: '{}'", element, path.string()));
  Bytes bytes(size);
  stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  if (static_cast<uint64_t>(stream.gcount()) != size) refuse("reading stopped early; check the disk");
  hash_ = continue_hash(hash_, bytes);
  return bytes;
}

uint64_t Files::hash_with(const std::string& text) const {
  return continue_hash(hash_, text);
}

}  // namespace regulus::scene
