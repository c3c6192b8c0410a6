// decode_meshopt_views.
#include <fmt/core.h>
#include <meshoptimizer.h>

#include "scene/compression.hpp"
#include "scene/meshopt_attributes.hpp"

namespace regulus::scene {
namespace {

using nlohmann::json;

// Sixteen bytes of a vertex stream may take two bits, an index no less than a third of a byte: a header that
// claims more than this many decoded bytes per encoded one lies.
constexpr uint64_t MAX_EXPANSION = 128;
// In version 1 of attributes 256 elements that do not change take two bits a byte of one element.
constexpr uint64_t MAX_EXPANSION_1 = 1024;

struct CompressedView {
  std::string element;
  std::span<const unsigned char> source;
  uint64_t stride = 0, count = 0;
  std::string mode, filter;
};

CompressedView read_header(const Document& document, const json& view, const json& extension,
                           std::string element) {
  CompressedView result;
  result.element = std::move(element);
  for (const char* member : {"buffer", "byteLength", "byteStride", "count", "mode"})
    if (!extension.contains(member))
      document.fail(fmt::format("{} has no {}; export the file again", result.element, member));
  const auto source = extension["buffer"].get<size_t>();
  document.require_whole("buffers", source, result.element);
  const auto& buffer = document.buffers.at(source);
  const uint64_t offset = extension.value("byteOffset", uint64_t{0});
  const uint64_t length = extension["byteLength"].get<uint64_t>();
  if (offset > buffer.size() || length > buffer.size() - offset)
    document.fail(
        fmt::format("{}: {} bytes from offset {} leave its buffer of {} bytes; export the file again",
                    result.element, length, offset, buffer.size()));
  result.source = buffer.subspan(offset, length);
  result.stride = extension["byteStride"].get<uint64_t>();
  result.count = extension["count"].get<uint64_t>();
  result.mode = extension["mode"].get<std::string>();
  result.filter = extension.value("filter", "NONE");
  const uint64_t decoded = view.value("byteLength", uint64_t{0});
  // Division first: the product of two numbers of a hostile file may overflow.
  if (result.stride == 0 || result.stride > 256 || result.count > decoded / result.stride ||
      result.stride * result.count != decoded)
    document.fail(
        fmt::format("{}: {} elements of {} bytes are not the {} bytes of the view; export the file again",
                    result.element, result.count, result.stride, decoded));
  const bool is_version_1 = !result.source.empty() && result.source[0] == MESHOPT_ATTRIBUTES_1;
  if (decoded > (is_version_1 ? MAX_EXPANSION_1 : MAX_EXPANSION) * (length + 16))
    document.fail(fmt::format("{} declares {} bytes in {}, which cannot be; export the file again",
                              result.element, decoded, length));
  return result;
}

/// The preconditions that meshoptimizer asserts.
void check_layout(const Document& document, const CompressedView& view) {
  const auto require = [&](bool holds, const char* what) {
    if (!holds)
      document.fail(fmt::format("{}: {} (mode {}, filter {}, stride {}, count {}); export the file again",
                                view.element, what, view.mode, view.filter, view.stride, view.count));
  };
  const bool is_attributes = view.mode == "ATTRIBUTES";
  require(is_attributes || view.mode == "TRIANGLES" || view.mode == "INDICES", "unknown mode");
  if (is_attributes)
    require(view.stride % 4 == 0, "the stride must be a multiple of 4");
  else
    require(view.stride == 2 || view.stride == 4, "indices have 2 or 4 bytes");
  if (view.mode == "TRIANGLES") require(view.count % 3 == 0, "triangles have three indices");
  if (view.filter == "NONE") return;
  require(is_attributes, "only attributes are filtered");
  if (view.filter == "OCTAHEDRAL")
    require(view.stride == 4 || view.stride == 8, "octahedral vectors have 4 or 8 bytes");
  else if (view.filter == "COLOR")
    require(view.stride == 4 || view.stride == 8, "colours have 4 or 8 bytes");
  else if (view.filter == "QUATERNION")
    require(view.stride == 8, "quaternions have 8 bytes");
  else
    require(view.filter == "EXPONENTIAL", "unknown filter");
}

Bytes decode(Document& document, const CompressedView& view) {
  check_layout(document, view);
  document.hold(view.stride * view.count, view.element);
  Bytes bytes(view.stride * view.count);
  const auto* source = view.source.data();
  int status = 0;
  if (view.mode == "ATTRIBUTES" && !view.source.empty() && source[0] == MESHOPT_ATTRIBUTES_1)
    status = decode_meshopt_attributes(bytes, view.stride, view.source) ? 0 : -1;
  else if (view.mode == "ATTRIBUTES")
    status = meshopt_decodeVertexBuffer(bytes.data(), view.count, view.stride, source, view.source.size());
  else if (view.mode == "TRIANGLES")
    status = meshopt_decodeIndexBuffer(bytes.data(), view.count, view.stride, source, view.source.size());
  else
    status = meshopt_decodeIndexSequence(bytes.data(), view.count, view.stride, source, view.source.size());
  if (status != 0)
    document.fail(
        fmt::format("{} cannot be decoded (status {}); export the file again", view.element, status));
  if (view.filter == "OCTAHEDRAL") meshopt_decodeFilterOct(bytes.data(), view.count, view.stride);
  if (view.filter == "QUATERNION") meshopt_decodeFilterQuat(bytes.data(), view.count, view.stride);
  if (view.filter == "COLOR") decode_meshopt_colors(bytes, view.stride);
  if (view.filter == "EXPONENTIAL") meshopt_decodeFilterExp(bytes.data(), view.count, view.stride);
  return bytes;
}

}  // namespace

void decode_meshopt_views(Document& document, const json& reduced) {
  const auto views = reduced.find("bufferViews");
  if (views == reduced.end()) return;
  for (size_t i = 0; i < views->size(); ++i) {
    const json& view = (*views)[i];
    for (const char* name : MESHOPT_EXTENSIONS) {
      const json::json_pointer extension(fmt::format("/extensions/{}", name));
      if (!view.contains(extension)) continue;
      const std::string element = fmt::format("buffer view {} {}", i, name);
      try {
        document.storage.push_back(decode(document, read_header(document, view, view[extension], element)));
        document.decoded_views[static_cast<int>(i)] = document.storage.back();
      } catch (const Error& error) {
        document.mark_broken({"bufferViews", i, message_of(error, document.files.scene_file())});
      }
    }
  }
}

}  // namespace regulus::scene
