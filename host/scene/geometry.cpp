#include "scene/geometry.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>

#include "base/error.hpp"
#include "interface/bvh.h"
#include "scene/material.hpp"
#include "scene/placement.hpp"
#include "scene/primitive.hpp"
#include "scene/uv_mapping.hpp"

namespace regulus::scene {
namespace {

using interface::INVALID_INDEX;

// What a triangle takes in the tree, and what a copy does, there and beside it.
constexpr uint64_t BYTES_IN_TREE = sizeof(interface::BvhTriangle) + 20;
constexpr uint64_t BYTES_OF_COPY = sizeof(interface::Instance) + 40;
// A mesh that would gain less is not worth the detour.
constexpr uint64_t LEAST_GAIN = uint64_t{64} << 10;

// These take about 100 MB with their tree.
constexpr uint64_t MOST_TRIANGLES_OF_COPIED_SOLIDS = uint64_t{1} << 19;

size_t mesh_index(const Document& document, const PlacedNode& placed) {
  return static_cast<size_t>(document.model.nodes[placed.node].mesh);
}

bool is_skinned(const PlacedNode& place) {
  return place.pose && place.pose->joints;
}

bool emits(const Document& document, const tinygltf::Primitive& primitive) {
  return primitive.material >= 0 &&
         may_emit(document.model.materials[static_cast<size_t>(primitive.material)]);
}

bool refracts(const Document& document, const tinygltf::Primitive& primitive) {
  return primitive.material >= 0 &&
         may_refract(document.model.materials[static_cast<size_t>(primitive.material)]);
}

/// Makes the colours one per vertex, or none if all are white, as many exporters write them.
void complete_colors(Scene& scene) {
  auto& colors = scene.vertex_colors;
  const bool has_colors =
      std::any_of(colors.begin(), colors.end(), [](const glm::vec4& c) { return c != glm::vec4(1); });
  colors.resize(has_colors ? scene.vertices.size() : 0, glm::vec4(1));
  colors.shrink_to_fit();
}

void warn_of_skipped(Document& document, const std::vector<PlacedNode>& places) {
  uint64_t skipped = 0;
  for (const PlacedNode& placed : places) {
    const auto& primitives = document.model.meshes[mesh_index(document, placed)].primitives;
    // Those that are left out have lost all attributes, and were named.
    skipped +=
        static_cast<uint64_t>(std::count_if(primitives.begin(), primitives.end(), [](const auto& primitive) {
          return !is_drawn(primitive) && !primitive.attributes.empty();
        }));
  }
  if (skipped != 0)
    document.warn(
        fmt::format("{} primitives are points, lines or without positions and are skipped", skipped));
}

bool fits_memory(const Document& document, const Size& size) {
  return size.triangles < (uint64_t{1} << 31) && size.vertices < INVALID_INDEX &&
         size.bytes_to_prepare() <= document.files.free_bytes();
}

/// Counts before anything is allocated.
void require_memory(Document& document, const std::vector<PrimitiveToStore>& instances, Scene& scene) {
  Size size;
  size.has_colors = !scene.vertex_colors.empty();
  for (const PrimitiveToStore& instance : instances) add_size(document, instance, size);
  document.hold(size.bytes_to_prepare(), fmt::format("geometry of {} triangles", size.triangles));
  if (scene.triangles.size() + size.triangles >= (uint64_t{1} << 31) ||
      scene.vertices.size() + size.vertices >= INVALID_INDEX)
    document.fail("more than 2^31 triangles or 2^32 vertices after instancing; reduce the scene");
  scene.triangles.reserve(scene.triangles.size() + size.triangles);
  scene.vertices.reserve(scene.vertices.size() + size.vertices);
}

/// How a mesh is stored if its copies share it.
struct SharedForm {
  const MeshPose* pose = nullptr;  ///< that of its first place without a skin
  glm::dvec3 origin{0};            ///< taken off in its own space
  bool shares_solids = false;      ///< what refracts is shared too, see share_many_solids()
};

/// Whether each copy stores a primitive of its own: emitters are lights, what refracts bounds solids.
bool is_stored_apart(const Document& document, const tinygltf::Primitive& primitive, const SharedForm& form) {
  return emits(document, primitive) || (!form.shares_solids && refracts(document, primitive));
}

/// By mesh of the file. `boxes` are around the meshes in their own spaces.
std::vector<SharedForm> forms_to_share(const Document& document, const std::vector<PlacedNode>& places,
                                       const std::vector<Box>& boxes) {
  std::vector<SharedForm> forms(boxes.size());
  for (size_t i = places.size(); i-- > 0;)
    if (!is_skinned(places[i])) forms[mesh_index(document, places[i])].pose = places[i].pose.get();
  for (size_t mesh = 0; mesh < boxes.size(); ++mesh) forms[mesh].origin = choose_origin(boxes[mesh]);
  return forms;
}

bool is_in_form(const Document& document, const PlacedNode& place, const std::vector<SharedForm>& forms) {
  return !is_skinned(place) && place.pose.get() == forms[mesh_index(document, place)].pose;
}

/// The primitives of a mesh that can be shared, to be stored in its own space.
std::vector<PrimitiveToStore> sharable_primitives(const Document& document, size_t mesh,
                                                  const SharedForm& form) {
  std::vector<PrimitiveToStore> result;
  const auto& primitives = document.model.meshes[mesh].primitives;
  for (size_t i = 0; i < primitives.size(); ++i)
    if (is_drawn(primitives[i]) && !is_stored_apart(document, primitives[i], form))
      result.push_back({mesh, i, glm::translate(glm::dmat4(1.0), -form.origin), INVALID_INDEX, form.pose});
  return result;
}

/// By mesh: how many of its places have the shared form.
std::vector<uint64_t> count_copies(const Document& document, const std::vector<PlacedNode>& places,
                                   const std::vector<SharedForm>& forms) {
  std::vector<uint64_t> copies(forms.size(), 0);
  for (const PlacedNode& placed : places)
    if (is_in_form(document, placed, forms)) ++copies[mesh_index(document, placed)];
  return copies;
}

/// Copies of what refracts are stored each on its own, so that each is a solid that others may touch or hold,
/// as long as all together have no more than MOST_TRIANGLES_OF_COPIED_SOLIDS. Of more, they share too: a
/// forest of glass then takes no more memory than one of wood, and its faces alone tell its inside from its
/// outside.
void share_many_solids(const Document& document, const std::vector<PlacedNode>& places,
                       std::vector<SharedForm>& forms) {
  const std::vector<uint64_t> copies = count_copies(document, places, forms);
  uint64_t triangles = 0;
  for (size_t mesh = 0; mesh < forms.size(); ++mesh) {
    const auto& primitives = document.model.meshes[mesh].primitives;
    Size size;
    for (size_t i = 0; i < primitives.size() && copies[mesh] > 1; ++i)
      if (is_drawn(primitives[i]) && !emits(document, primitives[i]) && refracts(document, primitives[i]))
        add_size(document, {mesh, i, glm::dmat4(1.0), INVALID_INDEX, forms[mesh].pose}, size);
    triangles += copies[mesh] * size.triangles;
  }
  for (SharedForm& form : forms) form.shares_solids = triangles > MOST_TRIANGLES_OF_COPIED_SOLIDS;
}

/// By mesh: whether it is stored once for its copies. Those that are, are chosen together: the gain must be
/// worth it.
std::vector<bool> choose_shared_meshes(const Document& document, const std::vector<PlacedNode>& places,
                                       const std::vector<SharedForm>& forms, uint64_t sharing_gain) {
  const std::vector<uint64_t> copies = count_copies(document, places, forms);
  std::vector<bool> is_shared(copies.size(), false);
  uint64_t total = 0;
  for (size_t mesh = 0; mesh < copies.size(); ++mesh) {
    if (copies[mesh] < 2) continue;
    Size size;
    const std::vector<PrimitiveToStore> primitives = sharable_primitives(document, mesh, forms[mesh]);
    for (const PrimitiveToStore& primitive : primitives) add_size(document, primitive, size);
    if (size.triangles == 0 || !fits_memory(document, size)) continue;
    const uint64_t saved = (copies[mesh] - 1) * (size.bytes() + size.triangles * BYTES_IN_TREE);
    const uint64_t cost = copies[mesh] * BYTES_OF_COPY;
    if (sharing_gain > 0 && saved < cost + std::min(LEAST_GAIN, sharing_gain)) continue;
    if (!fits_as_shared(document, primitives)) continue;
    is_shared[mesh] = true;
    total += saved > cost ? saved - cost : 0;
  }
  if (total < sharing_gain) is_shared.assign(is_shared.size(), false);
  return is_shared;
}

template <typename T>
void shorten(std::vector<T>& values, size_t size) {
  values.resize(std::min(values.size(), size));
}

/// Stores primitives and places copies.
class GeometryBuilder {
 public:
  /// @param forms by mesh, see forms_to_share()
  GeometryBuilder(Document& document, Scene& scene, const std::vector<SharedForm>& forms)
      : document_(document), scene_(scene), forms_(forms) {}

