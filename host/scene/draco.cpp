// decode_draco_primitives.
#include <draco/compression/decode.h>
#include <draco/compression/point_cloud/point_cloud_decoder.h>
#include <draco/core/varint_decoding.h>
#include <draco/metadata/metadata_decoder.h>
#include <fmt/core.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <span>

#include "scene/compression.hpp"

namespace regulus::scene {
namespace {

using nlohmann::json;

// What a face takes while it is decoded, and more for each attribute, even if all corners have values of
// their own. Measured on grids: 65 with one attribute and 101 with two. The scene's triangles need more
// afterwards.
constexpr uint64_t BYTES_OF_FACE = 60, BYTES_OF_ATTRIBUTE = 100;

struct Counts {
  uint64_t faces = 0, points = 0;
};

/// What a stream says of itself before the decoder takes memory for it: a few bytes may stand for millions of
/// faces. Zero if it cannot be read; the decoder then refuses it too.
Counts read_counts(std::span<const unsigned char> bytes) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  draco::DracoHeader header{};
  if (!draco::PointCloudDecoder::DecodeHeader(&buffer, &header).ok()) return {};
  const auto version =
      static_cast<uint16_t>(DRACO_BITSTREAM_VERSION(header.version_major, header.version_minor));
  buffer.set_bitstream_version(version);
  if (version >= DRACO_BITSTREAM_VERSION(1, 3) && (header.flags & METADATA_FLAG_MASK) != 0) {
    draco::GeometryMetadata ignored;
    if (!draco::MetadataDecoder().DecodeGeometryMetadata(&buffer, &ignored)) return {};
  }
  bool is_read = true;
  const auto next = [&](uint16_t first_version_with_varints) {
    uint32_t value = 0;
    is_read = is_read && (version >= first_version_with_varints ? draco::DecodeVarint(&value, &buffer)
                                                                : buffer.Decode(&value));
    return uint64_t{value};
  };
  constexpr uint16_t VERSION_2_0 = DRACO_BITSTREAM_VERSION(2, 0), VERSION_2_2 = DRACO_BITSTREAM_VERSION(2, 2);
  Counts counts;
  if (header.encoder_method == draco::MESH_SEQUENTIAL_ENCODING) {
    counts.faces = next(VERSION_2_2);
    counts.points = next(VERSION_2_2);
  } else {
    uint8_t traversal = 0;
    is_read = buffer.Decode(&traversal);
    if (version < VERSION_2_2) next(VERSION_2_0);  // vertices made where the surface is cut
    counts.points = next(VERSION_2_0);
    counts.faces = next(VERSION_2_0);
  }
  return is_read ? counts : Counts{};
}

std::unique_ptr<draco::Mesh> decode(const Document& document, int buffer_view, const std::string& element) {
  const auto bytes = document.view(buffer_view, element);
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) {
    std::string reason = decoded.status().error_msg_string();
    document.fail(fmt::format("{} cannot be decoded ({}); export the file again", element, reason));
  }
  return std::move(decoded).value();
}

/// Values of an attribute per point, as components of type T.
template <typename T>
Bytes convert(const draco::Mesh& mesh, const draco::PointAttribute& attribute, int8_t components) {
  Bytes bytes(sizeof(T) * static_cast<size_t>(components) * mesh.num_points());
  T values[4] = {};
  for (draco::PointIndex point(0); point < mesh.num_points(); ++point) {
    attribute.ConvertValue<T>(attribute.mapped_index(point), components, values);
    const size_t size = sizeof(T) * static_cast<size_t>(components);
    std::memcpy(bytes.data() + point.value() * size, values, size);
  }
  return bytes;
}

