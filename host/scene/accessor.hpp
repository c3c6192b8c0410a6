// Reads elements of a glTF accessor in place: any component type, normalized integers, strides, sparse
// substitution. All bounds are checked once, in 64 bits, when the reader is made.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "scene/document.hpp"

namespace regulus::scene {

class AccessorReader {
 public:
  /// @param type TINYGLTF_TYPE_* the use demands.
  /// @param element names the user in errors, e.g. "mesh 3 primitive 0 POSITION".
  /// @throws Error if the type differs or any byte lies outside the buffer view.
  AccessorReader(const Document& document, int accessor, int type, std::string element);

  uint64_t count() const { return count_; }
  uint64_t components() const { return components_; }
  const std::string& element() const { return element_; }

  glm::vec2 vec2_at(uint64_t i) const;
  glm::vec3 vec3_at(uint64_t i) const;
  glm::vec4 vec4_at(uint64_t i) const;
  /// Columns as they are stored. Precondition: the type is MAT4.
  glm::mat4 mat4_at(uint64_t i) const;
  /// Component c of element i. Precondition: c < components().
  float component_at(uint64_t i, uint64_t c) const { return component(at(i) + c * component_size_); }
  /// The same of unsigned integers (indices), see require_indices().
  uint32_t index_at(uint64_t i, uint64_t c = 0) const;
  /// @throws Error unless components are unsigned integers.
  void require_indices(const Document& document) const;

 private:
  void open_base(const Document& document);
  void open_sparse(const Document& document);
  const unsigned char* at(uint64_t i) const;
  float component(const unsigned char* bytes) const;

  std::string element_;
  int component_type_ = 0;
  uint64_t component_size_ = 0;
  uint64_t components_ = 0;
  bool is_normalized_ = false;
  uint64_t count_ = 0;
  uint64_t stride_ = 0;
  const unsigned char* base_ = nullptr;  // null: all zero
  std::vector<uint32_t> sparse_indices_;
  const unsigned char* sparse_values_ = nullptr;
  uint64_t accessor_index_ = 0;
};

}  // namespace regulus::scene
