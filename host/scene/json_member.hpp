// Members of JSON objects that may be missing.
#pragma once

#include <nlohmann/json.hpp>

namespace regulus::scene {

/// The member of an object; null if there is none, or no object.
inline const nlohmann::json* member(const nlohmann::json* object, const char* key) {
  if (object == nullptr || !object->is_object()) return nullptr;
  const auto found = object->find(key);
  return found == object->end() ? nullptr : &*found;
}

}  // namespace regulus::scene