Bytes convert(const Document& document, const draco::Mesh& mesh, const draco::PointAttribute& attribute,
              const tinygltf::Accessor& accessor, const std::string& element) {
  const int components = tinygltf::GetNumComponentsInType(static_cast<uint32_t>(accessor.type));
  if (components < 1 || components > 4 || attribute.num_components() != components)
    document.fail(fmt::format("{} has {} components, its accessor {}; export the file again", element,
                              attribute.num_components(), components));
  const auto count = static_cast<int8_t>(components);
  switch (accessor.componentType) {
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return convert<float>(mesh, attribute, count);
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return convert<int8_t>(mesh, attribute, count);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return convert<uint8_t>(mesh, attribute, count);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return convert<int16_t>(mesh, attribute, count);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return convert<uint16_t>(mesh, attribute, count);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return convert<uint32_t>(mesh, attribute, count);
    default:
      document.fail(fmt::format("{} has component type {}, which is not one of glTF's; export the file again",
                                element, accessor.componentType));
  }
}

Bytes indices_of(const draco::Mesh& mesh) {
  Bytes bytes(mesh.num_faces() * 3 * sizeof(uint32_t));
  for (draco::FaceIndex face(0); face < mesh.num_faces(); ++face)
    for (size_t corner = 0; corner < 3; ++corner) {
      const uint32_t index = mesh.face(face)[corner].value();
      std::memcpy(bytes.data() + (face.value() * 3 + corner) * sizeof(index), &index, sizeof(index));
    }
  return bytes;
}

/// What was decoded takes the place of an accessor's data. It was made beside the decoder's memory.
void replace(Document& document, size_t accessor, Bytes bytes, uint64_t count, const std::string& element) {
  document.hold(bytes.size(), element);
  document.storage.push_back(std::move(bytes));
  document.decoded_accessors[accessor] = document.storage.back();
  document.model.accessors[accessor].count = count;
}

void decode_primitive(Document& document, tinygltf::Primitive& primitive, const json& extension,
                      const std::string& element) {
  if (!extension.contains("bufferView") || !extension.contains("attributes") || primitive.indices < 0)
    document.fail(element + " has no bufferView, attributes or indices; export the file again");
  const int view = extension["bufferView"].get<int>();
  const Counts counts = read_counts(document.view(view, element));
  const uint64_t attributes = extension["attributes"].size();
  const uint64_t decoding =
      std::max(counts.faces, counts.points) * (BYTES_OF_FACE + attributes * BYTES_OF_ATTRIBUTE);
  document.hold(decoding, element);
  const auto mesh = decode(document, view, element);
  const auto indices = static_cast<size_t>(primitive.indices);
  document.model.accessors[indices].componentType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
  replace(document, indices, indices_of(*mesh), uint64_t{mesh->num_faces()} * 3, element);
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  for (const auto& [name, id] : extension["attributes"].items()) {
    const auto accessor = primitive.attributes.find(name);
    const draco::PointAttribute* attribute = mesh->GetAttributeByUniqueId(id.get<uint32_t>());
    if (accessor == primitive.attributes.end() || attribute == nullptr)
      document.fail(
          fmt::format("{}: attribute {} is missing from the primitive or the data; export the file again",
                      element, name));
    const auto index = static_cast<size_t>(accessor->second);
    replace(document, index,
            convert(document, *mesh, *attribute, document.model.accessors[index],
                    fmt::format("{} {}", element, name)),
            mesh->num_points(), element);
  }
  document.files.release_to(document.files.held_bytes() - decoding);
}

const json::json_pointer DRACO("/extensions/KHR_draco_mesh_compression");

}  // namespace

void decode_draco_primitives(Document& document, const json& reduced) {
  auto& meshes = document.model.meshes;
  for (size_t m = 0; m < meshes.size(); ++m)
    for (size_t p = 0; p < meshes[m].primitives.size(); ++p) {
      const json& primitive = reduced["meshes"][m]["primitives"][p];
      if (!primitive.contains(DRACO)) continue;
      const std::string element = fmt::format("{} primitive {} KHR_draco_mesh_compression",
                                              element_name("mesh", m, meshes[m].name), p);
      const uint64_t held = document.files.held_bytes();
      try {
        decode_primitive(document, meshes[m].primitives[p], primitive[DRACO], element);
      } catch (const Error& error) {
        document.files.release_to(held);
        document.leave_out(error);
        meshes[m].primitives[p].attributes.clear();
      }
    }
}

}  // namespace regulus::scene
