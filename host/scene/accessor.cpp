#include "scene/accessor.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstring>
#include <utility>

namespace regulus::scene {
namespace {

// An accessor without data is all zeros; more elements than this are an attack on memory, not a scene.
constexpr uint64_t MAX_ELEMENTS_WITHOUT_DATA = uint64_t{1} << 22;
constexpr uint64_t MAX_ELEMENTS = 0xFFFFFFFEu;
constexpr unsigned char ZEROS[64] = {};  // as large as the largest element, a matrix of floats

uint64_t size_of_component(int type) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return 4;
    default:
      return 0;
  }
}

template <typename T>
T load(const unsigned char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

uint32_t load_unsigned(const unsigned char* bytes, int type) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return load<uint8_t>(bytes);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return load<uint16_t>(bytes);
    default:
      return load<uint32_t>(bytes);
  }
}

bool is_unsigned(int type) {
  return type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE || type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
         type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
}

/// Throws unless `count` elements of `size` bytes, `stride` apart, fit into `available` bytes after `offset`.
void require_fit(const Document& document, const std::string& element, uint64_t offset, uint64_t count,
                 uint64_t stride, uint64_t size, uint64_t available) {
  // count < 2^32 and stride < 2^8 + 16: no overflow in 64 bits; the offset is checked first.
  if (count == 0) return;
  if (offset > available || (count - 1) * stride + size > available - offset)
    document.fail(
        fmt::format("{}: {} elements need {} bytes from offset {}, the buffer view has {}; "
                    "export the file again",
                    element, count, (count - 1) * stride + size, offset, available));
}

}  // namespace

AccessorReader::AccessorReader(const Document& document, int accessor, int type, std::string element)
    : accessor_index_(static_cast<uint64_t>(accessor)) {
  const tinygltf::Accessor& source = document.model.accessors.at(accessor_index_);
  element_ = fmt::format("{} (accessor {})", element, accessor);
  document.require_whole("accessors", accessor_index_, element);
  if (source.type != type)
    document.fail(fmt::format("{} has the wrong type; export the file again", element_));
  component_type_ = source.componentType;
  component_size_ = size_of_component(component_type_);
  if (component_size_ == 0)
    document.fail(fmt::format("{}: component type {} is not one of glTF's; export the file again", element_,
                              component_type_));
  components_ = static_cast<uint64_t>(tinygltf::GetNumComponentsInType(static_cast<uint32_t>(type)));
  is_normalized_ = source.normalized;
  count_ = source.count;
  if (count_ > MAX_ELEMENTS)
    document.fail(
        fmt::format("{} has {} elements, the limit is {}; split the mesh", element_, count_, MAX_ELEMENTS));
  open_base(document);
  if (source.sparse.isSparse) open_sparse(document);
}

void AccessorReader::open_base(const Document& document) {
  const tinygltf::Accessor& source = document.model.accessors[accessor_index_];
  const uint64_t element_size = component_size_ * components_;
  const auto decoded = document.decoded_accessors.find(accessor_index_);
  if (decoded != document.decoded_accessors.end()) {
    stride_ = element_size;
    require_fit(document, element_, 0, count_, stride_, element_size, decoded->second.size());
    base_ = decoded->second.data();
    return;
  }
  if (source.bufferView < 0) {
    if (count_ > MAX_ELEMENTS_WITHOUT_DATA)
      document.fail(fmt::format("{} claims {} elements but has no buffer view; export the file again",
                                element_, count_));
    return;
  }
  const uint64_t view_stride = document.model.bufferViews[static_cast<size_t>(source.bufferView)].byteStride;
  stride_ = view_stride != 0 ? view_stride : element_size;
  const auto bytes = document.view(source.bufferView, element_);
  require_fit(document, element_, source.byteOffset, count_, stride_, element_size, bytes.size());
  base_ = bytes.data() + source.byteOffset;
}

