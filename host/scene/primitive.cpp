#include "scene/primitive.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <optional>

#include "base/error.hpp"
#include "scene/accessor.hpp"
#include "scene/material.hpp"
#include "scene/morph.hpp"
#include "scene/placement.hpp"
#include "scene/tangents.hpp"
#include "scene/uv_mapping.hpp"

namespace regulus::scene {
namespace {

using interface::INVALID_INDEX;

// So many are looked at whether triangles use them or not: an accessor without data can claim any number.
constexpr uint64_t MANY_VERTICES = uint64_t{1} << 22;

const tinygltf::Primitive& primitive_of(const Document& document, const PrimitiveToStore& instance) {
  return document.model.meshes[instance.mesh].primitives[instance.primitive];
}

std::string instance_name(const Document& document, const PrimitiveToStore& instance) {
  return fmt::format("{} primitive {}",
                     element_name("mesh", instance.mesh, document.model.meshes[instance.mesh].name),
                     instance.primitive);
}

std::optional<MorphedAttribute> attribute(const Document& document, const PrimitiveToStore& instance,
                                          const std::string& name, int type) {
  const tinygltf::Primitive& primitive = primitive_of(document, instance);
  if (primitive.attributes.count(name) == 0) return std::nullopt;
  static const std::vector<double> NO_WEIGHTS;
  return MorphedAttribute(document, primitive, name, type,
                          instance.pose != nullptr ? instance.pose->weights : NO_WEIGHTS,
                          instance_name(document, instance));
}

/// COLOR_0, whose elements have three or four components.
std::optional<MorphedAttribute> color_attribute(const Document& document, const PrimitiveToStore& instance) {
  const auto& attributes = primitive_of(document, instance).attributes;
  const auto found = attributes.find("COLOR_0");
  if (found == attributes.end()) return std::nullopt;
  const int type = document.model.accessors.at(static_cast<size_t>(found->second)).type;
  return attribute(document, instance, "COLOR_0",
                   type == TINYGLTF_TYPE_VEC3 ? TINYGLTF_TYPE_VEC3 : TINYGLTF_TYPE_VEC4);
}

/// An attribute that a primitive can do without; nothing if it is none that is read.
std::optional<MorphedAttribute> optional_attribute(const Document& document, const PrimitiveToStore& instance,
                                                   const std::string& name) {
  if (name == "COLOR_0") return color_attribute(document, instance);
  if (name == "NORMAL") return attribute(document, instance, "NORMAL", TINYGLTF_TYPE_VEC3);
  if (name == "TANGENT") return attribute(document, instance, "TANGENT", TINYGLTF_TYPE_VEC4);
  if (name.starts_with("TEXCOORD_")) return attribute(document, instance, name, TINYGLTF_TYPE_VEC2);
  return std::nullopt;
}

/// The corners of a primitive's triangles as indices into its vertices.
class TriangleList {
 public:
  TriangleList(const Document& document, const PrimitiveToStore& instance, uint64_t vertex_count)
      : mode_(primitive_of(document, instance).mode), vertex_count_(vertex_count) {
    const int indices = primitive_of(document, instance).indices;
    if (indices >= 0) {
      indices_.emplace(document, indices, TINYGLTF_TYPE_SCALAR,
                       instance_name(document, instance) + " indices");
      indices_->require_indices(document);
    }
    corners_ = indices_ ? indices_->count() : vertex_count;
  }

  uint64_t size() const {
    if (mode_ == TINYGLTF_MODE_TRIANGLES) return corners_ / 3;
    return corners_ < 3 ? 0 : corners_ - 2;
  }

  uint64_t leftover() const { return mode_ == TINYGLTF_MODE_TRIANGLES ? corners_ % 3 : 0; }

