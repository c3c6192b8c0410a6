#include "scene/schema.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "base/error.hpp"
#include "scene/files.hpp"

namespace regulus::scene {
namespace {

using nlohmann::json;

constexpr int MAX_NESTING = 128;
constexpr double MAX_INT = std::numeric_limits<int32_t>::max();
constexpr double MAX_SIZE = 9007199254740992.0;  // 2^53: exact in a JSON number

constexpr std::array<std::string_view, 24> KNOWN_EXTENSIONS = {
    "EXT_lights_image_based",    "EXT_mesh_gpu_instancing",
    "KHR_animation_pointer",     "EXT_meshopt_compression",
    "EXT_texture_webp",          "KHR_draco_mesh_compression",
    "KHR_lights_punctual",       "KHR_materials_emissive_strength",
    "KHR_materials_anisotropy",  "KHR_materials_clearcoat",
    "KHR_materials_dispersion",  "KHR_materials_ior",
    "KHR_materials_iridescence", "KHR_materials_sheen",
    "KHR_materials_specular",    "KHR_materials_transmission",
    "KHR_materials_unlit",       "KHR_materials_volume",
    "KHR_mesh_quantization",     "KHR_texture_transform",
    "KHR_materials_variants",    "KHR_materials_pbrSpecularGlossiness",
    "KHR_meshopt_compression",   "KHR_node_visibility"};

enum class Kind {
  Index,          // non-negative integer below the length of the array `target`
  IndexArray,     // array of Index
  IndexMap,       // object whose members are Index
  IndexMapArray,  // array of IndexMap
  IntegerMap,     // object whose members are Integer
  Integer,        // 0 .. 2^31 - 1
  Size,           // 0 .. 2^53
  Number,
  Vector,   // `length` numbers
  Numbers,  // any number of them
  Boolean,
  String,
  Any,  // checked by who reads it
  Object,
  ObjectArray
};

struct Rule {
  Kind kind;
  std::string_view target = {};
  size_t length = 0;
};

const std::map<std::string_view, Rule>& rules() {
  static const std::map<std::string_view, Rule> table = {
      {"bufferView", {Kind::Index, "bufferViews"}},
      {"buffer", {Kind::Index, "buffers"}},
      {"indices", {Kind::Index, "accessors"}},
      {"material", {Kind::Index, "materials"}},
      {"mesh", {Kind::Index, "meshes"}},
      {"camera", {Kind::Index, "cameras"}},
      {"source", {Kind::Index, "images"}},
      {"sampler", {Kind::Index, "samplers"}},
      {"index", {Kind::Index, "textures"}},
      {"scene", {Kind::Index, "scenes"}},
      {"light", {Kind::Index, "lights"}},
      {"skin", {Kind::Index, "skins"}},
      {"inverseBindMatrices", {Kind::Index, "accessors"}},
      {"joints", {Kind::IndexArray, "nodes"}},
      {"children", {Kind::IndexArray, "nodes"}},
      {"nodes", {Kind::IndexArray, "nodes"}},
      {"variants", {Kind::IndexArray, "variants"}},
      {"attributes", {Kind::IndexMap, "accessors"}},
      {"targets", {Kind::IndexMapArray, "accessors"}},
      {"weights", {Kind::Numbers}},
      {"mode", {Kind::Integer}},
      {"componentType", {Kind::Integer}},
      {"texCoord", {Kind::Integer}},
      {"magFilter", {Kind::Integer}},
      {"minFilter", {Kind::Integer}},
      {"wrapS", {Kind::Integer}},
      {"wrapT", {Kind::Integer}},
      {"byteOffset", {Kind::Size}},
      {"byteLength", {Kind::Size}},
      {"byteStride", {Kind::Size}},
      {"count", {Kind::Size}},
      {"metallicFactor", {Kind::Number}},
      {"roughnessFactor", {Kind::Number}},
      {"emissiveStrength", {Kind::Number}},
      {"ior", {Kind::Number}},
      {"transmissionFactor", {Kind::Number}},
      {"thicknessFactor", {Kind::Number}},
      {"attenuationDistance", {Kind::Number}},
      {"specularFactor", {Kind::Number}},
      {"alphaCutoff", {Kind::Number}},
      {"clearcoatFactor", {Kind::Number}},
      {"clearcoatRoughnessFactor", {Kind::Number}},
      {"anisotropyStrength", {Kind::Number}},
      {"sheenRoughnessFactor", {Kind::Number}},
      {"dispersion", {Kind::Number}},
      {"iridescenceFactor", {Kind::Number}},
      {"iridescenceIor", {Kind::Number}},
      {"iridescenceThicknessMinimum", {Kind::Number}},
      {"iridescenceThicknessMaximum", {Kind::Number}},
      {"anisotropyRotation", {Kind::Number}},
      {"glossinessFactor", {Kind::Number}},
      {"intensity", {Kind::Number}},
      {"range", {Kind::Number}},
      {"innerConeAngle", {Kind::Number}},
      {"outerConeAngle", {Kind::Number}},
      {"yfov", {Kind::Number}},
      {"aspectRatio", {Kind::Number}},
      {"xmag", {Kind::Number}},
      {"ymag", {Kind::Number}},
      {"znear", {Kind::Number}},
      {"zfar", {Kind::Number}},
      {"translation", {Kind::Vector, {}, 3}},
      {"scale", {Kind::Vector, {}, 3}},
      {"rotation", {Kind::Vector, {}, 4}},
      {"matrix", {Kind::Vector, {}, 16}},
      {"baseColorFactor", {Kind::Vector, {}, 4}},
      {"diffuseFactor", {Kind::Vector, {}, 4}},
      {"emissiveFactor", {Kind::Vector, {}, 3}},
      {"color", {Kind::Vector, {}, 3}},
      {"attenuationColor", {Kind::Vector, {}, 3}},
      {"specularColorFactor", {Kind::Vector, {}, 3}},
      {"sheenColorFactor", {Kind::Vector, {}, 3}},
      {"doubleSided", {Kind::Boolean}},
      {"normalized", {Kind::Boolean}},
      {"visible", {Kind::Boolean}},
      {"type", {Kind::String}},
      {"name", {Kind::String}},
      {"uri", {Kind::String}},
      {"alphaMode", {Kind::String}},
      {"version", {Kind::String}},
      {"asset", {Kind::Object}},
      {"extensions", {Kind::Object}},
      {"sparse", {Kind::Object}},
      {"values", {Kind::Object}},
      {"pbrMetallicRoughness", {Kind::Object}},
      {"baseColorTexture", {Kind::Object}},
      {"metallicRoughnessTexture", {Kind::Object}},
      {"emissiveTexture", {Kind::Object}},
      {"normalTexture", {Kind::Object}},
      {"transmissionTexture", {Kind::Object}},
      {"specularTexture", {Kind::Object}},
      {"specularColorTexture", {Kind::Object}},
      {"clearcoatTexture", {Kind::Object}},
      {"clearcoatRoughnessTexture", {Kind::Object}},
      {"clearcoatNormalTexture", {Kind::Object}},
      {"anisotropyTexture", {Kind::Object}},
      {"sheenColorTexture", {Kind::Object}},
      {"sheenRoughnessTexture", {Kind::Object}},
      {"iridescenceTexture", {Kind::Object}},
      {"iridescenceThicknessTexture", {Kind::Object}},
      {"diffuseTexture", {Kind::Object}},
      {"specularGlossinessTexture", {Kind::Object}},
      {"perspective", {Kind::Object}},
      {"orthographic", {Kind::Object}},
      {"spot", {Kind::Object}},
      {"accessors", {Kind::ObjectArray}},
      {"buffers", {Kind::ObjectArray}},
      {"bufferViews", {Kind::ObjectArray}},
      {"cameras", {Kind::ObjectArray}},
      {"images", {Kind::ObjectArray}},
      {"lights", {Kind::ObjectArray}},
      {"mappings", {Kind::ObjectArray}},
      {"materials", {Kind::ObjectArray}},
      {"meshes", {Kind::ObjectArray}},
      {"primitives", {Kind::ObjectArray}},
      {"samplers", {Kind::ObjectArray}},
      {"scenes", {Kind::ObjectArray}},
      {"skins", {Kind::ObjectArray}},
      {"textures", {Kind::ObjectArray}},
  };
  return table;
}

bool is_normal_texture(std::string_view member) {
  return member == "normalTexture" || member == "clearcoatNormalTexture";
}

/// Members that mean something else inside an extension or a normal texture: rules by that name and member,
/// tried first.
const std::map<std::pair<std::string_view, std::string_view>, Rule>& extension_rules() {
  static const std::map<std::pair<std::string_view, std::string_view>, Rule> table = {
      {{"EXT_meshopt_compression", "mode"}, {Kind::String}},
      {{"EXT_meshopt_compression", "filter"}, {Kind::String}},
      {{"EXT_meshopt_compression", "fallback"}, {Kind::Boolean}},
      {{"KHR_meshopt_compression", "mode"}, {Kind::String}},
      {{"KHR_meshopt_compression", "filter"}, {Kind::String}},
      {{"KHR_meshopt_compression", "fallback"}, {Kind::Boolean}},
      {{"KHR_draco_mesh_compression", "attributes"}, {Kind::IntegerMap}},
      {{"KHR_materials_variants", "variants"}, {Kind::ObjectArray}},
      {{"EXT_lights_image_based", "lights"}, {Kind::Any}},
      {{"EXT_lights_image_based", "light"}, {Kind::Any}},
      {{"KHR_materials_pbrSpecularGlossiness", "specularFactor"}, {Kind::Vector, {}, 3}},
      {{"normalTexture", "scale"}, {Kind::Number}},
      {{"KHR_texture_transform", "offset"}, {Kind::Vector, {}, 2}},
      {{"KHR_texture_transform", "scale"}, {Kind::Vector, {}, 2}},
      {{"KHR_texture_transform", "rotation"}, {Kind::Number}},
  };
  return table;
}

const Rule* find_rule(std::string_view extension, std::string_view member) {
  const auto special = extension_rules().find({extension, member});
  if (special != extension_rules().end()) return &special->second;
  const auto general = rules().find(member);
  return general != rules().end() ? &general->second : nullptr;
}

// Parts of a document that are never read: removed, so that neither we nor tinygltf look at them.
constexpr std::array<std::string_view, 4> IGNORED_MEMBERS = {"extras", "animations", "skeleton",
                                                             "occlusionTexture"};

class Checker {
 public:
  Checker(const json& document, const std::filesystem::path& file) : file_(file) {
    for (const char* array : {"accessors", "buffers", "bufferViews", "cameras", "images", "materials",
                              "meshes", "nodes", "samplers", "scenes", "skins", "textures"})
      lengths_[array] = array_length(document, array);
    lengths_["lights"] = length_in_extension(document, "KHR_lights_punctual", "lights");
    lengths_["variants"] = length_in_extension(document, "KHR_materials_variants", "variants");
  }