void AccessorReader::open_sparse(const Document& document) {
  const auto& sparse = document.model.accessors[accessor_index_].sparse;
  const int index_type = sparse.indices.componentType;
  const uint64_t sparse_count = static_cast<uint64_t>(sparse.count);
  if (!is_unsigned(index_type))
    document.fail(
        fmt::format("{}: sparse indices must be unsigned integers; export the file again", element_));
  if (sparse_count > count_)
    document.fail(fmt::format("{}: {} sparse elements for {} elements; export the file again", element_,
                              sparse_count, count_));

  const uint64_t index_size = size_of_component(index_type);
  const auto indices = document.view(sparse.indices.bufferView, element_);
  const uint64_t indices_offset = static_cast<uint64_t>(sparse.indices.byteOffset);
  require_fit(document, element_, indices_offset, sparse_count, index_size, index_size, indices.size());
  const uint64_t element_size = component_size_ * components_;
  const auto values = document.view(sparse.values.bufferView, element_);
  const uint64_t values_offset = static_cast<uint64_t>(sparse.values.byteOffset);
  require_fit(document, element_, values_offset, sparse_count, element_size, element_size, values.size());

  sparse_values_ = values.data() + values_offset;
  sparse_indices_.reserve(sparse_count);
  for (uint64_t i = 0; i < sparse_count; ++i) {
    const uint32_t index = load_unsigned(indices.data() + indices_offset + i * index_size, index_type);
    if (index >= count_ || (i > 0 && index <= sparse_indices_.back()))
      document.fail(fmt::format("{}: sparse index {} is out of range or order; export the file again",
                                element_, index));
    sparse_indices_.push_back(index);
  }
}

const unsigned char* AccessorReader::at(uint64_t i) const {
  if (!sparse_indices_.empty()) {
    const auto found = std::lower_bound(sparse_indices_.begin(), sparse_indices_.end(), i);
    if (found != sparse_indices_.end() && *found == i)
      return sparse_values_ +
             static_cast<uint64_t>(found - sparse_indices_.begin()) * component_size_ * components_;
  }
  return base_ != nullptr ? base_ + i * stride_ : ZEROS;
}

float AccessorReader::component(const unsigned char* bytes) const {
  // Normalized integers: glTF 2.0, 3.11 (the most negative value clamps to -1).
  switch (component_type_) {
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return load<float>(bytes);
    case TINYGLTF_COMPONENT_TYPE_BYTE: {
      const float value = load<int8_t>(bytes);
      return is_normalized_ ? std::max(value / 127.0f, -1.0f) : value;
    }
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: {
      const float value = load<uint8_t>(bytes);
      return is_normalized_ ? value / 255.0f : value;
    }
    case TINYGLTF_COMPONENT_TYPE_SHORT: {
      const float value = load<int16_t>(bytes);
      return is_normalized_ ? std::max(value / 32767.0f, -1.0f) : value;
    }
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: {
      const float value = load<uint16_t>(bytes);
      return is_normalized_ ? value / 65535.0f : value;
    }
    default: {
      const uint32_t value = load<uint32_t>(bytes);
      return is_normalized_ ? static_cast<float>(value / 4294967295.0) : static_cast<float>(value);
    }
  }
}

glm::vec2 AccessorReader::vec2_at(uint64_t i) const {
  const unsigned char* bytes = at(i);
  return {component(bytes), component(bytes + component_size_)};
}

glm::vec3 AccessorReader::vec3_at(uint64_t i) const {
  const unsigned char* bytes = at(i);
  return {component(bytes), component(bytes + component_size_), component(bytes + 2 * component_size_)};
}

glm::vec4 AccessorReader::vec4_at(uint64_t i) const {
  const unsigned char* bytes = at(i);
  return {component(bytes), component(bytes + component_size_), component(bytes + 2 * component_size_),
          component(bytes + 3 * component_size_)};
}

glm::mat4 AccessorReader::mat4_at(uint64_t i) const {
  glm::mat4 matrix(0.0f);
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 4; ++row)
      matrix[column][row] = component_at(i, 4 * static_cast<uint64_t>(column) + static_cast<uint64_t>(row));
  return matrix;
}

uint32_t AccessorReader::index_at(uint64_t i, uint64_t c) const {
  return load_unsigned(at(i) + c * component_size_, component_type_);
}

void AccessorReader::require_indices(const Document& document) const {
  if (!is_unsigned(component_type_) || is_normalized_)
    document.fail(fmt::format("{} must hold plain unsigned integers; export the file again", element_));
}

}  // namespace regulus::scene