  /// Vertex indices of triangle t, counter-clockwise at the front (glTF 2.0, 3.7.2.1).
  /// @throws Error if one is out of range.
  glm::uvec3 at(const Document& document, const PrimitiveToStore& instance, uint64_t t) const {
    glm::u64vec3 corner(3 * t, 3 * t + 1, 3 * t + 2);
    if (mode_ == TINYGLTF_MODE_TRIANGLE_STRIP) corner = {t, t + (1 + t % 2), t + (2 - t % 2)};
    if (mode_ == TINYGLTF_MODE_TRIANGLE_FAN) corner = {t + 1, t + 2, 0};
    glm::uvec3 vertex;
    for (int i = 0; i < 3; ++i) {
      vertex[i] = indices_ ? indices_->index_at(corner[i]) : static_cast<uint32_t>(corner[i]);
      if (vertex[i] >= vertex_count_)
        document.fail(fmt::format("{}: index {} refers to vertex {} of {}; export the file again",
                                  instance_name(document, instance), corner[i], vertex[i], vertex_count_));
    }
    return vertex;
  }

 private:
  int mode_;
  uint64_t vertex_count_;
  uint64_t corners_ = 0;
  std::optional<AccessorReader> indices_;
};

bool is_triangle_mode(int mode) {
  return mode == TINYGLTF_MODE_TRIANGLES || mode == TINYGLTF_MODE_TRIANGLE_STRIP ||
         mode == TINYGLTF_MODE_TRIANGLE_FAN;
}

/// Geometric normal as kernels compute it, in single precision; zero when the triangle has no usable area
/// (its squared length would leave the normal range and the normal be noise).
glm::vec3 geometric_normal(const glm::vec3& p0, const glm::vec3& p1, const glm::vec3& p2) {
  const glm::vec3 normal = glm::cross(p1 - p0, p2 - p0);
  const float length_squared = glm::dot(normal, normal);
  if (!(length_squared >= FLT_MIN) || !std::isfinite(length_squared)) return glm::vec3(0);
  return normal / std::sqrt(length_squared);
}

MaterialUvs uvs_of(const Document& document, const PrimitiveToStore& instance) {
  const int material = primitive_of(document, instance).material;
  if (material < 0) return {};
  return material_uvs(document.model.materials[static_cast<size_t>(material)]);
}

/// TANGENT, if the material needs it; without normals the specification says to ignore it.
std::optional<MorphedAttribute> tangent_attribute(const Document& document,
                                                  const PrimitiveToStore& instance) {
  const int material = primitive_of(document, instance).material;
  if (material < 0 || !needs_tangents(document.model.materials[static_cast<size_t>(material)]) ||
      primitive_of(document, instance).attributes.count("NORMAL") == 0)
    return std::nullopt;
  return attribute(document, instance, "TANGENT", TINYGLTF_TYPE_VEC4);
}

/// What places a vertex in the world.
struct VertexFrame {
  glm::dmat4 to_world;
  glm::dmat3 normal_to_world;
  bool is_mirrored;

  explicit VertexFrame(const glm::dmat4& transform) : to_world(transform) {
    const glm::dmat3 linear(transform);
    is_mirrored = glm::determinant(linear) < 0;
    // The cofactor matrix is determinant * inverse transpose and exists for flattening transforms too.
    const glm::dmat3 cofactor(glm::cross(linear[1], linear[2]), glm::cross(linear[2], linear[0]),
                              glm::cross(linear[0], linear[1]));
    normal_to_world = is_mirrored ? -cofactor : cofactor;
  }
};

/// Flattens one primitive.
class PrimitiveBuilder {
 public:
  PrimitiveBuilder(Document& document, const PrimitiveToStore& instance, Scene& scene, Tally& tally)
      : document_(document),
        instance_(instance),
        scene_(scene),
        tally_(tally),
        positions_(*attribute(document, instance, "POSITION", TINYGLTF_TYPE_VEC3)),
        normals_(attribute(document, instance, "NORMAL", TINYGLTF_TYPE_VEC3)),
        material_uvs_(uvs_of(document, instance)),
        uvs_(uv_attribute(material_uvs_.first.set)),
        further_uvs_(further_attributes()),
        colors_(color_attribute(document, instance)),
        tangents_(tangent_attribute(document, instance)),
        triangles_(document, instance, positions_.count()),
        frame_(instance.to_world) {
    if (instance.pose != nullptr && instance.pose->joints) skin(*instance.pose->joints);
    const int material = primitive_of(document, instance).material;
    needs_tangents_ =
        material >= 0 && needs_tangents(document.model.materials[static_cast<size_t>(material)]);
    material_ = material >= 0 ? static_cast<uint32_t>(material)
                              : static_cast<uint32_t>(document.model.materials.size());
  }

