#include "scene/references.hpp"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>

#include "scene/files.hpp"

namespace regulus::scene {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// The JSON of either container.
std::string read_json_text(const fs::path& scene_file) {
  std::ifstream stream(scene_file, std::ios::binary);
  uint32_t head[5] = {};  // of a .glb: magic, version, length; length and kind of the first chunk
  stream.read(reinterpret_cast<char*>(head), sizeof head);
  const bool is_binary = stream.gcount() == sizeof head && std::memcmp(head, "glTF", 4) == 0;
  std::error_code error;
  const uint64_t bytes = fs::file_size(scene_file, error);
  if (error) return {};
  stream.clear();
  stream.seekg(is_binary ? sizeof head : 0);
  std::string text(is_binary ? std::min<uint64_t>(head[3], bytes) : bytes, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<size_t>(std::max<std::streamsize>(stream.gcount(), 0)));
  return text;
}

/// {"uri": "x.png"} of buffers, images and extensions; {"file": "sky.exr"} of an environment.
bool names_a_file(const std::string& member, const json& value) {
  return value.is_string() && (member == "uri" || member == "file");
}

}  // namespace

std::vector<fs::path> referenced_files(const fs::path& scene_file) {
  const json document = json::parse(read_json_text(scene_file), nullptr, false);
  const fs::path folder = scene_file.parent_path();
  std::vector<fs::path> files;
  std::vector<const json*> open = {&document};
  while (!open.empty()) {
    const json& value = *open.back();
    open.pop_back();
    if (!value.is_structured()) continue;
    for (const auto& [member, inner] : value.items()) {
      open.push_back(&inner);
      if (!value.is_object() || !names_a_file(member, inner)) continue;
      const auto& uri = inner.get_ref<const std::string&>();
      if (uri.starts_with("data:")) continue;
      std::string name = percent_decode(uri);
      files.push_back(folder / name);
      // Exporters on Windows write these for slashes.
      if (name.find('\\') == std::string::npos) continue;
      std::ranges::replace(name, '\\', '/');
      files.push_back(folder / name);
    }
  }
  return files;
}

}  // namespace regulus::scene
