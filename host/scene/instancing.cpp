#include "scene/instancing.hpp"

#include <fmt/core.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <optional>

#include "interface/types.h"
#include "scene/accessor.hpp"

namespace regulus::scene {
namespace {

// What a place takes beside its triangles, as such and as a copy with its box in the tree.
constexpr uint64_t BYTES_OF_PLACE = sizeof(PlacedNode) + 350;

/// The attributes of EXT_mesh_gpu_instancing of one node: translation, rotation, scale per instance, each
/// optional.
class InstanceReader {
 public:
  InstanceReader(Document& document, size_t node, const tinygltf::Value& extension)
      : document_(document),
        element_(element_name("node", node, document.model.nodes[node].name) + " EXT_mesh_gpu_instancing") {
    if (!extension.Has("attributes")) document.fail(element_ + " has no attributes; export the file again");
    const tinygltf::Value& attributes = extension.Get("attributes");
    open(attributes, "TRANSLATION", TINYGLTF_TYPE_VEC3, translation_);
    open(attributes, "ROTATION", TINYGLTF_TYPE_VEC4, rotation_);
    open(attributes, "SCALE", TINYGLTF_TYPE_VEC3, scale_);
    if (!count_)
      document.fail(element_ + " has neither TRANSLATION, ROTATION nor SCALE; export the file again");
  }

  uint64_t count() const { return *count_; }

  /// Transform of instance i within its node. @throws Error if it is not finite.
  glm::dmat4 at(uint64_t i) {
    glm::dmat4 transform(1.0);
    if (translation_) transform = glm::translate(transform, glm::dvec3(translation_->vec3_at(i)));
    if (rotation_) {
      const glm::dvec4 r(rotation_->vec4_at(i));
      const glm::dquat quaternion(r.w, r.x, r.y, r.z);
      const double length = glm::length(quaternion);
      if (length > 0 && std::isfinite(length))
        transform *= glm::mat4_cast(quaternion / length);
      else
        document_.mend(
            fmt::format("{}: instance {}: its rotation is not a quaternion; correct it", element_, i),
            "not turned");
    }
    if (scale_) transform = glm::scale(transform, glm::dvec3(scale_->vec3_at(i)));
    for (int column = 0; column < 4; ++column)
      for (int row = 0; row < 4; ++row)
        if (!std::isfinite(transform[column][row])) refuse(i, "its transform is not finite");
    return transform;
  }

 private:
  void open(const tinygltf::Value& attributes, const char* name, int type,
            std::optional<AccessorReader>& reader) {
    if (!attributes.Has(name)) return;
    reader.emplace(document_, attributes.Get(name).GetNumberAsInt(), type, element_ + " " + name);
    if (count_ && *count_ != reader->count())
      document_.fail(fmt::format("{}: {} has {} elements, another attribute {}; export the file again",
                                 element_, name, reader->count(), *count_));
    count_ = reader->count();
  }

  [[noreturn]] void refuse(uint64_t i, const char* what) const {
    document_.fail(fmt::format("{}: instance {}: {}; correct it", element_, i, what));
  }

  Document& document_;
  std::string element_;
  std::optional<AccessorReader> translation_, rotation_, scale_;
  std::optional<uint64_t> count_;
};

/// Nothing, with a warning, if the attributes are broken.
std::optional<InstanceReader> open_instances(Document& document, size_t node,
                                             const tinygltf::Value& extension) {
  try {
    return InstanceReader(document, node, extension);
  } catch (const Error& error) {
    document.mend(error, "one instance, where the node stands");
    return std::nullopt;
  }
}

uint64_t count_places(Document& document, const std::vector<PlacedNode>& nodes) {
  uint64_t places = 0;
  for (const PlacedNode& placed : nodes) {
    const tinygltf::Node& node = document.model.nodes[placed.node];
    if (node.mesh < 0 || !placed.is_visible) continue;
    const auto extension = node.extensions.find("EXT_mesh_gpu_instancing");
    const bool is_instanced = extension != node.extensions.end() && node.skin < 0;
    const std::optional<InstanceReader> instances =
        is_instanced ? open_instances(document, placed.node, extension->second) : std::nullopt;
    places += instances ? instances->count() : 1;
  }
  return places;
}

}  // namespace

std::vector<PlacedNode> place_meshes(Document& document, const std::vector<PlacedNode>& nodes) {
  std::vector<PlacedNode> places;
  const uint64_t count = count_places(document, nodes);
  document.hold(count * BYTES_OF_PLACE, fmt::format("placing meshes {} times", count));
  if (count >= interface::INVALID_INDEX) document.fail("more than 2^32 meshes in place; reduce the scene");
  places.reserve(count);
  for (const PlacedNode& placed : nodes) {
    const tinygltf::Node& node = document.model.nodes[placed.node];
    if (node.mesh < 0 || !placed.is_visible) continue;
    const auto extension = node.extensions.find("EXT_mesh_gpu_instancing");
    // The instances of a skinned mesh would all stand where its joints are.
    if (extension == node.extensions.end() || node.skin >= 0) {
      places.push_back(placed);
    } else {
      std::optional<InstanceReader> instances = open_instances(document, placed.node, extension->second);
      if (!instances) {
        places.push_back(placed);
        continue;
      }
      for (uint64_t i = 0; i < instances->count(); ++i)
        places.push_back({placed.node, placed.to_world * instances->at(i)});
    }
  }
  return places;
}

}  // namespace regulus::scene