  /// Stores the chosen meshes. Call before anything else is stored.
  void store_shared_meshes(const std::vector<bool>& is_shared) {
    stored_.resize(is_shared.size());
    std::vector<PrimitiveToStore> all;
    for (size_t mesh = 0; mesh < is_shared.size(); ++mesh)
      if (is_shared[mesh])
        for (const PrimitiveToStore& primitive : sharable_primitives(document_, mesh, forms_[mesh]))
          all.push_back(primitive);
    require_memory(document_, all, scene_);
    for (size_t mesh = 0; mesh < is_shared.size(); ++mesh) {
      if (!is_shared[mesh]) continue;
      const auto first = static_cast<uint32_t>(scene_.triangles.size());
      for (const PrimitiveToStore& primitive : sharable_primitives(document_, mesh, forms_[mesh]))
        store(primitive);
      const SharedMesh stored{first, static_cast<uint32_t>(scene_.triangles.size()) - first};
      if (stored.triangle_count == 0) continue;
      stored_[mesh] = {stored, extent_of(scene_, stored)};
      scene_.shared_meshes.push_back(stored);
    }
  }

  /// Places copies, and stores in world space what is none.
  void store_places(const std::vector<PlacedNode>& places) {
    document_.hold(2 * count_primitives(places) * sizeof(PrimitiveToStore),
                   "the list of primitives in place");
    std::vector<PrimitiveToStore> rest;
    for (uint32_t place = 0; place < places.size(); ++place) {
      const size_t mesh = mesh_index(document_, places[place]);
      const bool is_copy =
          is_in_form(document_, places[place], forms_) && place_copy(mesh, places[place].to_world, place);
      const auto& primitives = document_.model.meshes[mesh].primitives;
      for (size_t i = 0; i < primitives.size(); ++i)
        if (is_drawn(primitives[i]) && (!is_copy || is_stored_apart(document_, primitives[i], forms_[mesh])))
          rest.push_back({mesh, i, places[place].to_world, place, places[place].pose.get()});
    }
    require_memory(document_, rest, scene_);
    for (const PrimitiveToStore& instance : rest) store(instance);
    if (!number_instances(scene_))
      document_.fail("more than 2^32 triangles with those of copies; reduce the scene");
  }

