// What the loader relies on in a glTF document, checked before anything else looks at it: types of the
// members we read, ranges of indices, lengths of vectors. Later code may then index without checks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <vector>

#include "scene/whole.hpp"

namespace regulus::scene {

/// What a JSON text holds, at least: its values, and those of them that are objects.
struct JsonSize {
  uint64_t values = 0, objects = 0;
};

/// Counts before anything is parsed. Throws Error(BadFile) if brackets nest deeper than any glTF needs:
/// recursive readers would overflow the stack.
JsonSize measure_json(std::string_view text, const std::filesystem::path& file);

/// Removes `extras` and extensions that are not read, then checks the types, index ranges and lengths of all
/// members that are. Integers written as 1.0 become integers. Elements with a member that is wrong give way
/// to stand-ins, see whole.hpp.
/// @returns the elements that gave way.
/// @throws Error(BadFile) if what is wrong belongs to no element; it names the member by its JSON path, e.g.
/// meshes/3/primitives/0/indices.
std::vector<BrokenElement> check_and_reduce(nlohmann::json& document, const std::filesystem::path& file);

/// Of a member whose value is made of numbers.
struct MemberShape {
  size_t length = 1;  ///< 0: any number of them
  bool is_array = false, is_boolean = false;
};

/// What the loader reads a member as; none if it reads none of that name, or not as numbers.
/// @param context the extension, or the texture, that it is a member of; other names mean nothing
std::optional<MemberShape> shape_of(std::string_view context, std::string_view member);

/// Whether the loader reads the extension.
bool is_known_extension(std::string_view name);

}  // namespace regulus::scene
