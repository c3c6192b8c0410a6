#include "scene/edits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <string_view>

#include "base/error.hpp"
#include "base/near_names.hpp"
#include "scene/schema.hpp"

namespace regulus::scene {
namespace {

using nlohmann::json;

/// A property that may be edited: its short name, and where it stands below the element.
struct Editable {
  std::string_view array, name, place;
};

constexpr std::array EDITABLES = std::to_array<Editable>({
    {"materials", "color", "pbrMetallicRoughness/baseColorFactor"},
    {"materials", "metallic", "pbrMetallicRoughness/metallicFactor"},
    {"materials", "roughness", "pbrMetallicRoughness/roughnessFactor"},
    {"materials", "emissive", "emissiveFactor"},
    {"materials", "emissiveStrength", "extensions/KHR_materials_emissive_strength/emissiveStrength"},
    {"materials", "alphaCutoff", "alphaCutoff"},
    {"materials", "doubleSided", "doubleSided"},
    {"materials", "ior", "extensions/KHR_materials_ior/ior"},
    {"materials", "transmission", "extensions/KHR_materials_transmission/transmissionFactor"},
    {"materials", "thickness", "extensions/KHR_materials_volume/thicknessFactor"},
    {"materials", "dispersion", "extensions/KHR_materials_dispersion/dispersion"},
    {"materials", "attenuationDistance", "extensions/KHR_materials_volume/attenuationDistance"},
    {"materials", "attenuationColor", "extensions/KHR_materials_volume/attenuationColor"},
    {"materials", "specular", "extensions/KHR_materials_specular/specularFactor"},
    {"materials", "specularColor", "extensions/KHR_materials_specular/specularColorFactor"},
    {"materials", "clearcoat", "extensions/KHR_materials_clearcoat/clearcoatFactor"},
    {"materials", "clearcoatRoughness", "extensions/KHR_materials_clearcoat/clearcoatRoughnessFactor"},
    {"materials", "sheenColor", "extensions/KHR_materials_sheen/sheenColorFactor"},
    {"materials", "sheenRoughness", "extensions/KHR_materials_sheen/sheenRoughnessFactor"},
    {"materials", "iridescence", "extensions/KHR_materials_iridescence/iridescenceFactor"},
    {"materials", "iridescenceIor", "extensions/KHR_materials_iridescence/iridescenceIor"},
    {"materials", "iridescenceThickness", "extensions/KHR_materials_iridescence/iridescenceThicknessMaximum"},
    {"materials", "anisotropy", "extensions/KHR_materials_anisotropy/anisotropyStrength"},
    {"materials", "anisotropyRotation", "extensions/KHR_materials_anisotropy/anisotropyRotation"},
    {"cameras", "yfov", "perspective/yfov"},
    {"cameras", "aspectRatio", "perspective/aspectRatio"},
    {"cameras", "xmag", "orthographic/xmag"},
    {"cameras", "ymag", "orthographic/ymag"},
    {"cameras", "znear", "perspective/znear"},
    {"cameras", "zfar", "perspective/zfar"},
    {"nodes", "translation", "translation"},
    {"nodes", "rotation", "rotation"},
    {"nodes", "scale", "scale"},
    {"nodes", "matrix", "matrix"},
    {"nodes", "visible", "extensions/KHR_node_visibility/visible"},
    {"lights", "color", "color"},
    {"lights", "intensity", "intensity"},
    {"lights", "range", "range"},
    {"lights", "innerConeAngle", "spot/innerConeAngle"},
    {"lights", "outerConeAngle", "spot/outerConeAngle"},
});
constexpr std::string_view LIGHTS = "/extensions/KHR_lights_punctual/lights";

/// An edit taken apart.
struct Edit {
  const std::string& text;  // all of it
  json::json_pointer element;
  const Editable* property;
  json value;
};

[[noreturn]] void fail(const std::string& edit, const std::string& problem) {
  throw SettingError("define", edit, problem);
}

std::string with_dots(std::string_view place) {
  std::string text(place);
  std::ranges::replace(text, '/', '.');
  return text;
}

const Editable* find_property(std::string_view array, std::string_view name) {
  const auto found = std::ranges::find_if(EDITABLES, [&](const Editable& editable) {
    return editable.array == array && (editable.name == name || with_dots(editable.place) == name);
  });
  return found == EDITABLES.end() ? nullptr : &*found;
}

std::vector<std::string> property_names(std::string_view array) {
  std::vector<std::string> names;
  for (const Editable& editable : EDITABLES)
    if (editable.array == array) names.emplace_back(editable.name);
  return names;
}

std::vector<std::string> array_names() {
  std::vector<std::string> names;
  for (const Editable& editable : EDITABLES)
    if (names.empty() || names.back() != editable.array) names.emplace_back(editable.array);
  return names;
}

/// The names of the elements, or what is as good as one: their indices.
std::vector<std::string> element_names(const json& elements) {
  std::vector<std::string> names;
  for (const json& element : elements)
    names.push_back(element.is_object() && element.contains("name") && element["name"].is_string()
                        ? element["name"].get<std::string>()
                        : std::to_string(names.size()));
  return names;
}

/// The element that `text` begins with, by the longest name that a dot follows or else by index; what follows
/// the dot is left in `text`.
size_t take_element(const std::string& edit, const json& elements, std::string_view& text) {
  const std::vector<std::string> names = element_names(elements);
  std::optional<size_t> best;
  bool is_ambiguous = false;
  for (size_t i = 0; i < names.size(); ++i) {
    if (names[i].empty() || !text.starts_with(names[i] + ".")) continue;
    if (best && names[i].size() < names[*best].size()) continue;
    is_ambiguous = best && names[i] == names[*best];
    best = i;
  }
  if (is_ambiguous)
    fail(edit, fmt::format("more than one element is called \"{}\"; give the index", names[*best]));
  if (!best) {
    size_t index = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), index);
    if (error == std::errc{} && end != text.data() + text.size() && *end == '.' && index < names.size()) {
      text.remove_prefix(static_cast<size_t>(end - text.data()) + 1);
      return index;
    }
    const std::string asked(text.substr(0, std::min(text.rfind('.'), text.size())));
    fail(edit, fmt::format("there is no \"{}\" among the {} that the file has{}", asked, names.size(),
                           suggest(asked, names)));
  }
  text.remove_prefix(names[*best].size() + 1);
  return *best;
}

