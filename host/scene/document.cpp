#include "scene/document.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>

#include "base/printable.hpp"
#include "scene/compression.hpp"
#include "scene/edits.hpp"
#include "scene/schema.hpp"
#include "scene/specular_glossiness.hpp"

namespace regulus::scene {
namespace {

using ByteSpan = std::span<const unsigned char>;
using nlohmann::json;

constexpr uint32_t GLB_MAGIC = 0x46546C67;  // "glTF"
constexpr uint32_t CHUNK_JSON = 0x4E4F534A;
constexpr uint32_t CHUNK_BIN = 0x004E4942;

// What a JSON value takes as it is read, checked and mapped to tinygltf's structures (measured: 40 to 250
// bytes), and an object (150 to 1080, as a node or a primitive) or material beyond that.
constexpr uint64_t BYTES_OF_VALUE = 250, BYTES_OF_OBJECT = 1100, BYTES_OF_MATERIAL = 2200;

uint32_t read_u32(ByteSpan bytes, size_t offset) {
  return static_cast<uint32_t>(bytes[offset]) | static_cast<uint32_t>(bytes[offset + 1]) << 8 |
         static_cast<uint32_t>(bytes[offset + 2]) << 16 | static_cast<uint32_t>(bytes[offset + 3]) << 24;
}

struct Container {
  ByteSpan json;
  std::optional<ByteSpan> binary;
};

bool is_glb(ByteSpan bytes) {
  return bytes.size() >= 4 && read_u32(bytes, 0) == GLB_MAGIC;
}

// tinygltf 2.7 rejects files with an empty BIN chunk, which are valid, so the chunks are read here.
Container open_glb(ByteSpan bytes, const std::filesystem::path& file) {
  if (bytes.size() < 20) fail(file, "GLB header is truncated; copy or export the file again");
  const uint32_t version = read_u32(bytes, 4);
  if (version != 2)
    fail(file, fmt::format("GLB version {} cannot be read, only 2; convert the file", version));
  const uint64_t length = read_u32(bytes, 8);
  if (length > bytes.size())
    fail(file, fmt::format("truncated: GLB header says {} bytes, the file has {}; copy it again", length,
                           bytes.size()));

  Container container;
  for (uint64_t offset = 12; offset + 8 <= length;) {
    const uint64_t chunk_length = read_u32(bytes, offset);
    const uint32_t type = read_u32(bytes, offset + 4);
    if (offset + 8 + chunk_length > length)
      fail(file,
           fmt::format("GLB chunk at byte {} is longer than the file; copy or export it again", offset));
    const ByteSpan content = bytes.subspan(offset + 8, chunk_length);
    if (offset == 12) {
      if (type != CHUNK_JSON) fail(file, "first GLB chunk is not JSON; export the file again");
      container.json = content;
    } else if (type == CHUNK_BIN && !container.binary) {
      container.binary = content;
    }
    offset += 8 + chunk_length;
  }
  return container;
}

json parse_json(ByteSpan bytes, Document& document) {
  const std::filesystem::path& file = document.files.scene_file();
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const JsonSize size = measure_json(text, file);
  document.hold(size.values * BYTES_OF_VALUE + size.objects * BYTES_OF_OBJECT + 3 * text.size(),
                fmt::format("JSON of {} values and {} objects", size.values, size.objects));
  try {
    json parsed = json::parse(text.begin(), text.end());
    if (!parsed.is_object()) fail(file, "the JSON is not an object; not a glTF file");
    return parsed;
  } catch (const json::exception& error) {
    std::string reason = error.what();
    std::replace(reason.begin(), reason.end(), '\n', ' ');
    fail(file, fmt::format("not valid glTF JSON: {}", reason.substr(0, 200)));
  }
}

void check_asset(const json& document, const std::filesystem::path& file) {
  const auto asset = document.find("asset");
  const std::string version = asset != document.end() && asset->is_object() && asset->contains("version") &&
                                      (*asset)["version"].is_string()
                                  ? (*asset)["version"].get<std::string>()
                                  : std::string();
  if (version.empty()) fail(file, "asset.version is missing; not a glTF 2.0 file");
  if (version.rfind("2.", 0) != 0)
    fail(file, fmt::format("glTF version '{}' cannot be read, only 2.x; convert the file", version));
}

std::vector<std::string> strings(const json& document, const char* member) {
  std::vector<std::string> result;
  const auto array = document.find(member);
  if (array != document.end() && array->is_array())
    for (const json& value : *array)
      if (value.is_string()) result.push_back(value.get<std::string>());
  return result;
}

/// What to know of an extension that is left out on purpose.
std::string_view note_on_extension(std::string_view name) {
  if (name == "KHR_materials_diffuse_transmission")
    return ": it waits for its successor to be ratified, surfaces let no diffuse light through";
  if (name == "KHR_texture_basisu") return ": textures are read from PNG, JPEG and WebP files, not from KTX2";
  return "";
}

void check_extensions(Document& document) {
  const std::vector<std::string> required = strings(document.json, "extensionsRequired");
  for (const std::string& name : required)
    if (!is_known_extension(name))
      document.fail(fmt::format("requires the extension {}, which is not read; export without it{}", name,
                                note_on_extension(name)));
  for (const std::string& name : document.extensions_used())
    if (!is_known_extension(name))
      document.warn(fmt::format("extension {} is not read{}", name, note_on_extension(name)));
}

/// Indices without a buffer view, for which zeros stand (or what Draco decodes), are refused by tinygltf:
/// they are lent one. @returns their accessors, from which it is to be taken again.
std::vector<size_t> lend_views(json& reduced) {
  std::vector<size_t> borrowers;
  if (!reduced.contains("meshes")) return borrowers;
  json& views = reduced.emplace("bufferViews", json::array()).first.value();
  for (const json& mesh : reduced["meshes"]) {
    const auto primitives = mesh.find("primitives");
    if (primitives == mesh.end()) continue;
    for (const json& primitive : *primitives) {
      const auto indices = primitive.find("indices");
      if (indices == primitive.end()) continue;
      json& accessor = reduced["accessors"][indices->get<size_t>()];
      if (accessor.contains("bufferView")) continue;
      accessor["bufferView"] = views.size();
      borrowers.push_back(indices->get<size_t>());
    }
  }
  views.push_back({{"buffer", 0}, {"byteLength", 0}});
  return borrowers;
}

/// A buffer that only announces the size of what compressed views decode to.
bool is_fallback(const json& buffer) {
  const auto extensions = buffer.find("extensions");
  return extensions != buffer.end() &&
         std::any_of(MESHOPT_EXTENSIONS.begin(), MESHOPT_EXTENSIONS.end(), [&](const char* name) {
           return extensions->contains(name) && (*extensions)[name].contains("fallback");
         });
}

tinygltf::Model to_model(json reduced, const Document& document) {
  // Buffers and images are read by Files, under our own rules of which paths may be opened; tinygltf refuses
  // skins without inverse bind matrices, which are valid.
  for (const char* part : {"buffers", "images", "skins"}) reduced.erase(part);
  const std::string text = reduced.dump();
  if (text.size() > 0xFFFFFFFFu) document.fail("more than 4 GiB of JSON cannot be read; use a .glb");

  tinygltf::TinyGLTF parser;
  tinygltf::Model model;
  std::string errors, warnings;
  const bool parsed = parser.LoadASCIIFromString(&model, &errors, &warnings, text.data(),
                                                 static_cast<unsigned int>(text.size()), "");
  // tinygltf skips primitives it cannot parse and still succeeds, but then it has left an error.
  if (!parsed || !errors.empty()) {
    const std::string first_line = errors.substr(0, errors.find('\n'));
    // Most often a compressed mesh without plain accessors beside it.
    const std::string hint = document.warnings.empty() ? "" : " (" + document.warnings.front() + ")";
    document.fail(fmt::format("invalid glTF: {}{}; export the file again",
                              first_line.empty() ? "unknown problem" : first_line, hint));
  }
  return model;
}

tinygltf::Model make_model(const json& reduced, const Document& document) {
  json lent = reduced;
  const std::vector<size_t> borrowers = lend_views(lent);
  tinygltf::Model model = to_model(std::move(lent), document);
  for (const size_t accessor : borrowers) model.accessors[accessor].bufferView = -1;
  return model;
}

/// The bytes of a buffer; those that there are, where it declares more.
ByteSpan read_buffer(Document& document, const json& buffer, size_t index, std::optional<ByteSpan> binary) {
  const std::string element = fmt::format("buffer {}", index);
  ByteSpan bytes;
  if (is_fallback(buffer)) {
    document.broken[{"buffers", index}] =
        element + " stands for what compressed views decode to; export it again";
    return {};
  }
  if (buffer.contains("uri")) {
    document.storage.push_back(document.read_uri(buffer["uri"].get<std::string>(), element));
    bytes = document.storage.back();
  } else if (index == 0 && binary) {
    bytes = *binary;
  } else {
    // Nothing is wrong with it until something reads it.
    document.broken[{"buffers", index}] =
        element + " has no uri, nor is the file a .glb that holds it; export the file again";
    return {};
  }
  const uint64_t length = buffer.value("byteLength", uint64_t{bytes.size()});
  if (length > bytes.size())
    document.mend(fmt::format("{} declares {} bytes but has {}; copy or export the file again", element,
                              length, bytes.size()),
                  "what needs the others is left out");
  return bytes.first(std::min<uint64_t>(length, bytes.size()));
}

void read_buffers(Document& document, const json& reduced, std::optional<ByteSpan> binary) {
  const auto buffers = reduced.find("buffers");
  if (buffers == reduced.end()) return;
  for (size_t i = 0; i < buffers->size(); ++i) {
    document.buffers.emplace_back();
    if (document.broken.contains({"buffers", i})) continue;
    try {
      document.buffers.back() = read_buffer(document, (*buffers)[i], i, binary);
    } catch (const Error& error) {
      document.mark_broken({"buffers", i, message_of(error, document.files.scene_file())});
    }
  }
}

/// Elements that gave way to stand-ins are mended.
void mend_broken(Document& document, const std::vector<BrokenElement>& elements) {
  for (const BrokenElement& element : elements) {
    document.mark_broken(element);
    const bool has_triangles =
        element.array == "primitives" || element.array == "meshes" || element.array == "nodes";
    if (has_triangles && document.first_loss.empty()) document.first_loss = element.fault;
  }
}

}  // namespace

std::vector<std::string> Document::extensions_used() const {
  return strings(json, "extensionsUsed");
}

void Document::warn(const std::string& message) {
  const std::string line = printable(message);
  if (std::find(warnings.begin(), warnings.end(), line) != warnings.end()) return;
  if (warnings.size() < MAX_WARNINGS)
    warnings.push_back(line);
  else
    ++unsaid_warnings;
}

void Document::mend(const std::string& fault, const std::string& shown) {
  if (is_strict) fail(fault);
  warn(fmt::format("{} ({})", fault, shown));
}

void Document::mend(const Error& error, const std::string& shown) {
  mend(message_of(error, files.scene_file()), shown);
}

void Document::leave_out(const Error& error) {
  const std::string fault = message_of(error, files.scene_file());
  if (first_loss.empty()) first_loss = fault;
  mend(fault, "left out");
}

Bytes Document::read_uri(const std::string& uri, const std::string& element) {
  Files::Content content = files.read_uri(uri, element);
  if (!content.fault.empty()) mend(content.fault, "read as if it were");
  return std::move(content.bytes);
}

void Document::mark_broken(const BrokenElement& element) {
  mend(element.fault, std::string(shown_instead(element.array)));
  broken[{element.array, element.index}] = element.fault;
}

void Document::require_whole(const char* array, size_t index, const std::string& user) const {
  const auto found = broken.find({array, index});
  if (found != broken.end()) fail(fmt::format("{}: {}", user, found->second));
}

std::span<const unsigned char> Document::view(int buffer_view, const std::string& element) const {
  const auto decoded = decoded_views.find(buffer_view);
  if (decoded != decoded_views.end()) return decoded->second;
  const auto index = static_cast<size_t>(buffer_view);
  require_whole("bufferViews", index, element);
  const tinygltf::BufferView& view = model.bufferViews.at(index);
  require_whole("buffers", static_cast<size_t>(view.buffer), element);
  const ByteSpan buffer = buffers.at(static_cast<size_t>(view.buffer));
  if (view.byteOffset > buffer.size() || view.byteLength > buffer.size() - view.byteOffset)
    fail(fmt::format(
        "{}: buffer view {} (bytes {} to {}) leaves its buffer of {} bytes; export the file again", element,
        buffer_view, view.byteOffset, uint64_t{view.byteOffset} + view.byteLength, buffer.size()));
  return buffer.subspan(view.byteOffset, view.byteLength);
}

Document open_document(const std::filesystem::path& path, bool allow_external, bool is_strict,
                       uint64_t memory_bytes, const std::vector<std::string>& edits) {
  Document document(Files(path, allow_external, memory_bytes));
  document.is_strict = is_strict;
  document.storage.push_back(document.files.read_scene());
  const ByteSpan bytes = document.storage.back();
  Container container{bytes, std::nullopt};
  if (is_glb(bytes)) container = open_glb(bytes, path);

  document.json = parse_json(container.json, document);
  check_asset(document.json, path);
  document.edits = apply_edits(document.json, edits);
  check_extensions(document);
  json reduced = document.json;
  mend_broken(document, check_and_reduce(reduced, path));
  if (const auto materials = reduced.find("materials"); materials != reduced.end())
    document.hold(materials->size() * BYTES_OF_MATERIAL, fmt::format("{} materials", materials->size()));
  read_buffers(document, reduced, container.binary);
  document.images = reduced.value("images", json::array());
  document.skins = reduced.value("skins", json::array());
  decode_meshopt_views(document, reduced);
  document.checked = reduced;
  for (const char* part : {"buffers", "images"}) document.checked.erase(part);
  convert_specular_glossiness(reduced);
  document.model = make_model(reduced, document);
  decode_draco_primitives(document, reduced);
  return document;
}

void rebuild_model(Document& document) {
  json reduced = document.checked;
  convert_specular_glossiness(reduced);
  tinygltf::Model model = make_model(reduced, document);
  // As decoding and the choice of a variant have left them.
  model.accessors = std::move(document.model.accessors);
  for (size_t i = 0; i < model.meshes.size(); ++i)
    model.meshes[i].primitives = std::move(document.model.meshes[i].primitives);
  document.model = std::move(model);
}

float finite_float(const Document& document, double value, const std::string& element) {
  const float result = static_cast<float>(value);
  if (!std::isfinite(result)) document.fail(fmt::format("{} is not a finite number; correct it", element));
  return result;
}

std::string element_name(const char* kind, size_t index, const std::string& name) {
  return name.empty() ? fmt::format("{} {}", kind, index) : fmt::format("{} {} '{}'", kind, index, name);
}

}  // namespace regulus::scene
