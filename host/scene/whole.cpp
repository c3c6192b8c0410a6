#include "scene/whole.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <initializer_list>
#include <map>
#include <vector>

namespace regulus::scene {
namespace {

using nlohmann::json;

const std::map<std::string_view, std::vector<std::string>>& required_members() {
  static const std::map<std::string_view, std::vector<std::string>> table = {
      {"accessors", {"componentType", "count", "type"}},
      {"bufferViews", {"buffer", "byteLength"}},
      {"cameras", {"type"}},
      {"lights", {"type"}},
      {"orthographic", {"xmag", "ymag"}},
      {"perspective", {"yfov"}},
      {"primitives", {"attributes"}},
      {"sparse", {"count", "indices", "values"}},
      {"indices", {"bufferView", "componentType"}},
      {"values", {"bufferView"}},
  };
  return table;
}

bool is_one_of(const json& value, std::initializer_list<const char*> names) {
  return std::any_of(names.begin(), names.end(), [&](const char* name) { return value == name; });
}

std::string wrong_choice(std::string_view array, const json& element) {
  if (array == "accessors") {
    if (!is_one_of(element["type"], {"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"}))
      return "a type that glTF has";
    // BYTE to DOUBLE, which readers look at again.
    if (element["componentType"] < 5120 || element["componentType"] > 5130)
      return "a component type that glTF has";
  }
  if (array == "bufferViews") {
    const uint64_t stride = element.value("byteStride", uint64_t{0});
    if (stride > 252 || stride % 4 != 0) return "a byteStride that is a multiple of 4 up to 252";
  }
  if (array == "cameras") {
    if (!is_one_of(element["type"], {"perspective", "orthographic"})) return "a type that glTF has";
    if (!element.contains(element["type"].get<std::string>()))
      return fmt::format("a member {}", element["type"].get<std::string>());
  }
  return {};
}

struct Replacement {
  json stand_in;
  std::string_view shown;
};

const std::map<std::string_view, Replacement>& replacements() {
  constexpr std::string_view LEFT_OUT = "what needs it is left out";
  static const std::map<std::string_view, Replacement> table = {
      {"accessors", {{{"componentType", 5121}, {"count", 0}, {"type", "SCALAR"}}, LEFT_OUT}},
      {"buffers", {json::object(), LEFT_OUT}},
      {"bufferViews", {{{"buffer", 0}, {"byteLength", 0}}, LEFT_OUT}},
      {"cameras",
       {{{"type", "perspective"}, {"perspective", {{"yfov", 0.8}, {"znear", 0}}}},
        "46 degrees high instead"}},
      {"images", {json::object(), "what shows it is shown without it"}},
      {"lights", {{{"type", "point"}, {"intensity", 0}}, "left out"}},
      {"materials", {json::object(), "the default material instead"}},
      {"meshes", {{{"primitives", json::array()}}, "left out"}},
      {"nodes", {json::object(), "left out with its children"}},
      {"primitives", {{{"attributes", json::object()}}, "left out"}},
      {"skins", {json::object(), "meshes stand where their nodes are"}},
      {"samplers", {json::object(), "the default sampler instead"}},
      {"textures", {json::object(), "what shows it is shown without it"}},
  };
  return table;
}

}  // namespace

std::string missing_part(std::string_view array, const json& element) {
  const auto required = required_members().find(array);
  if (required != required_members().end())
    for (const std::string& member : required->second)
      if (!element.contains(member)) return fmt::format("a member {}", member);
  if (array.ends_with("Texture") && !element.contains("index")) return "a member index";
  return wrong_choice(array, element);
}

void complete(std::string_view array, json& element) {
  if (array == "lights" && element.contains("type") && element["type"] == "spot" && !element.contains("spot"))
    element["spot"] = json::object();
  if (array == "perspective" && !element.contains("znear")) element["znear"] = 0;
  if (array == "orthographic")
    for (const char* plane : {"znear", "zfar"})
      if (!element.contains(plane)) element[plane] = 0;
}

const json* stand_in(std::string_view array) {
  const auto found = replacements().find(array);
  return found != replacements().end() ? &found->second.stand_in : nullptr;
}

std::string_view shown_instead(std::string_view array) {
  return replacements().at(array).shown;
}

}  // namespace regulus::scene