  const Tally& tally() const { return tally_; }

 private:
  struct Stored {
    SharedMesh mesh{};
    MeshExtent extent{};
  };

  /// What cannot be read is left out whole.
  void store(const PrimitiveToStore& primitive) {
    const size_t vertices = scene_.vertices.size();
    const size_t triangles = scene_.triangles.size();
    try {
      store_primitive(document_, primitive, scene_, tally_);
    } catch (const Error& error) {
      document_.leave_out(error);
      scene_.vertices.resize(vertices);
      scene_.triangles.resize(triangles);
      // These may end before the last vertex: only what is there.
      shorten(scene_.vertex_colors, vertices);
      shorten(scene_.vertex_uvs, vertices * scene_.vertex_uv_sets);
      shorten(scene_.vertex_tangents, vertices);
    }
  }

  uint64_t count_primitives(const std::vector<PlacedNode>& places) const {
    uint64_t count = 0;
    for (const PlacedNode& placed : places)
      count += document_.model.meshes[mesh_index(document_, placed)].primitives.size();
    return count;
  }

  bool place_copy(size_t mesh, const glm::dmat4& to_world, uint32_t place) {
    const Stored& stored = stored_[mesh];
    if (stored.mesh.triangle_count == 0) return false;
    const auto copy =
        place_mesh(stored.mesh, stored.extent, glm::translate(to_world, forms_[mesh].origin), place);
    if (copy) scene_.instances.push_back(*copy);
    return copy.has_value();
  }