  std::vector<BrokenElement>& broken() { return broken_; }

  /// @param extension the extension (or "normalTexture") whose members these are, or empty.
  void check_object(json& object, const std::string& path, std::string_view extension = {}) {
    for (const std::string_view name : IGNORED_MEMBERS) object.erase(std::string(name));
    for (auto member = object.begin(); member != object.end(); ++member) {
      const Rule* rule = find_rule(extension, member.key());
      if (rule != nullptr) {
        const std::string member_path =
            path.empty() ? member.key() : fmt::format("{}/{}", path, member.key());
        check_member(member.value(), member.key(), *rule, member_path);
      }
    }
  }

 private:
  static size_t array_length(const json& object, const char* name) {
    const auto array = object.find(name);
    return array != object.end() && array->is_array() ? array->size() : 0;
  }

  static size_t length_in_extension(const json& document, const char* extension, const char* array) {
    const auto extensions = document.find("extensions");
    if (extensions == document.end() || !extensions->is_object()) return 0;
    const auto found = extensions->find(extension);
    return found != extensions->end() ? array_length(*found, array) : 0;
  }

  static bool are_numbers(const json& value) {
    return value.is_array() &&
           std::all_of(value.begin(), value.end(), [](const json& v) { return v.is_number(); });
  }

  [[noreturn]] void refuse(const std::string& path, const std::string& wanted) const {
    fail(file_, fmt::format("{} must be {}; export the file again", path, wanted));
  }