  void build() {
    if (!uvs_ && material_uvs_.has_textures) warn_of_missing(material_uvs_.first.set);
    for (size_t i = 0; i < further_uvs_.size(); ++i)
      if (!further_uvs_[i]) warn_of_missing(material_uvs_.further_sets[i]);
    if (triangles_.leftover() != 0)
      document_.warn(fmt::format("{}: the last {} indices make no triangle and are ignored",
                                 instance_name(document_, instance_), triangles_.leftover()));
    const size_t first_vertex = scene_.vertices.size();
    const size_t first_triangle = scene_.triangles.size();
    if (normals_) {
      add_shared_vertices();
      add_smooth_triangles();
    } else {
      add_flat_triangles();
    }
    if (needs_tangents_ && !tangents_) add_tangents_of_image(first_vertex, first_triangle);
  }

 private:
  /// Joints move the vertices, one by one.
  void skin(const JointMatrices& joints) {
    const tinygltf::Primitive& primitive = primitive_of(document_, instance_);
    const std::string name = instance_name(document_, instance_);
    if (has_joints(primitive))
      skinned_ = skin_vertices(document_, primitive, joints, positions_.count(), name, tally_.skin);
    else
      document_.warn(name + " has no joints and weights for its skin; its node places it");
  }

  VertexFrame frame(uint64_t i) const { return skinned_.empty() ? frame_ : VertexFrame(skinned_[i]); }

  std::optional<MorphedAttribute> uv_attribute(int set) const {
    return attribute(document_, instance_, fmt::format("TEXCOORD_{}", set), TINYGLTF_TYPE_VEC2);
  }

  std::vector<std::optional<MorphedAttribute>> further_attributes() const {
    std::vector<std::optional<MorphedAttribute>> attributes;
    for (const int set : material_uvs_.further_sets) attributes.push_back(uv_attribute(set));
    return attributes;
  }

  void warn_of_missing(int set) {
    document_.mend(fmt::format("{} has no TEXCOORD_{}, which its material asks for; export it",
                               instance_name(document_, instance_), set),
                   "all of it as its textures are at (0, 0)");
  }

  /// Tangents follow the coordinates of the normal texture. Those of a skinned mesh are made where its joints
  /// put it.
  void add_tangents_of_image(size_t first_vertex, size_t first_triangle) {
    const interface::Texture placement = material_uvs_.placement(material_uvs_.of_normals);
    add_tangents(scene_, first_vertex, first_triangle, placement,
                 glm::dmat3(skinned_.empty() ? instance_.to_world : glm::dmat4(1.0)));
  }

  glm::vec3 position(uint64_t i, const VertexFrame& frame) const {
    const glm::vec3 local = positions_.vec3_at(i);
    const glm::vec3 world(frame.to_world * glm::dvec4(local, 1.0));
    for (int axis = 0; axis < 3; ++axis) {
      if (!std::isfinite(local[axis]))
        document_.fail(fmt::format("{}: vertex {} is not finite; repair the mesh", positions_.element(), i));
      if (!(std::fabs(world[axis]) <= MAX_COORDINATE))
        document_.fail(fmt::format("{}: vertex {} lies beyond {:g} units; scale the scene down",
                                   positions_.element(), i, MAX_COORDINATE));
    }
    return world;
  }