/// Numbers with commas between them; none if the text is anything else.
std::vector<double> parse_numbers(std::string_view text) {
  std::vector<double> numbers;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (true) {
    double number = 0;
    const auto [after, error] = std::from_chars(at, end, number);
    if (error != std::errc{} || !std::isfinite(number)) return {};
    numbers.push_back(number);
    if (after == end) return numbers;
    if (*after != ',') return {};
    at = after + 1;
  }
}

json parse_value(const std::string& edit, const Editable& property, std::string_view text) {
  const json::json_pointer place(fmt::format("/{}", property.place));
  const std::string parent = place.parent_pointer().empty() ? "" : place.parent_pointer().back();
  const MemberShape shape = shape_of(parent, place.back()).value_or(MemberShape{});
  if (shape.is_boolean) {
    if (text != "true" && text != "false") fail(edit, fmt::format("{} is true or false", property.name));
    return text == "true";
  }
  std::vector<double> numbers = parse_numbers(text);
  if (property.name == "color" && property.array == "materials" && numbers.size() == 3)
    numbers.push_back(1);  // opaque, as a colour is meant
  if (numbers.size() != shape.length)
    fail(edit, shape.length == 1 ? fmt::format("{} is a finite number", property.name)
                                 : fmt::format("{} is {} finite numbers with commas between them",
                                               property.name, shape.length));
  return shape.is_array ? json(numbers) : json(numbers.front());
}

