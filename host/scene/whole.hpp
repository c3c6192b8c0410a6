// Elements of a glTF document that are not whole: what they lack, and what takes their place, so that one of
// them does not cost the scene.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace regulus::scene {

/// An element that cannot be read.
struct BrokenElement {
  std::string array;  ///< as in the document, e.g. "accessors"; of KHR_lights_punctual "lights"
  size_t index = 0;   ///< within it, of primitives within their mesh
  std::string fault;  ///< names it by its path, says what is wrong and what to do
};

/// What an element of the array, or an object of that name, lacks of what the specification requires of it
/// and what reading it relies on, e.g. "a member count"; empty: nothing. Members are of the right types.
std::string missing_part(std::string_view array, const nlohmann::json& element);

/// Members that the specification gives a default, but the library that reads the document does not.
void complete(std::string_view array, nlohmann::json& element);

/// What takes the place of broken elements of the array; null if there is nothing that could.
const nlohmann::json* stand_in(std::string_view array);

/// What is shown in place of a broken element of the array.
std::string_view shown_instead(std::string_view array);

}  // namespace regulus::scene