  glm::vec2 uv(const std::optional<MorphedAttribute>& reader, const UvMapping& mapping, uint64_t i) {
    if (!reader) return glm::vec2(0);
    const glm::vec2 value = mapping.apply(reader->vec2_at(i));
    if (std::isfinite(value.x) && std::isfinite(value.y)) return value;
    ++tally_.bad_uvs;
    return glm::vec2(0);
  }

  /// Clamped as the specification demands (glTF 2.0, 3.7.2.1).
  glm::vec4 color(uint64_t i) {
    const glm::vec4 value =
        colors_->components() == 3 ? glm::vec4(colors_->vec3_at(i), 1) : colors_->vec4_at(i);
    if (!glm::any(glm::isnan(value))) return glm::clamp(value, 0.0f, 1.0f);
    ++tally_.bad_colors;
    return glm::vec4(1);
  }

  /// Appends a vertex with everything that vertex `source` of the primitive carries but its normal.
  void add_vertex(uint64_t source, const VertexFrame& frame, const glm::vec3& world_position,
                  const glm::vec3& world_normal) {
    scene_.vertices.push_back({world_position, world_normal, uv(uvs_, material_uvs_.first, source)});
    if (!further_uvs_.empty()) {
      scene_.vertex_uvs.resize(scene_.vertices.size() * scene_.vertex_uv_sets, glm::vec2(0));
      const size_t first = scene_.vertex_uvs.size() - scene_.vertex_uv_sets;
      for (size_t i = 0; i < further_uvs_.size(); ++i)
        scene_.vertex_uvs[first + i] = uv(further_uvs_[i], {}, source);
    }
    if (colors_) {
      scene_.vertex_colors.resize(scene_.vertices.size() - 1, glm::vec4(1));
      scene_.vertex_colors.push_back(color(source));
    }
    if (tangents_) {
      scene_.vertex_tangents.resize(scene_.vertices.size() - 1, glm::vec4(1, 0, 0, 1));
      scene_.vertex_tangents.push_back(tangent(source, frame, world_normal));
    }
  }

  /// World-space tangent; a mirroring transform turns the bitangent.
  glm::vec4 tangent(uint64_t i, const VertexFrame& frame, const glm::vec3& world_normal) {
    const glm::vec4 local = tangents_->vec4_at(i);
    const glm::dvec3 world = glm::dmat3(frame.to_world) * glm::dvec3(local);
    const double length = glm::length(world);
    const float sign = (local.w < 0) != frame.is_mirrored ? -1.0f : 1.0f;
    if (length > 0 && std::isfinite(length)) return {glm::vec3(world / length), sign};
    ++tally_.bad_tangents;
    return any_tangent(world_normal);
  }

  /// World-space unit normal; zero where the file's normal gives no direction.
  glm::vec3 normal(uint64_t i, const VertexFrame& frame) const {
    const glm::dvec3 world = frame.normal_to_world * glm::dvec3(normals_->vec3_at(i));
    const double largest = std::max({std::fabs(world.x), std::fabs(world.y), std::fabs(world.z)});
    if (!(largest > 0) || !std::isfinite(largest)) return glm::vec3(0);
    return glm::vec3(glm::normalize(world / largest));
  }

  void add_shared_vertices() {
    first_vertex_ = static_cast<uint32_t>(scene_.vertices.size());
    for (uint64_t i = 0; i < positions_.count(); ++i) {
      const VertexFrame vertex = frame(i);
      add_vertex(i, vertex, position(i, vertex), normal(i, vertex));
    }
  }

  void add_smooth_triangles() {
    for (uint64_t t = 0; t < triangles_.size(); ++t) {
      const glm::uvec3 corner = corners(t) + first_vertex_;
      const glm::vec3 geometric =
          geometric_normal(scene_.vertices[corner.x].position, scene_.vertices[corner.y].position,
                           scene_.vertices[corner.z].position);
      if (geometric == glm::vec3(0)) {
        ++tally_.without_area;
        continue;
      }
      for (int i = 0; i < 3; ++i) {
        glm::vec3& shading = scene_.vertices[corner[i]].normal;
        if (shading != glm::vec3(0)) continue;
        shading = geometric;
        ++tally_.bad_normals;
      }
      add_triangle(corner);
    }
    // Vertices that no triangle uses still keep the promise of unit normals.
    for (size_t i = first_vertex_; i < scene_.vertices.size(); ++i)
      if (scene_.vertices[i].normal == glm::vec3(0)) scene_.vertices[i].normal = {0, 0, 1};
  }