  void check_member(json& value, const std::string& key, const Rule& rule, const std::string& path) {
    switch (rule.kind) {
      case Kind::Index:
        // A sparse accessor's `indices` is an object.
        if (key == "indices" && value.is_object()) {
          check_object(value, path);
          return require_whole(value, key, path);
        }
        return check_index(value, rule.target, path);
      case Kind::IndexArray:
        if (key == "nodes" && path == "nodes") return check_objects(value, path);
        if (!value.is_array()) refuse(path, "an array of indices");
        for (size_t i = 0; i < value.size(); ++i)
          check_index(value[i], rule.target, fmt::format("{}/{}", path, i));
        return;
      case Kind::IndexMap:
        return check_index_map(value, rule.target, path);
      case Kind::IndexMapArray:
        if (!value.is_array()) refuse(path, "an array");
        for (size_t i = 0; i < value.size(); ++i)
          check_index_map(value[i], rule.target, fmt::format("{}/{}", path, i));
        return;
      case Kind::IntegerMap:
        if (!value.is_object()) refuse(path, "an object");
        for (auto& [name, number] : value.items())
          check_integer(number, MAX_INT, fmt::format("{}/{}", path, name));
        return;
      case Kind::Integer:
        return check_integer(value, MAX_INT, path);
      case Kind::Size:
        // tinygltf holds the sizes of sparse accessors in 32 bits.
        return check_integer(value, path.find("/sparse/") == std::string::npos ? MAX_SIZE : MAX_INT, path);
      case Kind::Number:
        if (!value.is_number()) refuse(path, "a number");
        return;
      case Kind::Vector:
        if (!are_numbers(value) || value.size() != rule.length)
          refuse(path, fmt::format("an array of {} numbers", rule.length));
        return;
      case Kind::Numbers:
        if (!are_numbers(value)) refuse(path, "an array of numbers");
        return;
      case Kind::Boolean:
        if (!value.is_boolean()) refuse(path, "true or false");
        return;
      case Kind::String:
        if (!value.is_string()) refuse(path, "a string");
        return;
      case Kind::Object:
        if (!value.is_object()) refuse(path, "an object");
        if (key == "extensions") return check_extensions(value, path);
        check_object(value, path, is_normal_texture(key) ? "normalTexture" : std::string_view());
        return require_whole(value, key, path);
      case Kind::ObjectArray:
        return check_objects(value, path);
      case Kind::Any:
        return;
    }
  }