Edit parse(const json& document, const std::string& text) {
  std::string_view path = text;
  const size_t equals = path.rfind('=');  // names may have one
  const size_t dot = path.find('.');
  if (equals == std::string_view::npos || dot == std::string_view::npos || dot > equals)
    fail(text, "expected ARRAY.ELEMENT.PROPERTY=VALUE, such as materials.Glass.roughness=0.1");
  const std::string_view value = path.substr(equals + 1);
  path = path.substr(0, equals);
  const std::string array(path.substr(0, dot));
  const std::vector<std::string> arrays = array_names();
  if (std::ranges::find(arrays, array) == arrays.end()) fail(text, unknown_name(array, arrays));
  path.remove_prefix(dot + 1);
  const json::json_pointer place(array == "lights" ? std::string(LIGHTS) : fmt::format("/{}", array));
  if (!document.contains(place) || !document[place].is_array())
    fail(text, fmt::format("the file has no {}", array));
  const size_t index = take_element(text, document[place], path);
  const Editable* property = find_property(array, path);
  if (property == nullptr) fail(text, unknown_name(std::string(path), property_names(array)));
  return {text, place / index, property, parse_value(text, *property, value)};
}

/// Says that the file uses the extension that `place` begins with, if it does.
void announce_extension(json& document, std::string_view place) {
  constexpr std::string_view EXTENSIONS = "extensions/";
  if (!place.starts_with(EXTENSIONS)) return;
  place.remove_prefix(EXTENSIONS.size());
  const std::string name(place.substr(0, place.find('/')));
  json& used = document["extensionsUsed"];
  if (!used.is_array()) used = json::array();
  if (std::ranges::find(used, json(name)) == used.end()) used.push_back(name);
}

/// Where the property stands in this element. @throws SettingError if it makes no sense there
std::string place_in(const json& element, const Edit& edit) {
  std::string place(edit.property->place);
  if (edit.property->array == "cameras") {
    const bool is_orthographic = element.value("type", std::string()) == "orthographic";
    const bool is_plane = edit.property->name == "znear" || edit.property->name == "zfar";
    if (is_plane && is_orthographic) place = fmt::format("orthographic/{}", edit.property->name);
    if (place.starts_with("orthographic") != is_orthographic)
      fail(edit.text,
           fmt::format("the camera is {}", is_orthographic ? "orthographic" : "no orthographic one"));
  }
  const bool is_transform = place == "translation" || place == "rotation" || place == "scale";
  if (is_transform && element.contains("matrix"))
    fail(edit.text, "the node has a matrix in place of translation, rotation and scale; give a matrix");
  if (place == "matrix" &&
      (element.contains("translation") || element.contains("rotation") || element.contains("scale")))
    fail(edit.text, "the node has translation, rotation or scale in place of a matrix; give those");
  if (place.starts_with("spot/") && element.value("type", std::string()) != "spot")
    fail(edit.text, "the light is no spot");
  return place;
}

}  // namespace

std::vector<std::string> apply_edits(json& document, const std::vector<std::string>& edits) {
  std::map<std::string, std::string> done;
  for (const std::string& text : edits) {
    const Edit edit = parse(document, text);
    if (!document[edit.element].is_object()) fail(text, "the element is no object; correct the file");
    const std::string place = place_in(document[edit.element], edit);
    const json::json_pointer pointer(fmt::format("{}/{}", edit.element.to_string(), place));
    try {
      document[pointer] = edit.value;
    } catch (const json::exception&) {
      fail(text, fmt::format("{} is no object; correct the file", pointer.parent_pointer().to_string()));
    }
    announce_extension(document, place);
    done[pointer.to_string().substr(1)] = edit.value.dump();
  }
  std::vector<std::string> list;
  list.reserve(done.size());
  for (const auto& [place, value] : done) list.push_back(fmt::format("{}={}", place, value));
  return list;
}

}  // namespace regulus::scene
