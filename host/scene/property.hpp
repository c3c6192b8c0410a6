// Properties of a document that may change with time (glTF 2.0 Asset Object Model), found by JSON pointers.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "scene/document.hpp"

namespace regulus::scene {

struct Property {
  nlohmann::json::json_pointer pointer;
  size_t length = 0;          ///< numbers it consists of; 0: any number of them
  bool is_array = false;      ///< of numbers, also where there is one
  bool is_boolean = false;    ///< 0 is false
  bool is_in_extras = false;  ///< written in the document's extras, which Document::checked does not have
  std::optional<size_t> node_of_transform;  ///< the node whose translation, rotation or scale it is

  /// A quaternion.
  bool is_rotation() const { return is_array && length == 4 && pointer.back() == "rotation"; }
};

/// The property that a pointer leads to; none if there is no such property, it must not change, or nothing
/// reads it.
std::optional<Property> find_property(const Document& document, const std::string& pointer);

/// Gives a property its value in Document::checked (or in the extras); rebuild_model() makes it seen.
/// Precondition: as many finite numbers as the property consists of.
void set_property(Document& document, const Property& property, const std::vector<double>& numbers);

}  // namespace regulus::scene