  void check_objects(json& array, const std::string& path) {
    if (!array.is_array()) refuse(path, "an array");
    const std::string kind = kind_of(path);
    const json* replacement = stand_in(kind);
    for (size_t i = 0; i < array.size(); ++i) {
      const std::string element = fmt::format("{}/{}", path, i);
      try {
        if (!array[i].is_object()) refuse(element, "an object");
        check_object(array[i], element);
        require_whole(array[i], kind, element);
      } catch (const Error& error) {
        if (replacement == nullptr) throw;
        broken_.push_back({kind, i, message_of(error, file_)});
        array[i] = *replacement;
      }
    }
  }

  /// The array that a path ends at, as whole.hpp names it; empty for those of extensions that it does not
  /// know.
  static std::string kind_of(const std::string& path) {
    if (path.starts_with("extensions/") && !path.starts_with("extensions/KHR_lights_punctual/")) return {};
    return path.substr(path.rfind('/') + 1);
  }

  void require_whole(json& object, std::string_view kind, const std::string& path) const {
    complete(kind, object);
    const std::string missing = missing_part(kind, object);
    if (!missing.empty()) refuse(path, "an object with " + missing);
  }

  void check_extensions(json& extensions, const std::string& path) {
    for (auto member = extensions.begin(); member != extensions.end();) {
      if (!is_known_extension(member.key())) {
        member = extensions.erase(member);
        continue;
      }
      const std::string extension_path = fmt::format("{}/{}", path, member.key());
      if (!member.value().is_object()) refuse(extension_path, "an object");
      check_object(member.value(), extension_path, member.key());
      ++member;
    }
  }

  void check_integer(json& value, double maximum, const std::string& path) const {
    const double number = value.is_number() ? value.get<double>() : -1;
    if (!(number >= 0 && number <= maximum && number == std::floor(number)))
      refuse(path, fmt::format("an integer from 0 to {:.0f}", maximum));
    value = static_cast<uint64_t>(number);
  }

  void check_index_map(json& value, std::string_view target, const std::string& path) const {
    if (!value.is_object()) refuse(path, "an object");
    for (auto& [name, index] : value.items()) check_index(index, target, fmt::format("{}/{}", path, name));
  }

  void check_index(json& value, std::string_view target, const std::string& path) const {
    check_integer(value, MAX_INT, path);
    const size_t length = lengths_.at(target);
    if (value.get<uint64_t>() >= length)
      fail(file_, fmt::format("{} is {}, but there are {} {}; export the file again", path,
                              value.get<uint64_t>(), length, target));
  }

  const std::filesystem::path& file_;
  std::map<std::string_view, size_t> lengths_;
  std::vector<BrokenElement> broken_;
};

}  // namespace

std::optional<MemberShape> shape_of(std::string_view context, std::string_view member) {
  const Rule* rule = find_rule(context, member);
  if (rule == nullptr) return std::nullopt;
  switch (rule->kind) {
    case Kind::Number:
      return MemberShape{};
    case Kind::Boolean:
      return MemberShape{.is_boolean = true};
    case Kind::Vector:
      return MemberShape{.length = rule->length, .is_array = true};
    case Kind::Numbers:
      return MemberShape{.length = 0, .is_array = true};
    default:
      return std::nullopt;
  }
}

bool is_known_extension(std::string_view name) {
  return std::find(KNOWN_EXTENSIONS.begin(), KNOWN_EXTENSIONS.end(), name) != KNOWN_EXTENSIONS.end();
}

JsonSize measure_json(std::string_view text, const std::filesystem::path& file) {
  JsonSize size;
  int depth = 0;
  bool in_string = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\')
        ++i;
      else if (c == '"')
        in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == ',') {
      ++size.values;
    } else if (c == '{' || c == '[') {
      ++size.values;
      size.objects += c == '{' ? 1 : 0;
      if (++depth > MAX_NESTING)
        fail(file, fmt::format("JSON nests deeper than {} levels at byte {}; not a usable glTF file",
                               MAX_NESTING, i));
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
  return size;
}

std::vector<BrokenElement> check_and_reduce(nlohmann::json& document, const std::filesystem::path& file) {
  Checker checker(document, file);
  checker.check_object(document, "");
  return std::move(checker.broken());
}

}  // namespace regulus::scene