  Document& document_;
  Scene& scene_;
  const std::vector<SharedForm>& forms_;
  Tally tally_;
  std::vector<Stored> stored_;  // by mesh of the file
};

}  // namespace

void drop_unreadable(Document& document, const std::vector<PlacedNode>& places) {
  std::vector<bool> is_seen(document.model.meshes.size(), false);
  for (const PlacedNode& placed : places) {
    const size_t mesh = mesh_index(document, placed);
    if (is_seen[mesh]) continue;
    is_seen[mesh] = true;
    const auto& primitives = document.model.meshes[mesh].primitives;
    for (size_t i = 0; i < primitives.size(); ++i)
      if (is_drawn(primitives[i])) drop_unreadable(document, mesh, i);
  }
}

void require_vertices(Document& document, const std::vector<PlacedNode>& places) {
  std::vector<bool> is_seen(document.model.meshes.size(), false);
  uint64_t vertices = 0;
  for (const PlacedNode& placed : places) {
    const size_t mesh = mesh_index(document, placed);
    if (is_seen[mesh]) continue;
    is_seen[mesh] = true;
    for (const tinygltf::Primitive& primitive : document.model.meshes[mesh].primitives)
      if (is_drawn(primitive))
        vertices += document.model.accessors[static_cast<size_t>(primitive.attributes.at("POSITION"))].count;
  }
  const uint64_t held = document.files.held_bytes();
  document.hold(vertices * sizeof(interface::Vertex), fmt::format("{} vertices", vertices));
  document.files.release_to(held);
}

void add_geometry(Document& document, const std::vector<PlacedNode>& places, const std::vector<Box>& boxes,
                  uint64_t sharing_gain, Scene& scene) {
  warn_of_skipped(document, places);
  for (const tinygltf::Material& material : document.model.materials)
    scene.vertex_uv_sets =
        std::max(scene.vertex_uv_sets, static_cast<uint32_t>(material_uvs(material).further_sets.size()));
  std::vector<SharedForm> forms = forms_to_share(document, places, boxes);
  share_many_solids(document, places, forms);
  GeometryBuilder builder(document, scene, forms);
  builder.store_shared_meshes(choose_shared_meshes(document, places, forms, sharing_gain));
  builder.store_places(places);
  complete_colors(scene);
  scene.vertex_uvs.resize(scene.vertices.size() * scene.vertex_uv_sets, glm::vec2(0));
  if (!scene.vertex_tangents.empty())
    scene.vertex_tangents.resize(scene.vertices.size(), glm::vec4(1, 0, 0, 1));
  warn_of(builder.tally(), document);
}

}  // namespace regulus::scene
