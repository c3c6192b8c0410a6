#include "scene/animation.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <optional>

#include "base/error.hpp"

namespace regulus::scene {
namespace {

using nlohmann::json;

const json NOTHING = json::object();

// Animations are not part of what check_and_reduce has seen: nothing but what is asked for is looked at.
const json& array_of(const json& object, const char* member) {
  static const json none = json::array();
  const auto found = object.is_object() ? object.find(member) : object.end();
  return object.is_object() && found != object.end() && found->is_array() ? *found : none;
}

const json& object_of(const json& object, const char* member) {
  const auto found = object.is_object() ? object.find(member) : object.end();
  return object.is_object() && found != object.end() && found->is_object() ? *found : NOTHING;
}

std::string string_of(const json& object, const char* member, const char* otherwise = "") {
  const auto found = object.is_object() ? object.find(member) : object.end();
  return object.is_object() && found != object.end() && found->is_string() ? found->get<std::string>()
                                                                           : otherwise;
}

/// A member that is an index below `count`.
std::optional<size_t> index_of(const json& object, const char* member, size_t count) {
  const auto found = object.is_object() ? object.find(member) : object.end();
  if (!object.is_object() || found == object.end() || !found->is_number()) return std::nullopt;
  const double number = found->get<double>();
  if (!(number >= 0 && number < static_cast<double>(count) && number == std::floor(number)))
    return std::nullopt;
  return static_cast<size_t>(number);
}

const json& animations_of(const Document& document) {
  return array_of(document.json, "animations");
}

size_t require_index(const Document& document, const json& object, const char* member, size_t count,
                     const std::string& element) {
  const auto index = index_of(object, member, count);
  if (!index) document.fail(fmt::format("{} has no valid {}; export the file again", element, member));
  return *index;
}

Interpolation interpolation_of(const Document& document, const json& sampler, const std::string& element) {
  const std::string name = string_of(sampler, "interpolation", "LINEAR");
  if (name == "STEP") return Interpolation::Step;
  if (name == "LINEAR") return Interpolation::Linear;
  if (name == "CUBICSPLINE") return Interpolation::CubicSpline;
  document.fail(fmt::format("{}: interpolation '{}' is not known; export the file again", element, name));
}

/// The property that a channel moves as a JSON pointer; empty: none that is defined, to be passed over.
std::string pointer_of(const Document& document, const json& channel) {
  const json& target = object_of(channel, "target");
  const std::string path = string_of(target, "path");
  if (path == "pointer")
    return string_of(object_of(object_of(target, "extensions"), "KHR_animation_pointer"), "pointer");
  const auto node = index_of(target, "node", document.model.nodes.size());
  return node ? fmt::format("/nodes/{}/{}", *node, path) : "";
}

/// A node with a matrix cannot be animated by parts, and must not be by specification: the matrix is taken
/// apart, as others do.
void take_matrix_apart(Document& document, json& node, const std::string& name) {
  glm::dmat4 matrix(1.0);
  for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = node["matrix"][static_cast<size_t>(i)].get<double>();
  const glm::dmat3 linear(matrix);
  glm::dvec3 scale(glm::length(linear[0]), glm::length(linear[1]), glm::length(linear[2]));
  if (glm::determinant(linear) < 0) scale.x = -scale.x;
  const bool is_invertible = scale.x != 0 && scale.y != 0 && scale.z != 0;
  const glm::dquat rotation = is_invertible
                                  ? glm::normalize(glm::quat_cast(glm::dmat3(
                                        linear[0] / scale.x, linear[1] / scale.y, linear[2] / scale.z)))
                                  : glm::dquat(1, 0, 0, 0);
  node.erase("matrix");
  node["translation"] = {matrix[3].x, matrix[3].y, matrix[3].z};
  node["rotation"] = {rotation.x, rotation.y, rotation.z, rotation.w};
  node["scale"] = {scale.x, scale.y, scale.z};
  document.warn(name +
                " has a matrix and is animated; it is taken apart into translation, rotation and scale");
}

}  // namespace

std::vector<AnimationSummary> list_animations(const Document& document) {
  std::vector<AnimationSummary> summaries;
  for (const json& animation : animations_of(document)) {
    AnimationSummary summary{string_of(animation, "name"), 0};
    for (const json& sampler : array_of(animation, "samplers")) {
      const auto input = index_of(sampler, "input", document.model.accessors.size());
      if (!input) continue;
      try {
        const AccessorReader times(document, static_cast<int>(*input), TINYGLTF_TYPE_SCALAR, "");
        if (times.count() == 0) continue;
        const double last = times.component_at(times.count() - 1, 0);
        if (std::isfinite(last)) summary.seconds = std::max(summary.seconds, last);
      } catch (const Error&) {
        continue;  // said where the animation is asked for
      }
    }
    summaries.push_back(summary);
  }
  return summaries;
}

size_t find_animation(const Document& document, const std::string& wanted) {
  const json& animations = animations_of(document);
  std::vector<std::string> names;
  for (const json& animation : animations) names.push_back(string_of(animation, "name"));
  const auto named = std::find(names.begin(), names.end(), wanted);
  if (named != names.end()) return static_cast<size_t>(named - names.begin());
  for (size_t i = 0; i < names.size(); ++i)
    if (wanted == std::to_string(i)) return i;
  document.fail(fmt::format("has no animation {}, {}", json(wanted).dump(),
                            names.empty() ? "nor any other; ask for no animation, time or frames"
                                          : "choose one by name or index: " + json(names).dump()));
}

std::string animation_name(const Document& document, size_t index) {
  const std::string name = string_of(animations_of(document).at(index), "name");
  return name.empty() ? std::to_string(index) : name;
}

Animation::Animation(Document& document, size_t index) {
  const json& animation = animations_of(document).at(index);
  element_ = element_name("animation", index, string_of(animation, "name"));
  const json& channels = array_of(animation, "channels");
  for (size_t i = 0; i < channels.size(); ++i) {
    try {
      add_channel(document, animation, channels[i], fmt::format("{} channel {}", element_, i));
    } catch (const Error& error) {
      document.mend(error, "what it moves stays as it is");
    }
  }
  if (!not_read_.empty())
    document.warn(fmt::format("{} moves what is not read, and stays as it is: {}", element_,
                              fmt::join(not_read_, ", ")));
  if (channels_.empty()) document.warn(element_ + " moves nothing that is read: rest pose");
}

void Animation::add_channel(Document& document, const json& animation, const json& channel,
                            const std::string& element) {
  const std::string pointer = pointer_of(document, channel);
  if (pointer.empty()) return;  // to be ignored by specification
  const std::optional<Property> property = find_property(document, pointer);
  if (!property) {
    if (std::find(not_read_.begin(), not_read_.end(), pointer) == not_read_.end())
      not_read_.push_back(pointer);
    return;
  }
  const json& samplers = array_of(animation, "samplers");
  const json& sampler = samplers[require_index(document, channel, "sampler", samplers.size(), element)];
  const size_t accessors = document.model.accessors.size();
  const auto input = static_cast<int>(require_index(document, sampler, "input", accessors, element));
  const auto output = static_cast<int>(require_index(document, sampler, "output", accessors, element));
  channels_.push_back(
      {*property, Keyframes(document, input, output, interpolation_of(document, sampler, element),
                            property->length, property->is_rotation(), element)});
  const auto node = property->node_of_transform;
  if (node && document.checked["nodes"][*node].contains("matrix"))
    take_matrix_apart(document, document.checked["nodes"][*node],
                      element_name("node", *node, document.model.nodes[*node].name));
}

void Animation::pose(Document& document, double seconds) const {
  for (const Channel& channel : channels_)
    set_property(document, channel.property, channel.keyframes.at(document, seconds));
  rebuild_model(document);
}

}  // namespace regulus::scene