  void add_flat_triangles() {
    for (uint64_t t = 0; t < triangles_.size(); ++t) {
      const glm::uvec3 corner = corners(t);
      const VertexFrame frames[3] = {frame(corner.x), frame(corner.y), frame(corner.z)};
      glm::vec3 p[3];
      for (int i = 0; i < 3; ++i) p[i] = position(corner[i], frames[i]);
      const glm::vec3 geometric = geometric_normal(p[0], p[1], p[2]);
      if (geometric == glm::vec3(0)) {
        ++tally_.without_area;
        continue;
      }
      const uint32_t first = static_cast<uint32_t>(scene_.vertices.size());
      for (int i = 0; i < 3; ++i) add_vertex(corner[i], frames[i], p[i], geometric);
      add_triangle({first, first + 1, first + 2});
    }
  }

  /// Corners of triangle t; a mirroring transform (of most corners) turns the front face away, so two corners
  /// swap.
  glm::uvec3 corners(uint64_t t) {
    ++tally_.triangles;
    const glm::uvec3 corner = triangles_.at(document_, instance_, t);
    return is_mirrored(corner) ? glm::uvec3(corner.x, corner.z, corner.y) : corner;
  }

  bool is_mirrored(const glm::uvec3& corner) const {
    if (skinned_.empty()) return frame_.is_mirrored;
    int mirrored = 0;
    for (int i = 0; i < 3; ++i) mirrored += glm::determinant(glm::dmat3(skinned_[corner[i]])) < 0 ? 1 : 0;
    return mirrored >= 2;
  }

  void add_triangle(const glm::uvec3& corner) {
    scene_.triangles.push_back({corner.x, corner.y, corner.z, material_, INVALID_INDEX, instance_.place});
  }

  Document& document_;
  const PrimitiveToStore& instance_;
  Scene& scene_;
  Tally& tally_;
  MorphedAttribute positions_;
  std::optional<MorphedAttribute> normals_;
  MaterialUvs material_uvs_;
  std::optional<MorphedAttribute> uvs_;
  std::vector<std::optional<MorphedAttribute>> further_uvs_;
  std::optional<MorphedAttribute> colors_;
  std::optional<MorphedAttribute> tangents_;
  TriangleList triangles_;
  VertexFrame frame_;                // where no joints place the vertices
  std::vector<glm::dmat4> skinned_;  // by vertex; empty: without joints
  bool needs_tangents_ = false;
  uint32_t material_ = 0;
  uint32_t first_vertex_ = 0;
};

}  // namespace

void drop_unreadable(Document& document, size_t mesh, size_t index) {
  const PrimitiveToStore primitive{mesh, index, glm::dmat4(1.0), INVALID_INDEX};
  tinygltf::Primitive& source = document.model.meshes[mesh].primitives[index];
  try {
    Size ignored;
    add_size(document, primitive, ignored);
  } catch (const Error& error) {
    document.leave_out(error);
    source.attributes.clear();
    return;
  }
  const uint64_t vertices = attribute(document, primitive, "POSITION", TINYGLTF_TYPE_VEC3)->count();
  for (auto entry = source.attributes.begin(); entry != source.attributes.end();) {
    const std::string name = (entry++)->first;
    try {
      const auto reader = optional_attribute(document, primitive, name);
      if (reader && reader->count() != vertices)
        document.fail(fmt::format("{} has {} elements, POSITION has {}; export the file again",
                                  reader->element(), reader->count(), vertices));
    } catch (const Error& error) {
      document.mend(error, "the primitive without it");
      source.attributes.erase(name);
    }
  }
}

bool is_drawn(const tinygltf::Primitive& primitive) {
  return is_triangle_mode(primitive.mode) && primitive.attributes.count("POSITION") != 0;
}

void add_size(const Document& document, const PrimitiveToStore& instance, Size& size) {
  const auto& attributes = primitive_of(document, instance).attributes;
  const AccessorReader positions(document, attributes.at("POSITION"), TINYGLTF_TYPE_VEC3,
                                 instance_name(document, instance) + " POSITION");
  const uint64_t triangles = TriangleList(document, instance, positions.count()).size();
  size.triangles += triangles;
  size.vertices += attributes.count("NORMAL") != 0 ? positions.count() : 3 * triangles;
  size.has_colors = size.has_colors || attributes.count("COLOR_0") != 0;
  const int material = primitive_of(document, instance).material;
  if (material < 0) return;
  const tinygltf::Material& source = document.model.materials[static_cast<size_t>(material)];
  size.has_tangents = size.has_tangents || needs_tangents(source);
  size.uv_sets = std::max(size.uv_sets, material_uvs(source).further_sets.size());
  size.lights += may_emit(source) ? triangles : 0;
}

Box primitive_box(const Document& document, const PrimitiveToStore& primitive) {
  const tinygltf::Primitive& source = primitive_of(document, primitive);
  Box box;
  if (!is_drawn(source)) return box;
  const MorphedAttribute positions = *attribute(document, primitive, "POSITION", TINYGLTF_TYPE_VEC3);
  std::vector<glm::dmat4> skinned;
  SkinTally ignored;
  if (primitive.pose != nullptr && primitive.pose->joints && has_joints(source))
    skinned = skin_vertices(document, source, *primitive.pose->joints, positions.count(),
                            instance_name(document, primitive), ignored);
  for (uint64_t i = 0; i < positions.count(); ++i) {
    const glm::dmat4& to_world = skinned.empty() ? primitive.to_world : skinned[i];
    const glm::dvec3 position(to_world * glm::dvec4(positions.vec3_at(i), 1.0));
    // What is not finite is an error where a triangle uses it.
    if (std::isfinite(position.x + position.y + position.z)) box.add(position);
  }
  return box;
}

bool fits_as_shared(const Document& document, const std::vector<PrimitiveToStore>& primitives) {
  for (const PrimitiveToStore& primitive : primitives) {
    const MorphedAttribute positions = *attribute(document, primitive, "POSITION", TINYGLTF_TYPE_VEC3);
    const uint64_t triangles = TriangleList(document, primitive, positions.count()).size();
    if (positions.count() > std::max(3 * triangles, MANY_VERTICES)) return false;
    for (uint64_t i = 0; i < positions.count(); ++i) {
      const glm::dvec3 p = glm::dvec3(positions.vec3_at(i)) + glm::dvec3(primitive.to_world[3]);
      for (int axis = 0; axis < 3; ++axis)
        if (!(std::fabs(p[axis]) <= double{MAX_COORDINATE})) return false;
    }
  }
  return true;
}

void store_primitive(Document& document, const PrimitiveToStore& primitive, Scene& scene, Tally& tally) {
  PrimitiveBuilder(document, primitive, scene, tally).build();
}

void warn_of(const Tally& tally, Document& document) {
  if (tally.without_area != 0)
    document.warn(
        fmt::format("{} of {} triangles have no area and were dropped", tally.without_area, tally.triangles));
  if (tally.bad_normals != 0)
    document.warn(
        fmt::format("{} vertex normals have no direction; geometric normals are used", tally.bad_normals));
  if (tally.bad_uvs != 0)
    document.warn(fmt::format("{} texture coordinates are not finite; 0 is used", tally.bad_uvs));
  if (tally.bad_tangents != 0)
    document.warn(fmt::format("{} tangents have no direction; others are used", tally.bad_tangents));
  warn_of(tally.skin, document);
  if (tally.bad_colors != 0)
    document.warn(fmt::format("{} vertex colours are not numbers; white is used", tally.bad_colors));
}

}  // namespace regulus::scene
