#include "rays/scene_query.hpp"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "interface/wavefront.h"
#include "rays/triangle_test.hpp"
#include "reference/traversal.hpp"
#include "scene/placement.hpp"

namespace regulus::rays {

using namespace interface;
using glm::vec3;

namespace {

// Direction components below this count as zero, as in shaders/lib/traversal.glsl.
constexpr float MIN_DIRECTION = 1e-18F;

// Geometries of each of Embree's scenes: surfaces that are whole, surfaces that are partly there. In the
// scene of everything the copies of meshes follow.
constexpr uint32_t WHOLE = 0, PARTLY = 1, FIRST_COPY = 2;

bool is_valid(const vec3& origin, const vec3& direction) {
  constexpr float MOST = std::numeric_limits<float>::max();
  const auto within = [](const vec3& v) {
    return std::abs(v.x) <= MOST && std::abs(v.y) <= MOST && std::abs(v.z) <= MOST;
  };
  const vec3 size = glm::abs(direction);
  return within(origin) && within(direction) && std::max({size.x, size.y, size.z}) > MIN_DIRECTION;
}

struct Release {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
};
template <typename Handle>
using Owned = std::unique_ptr<std::remove_pointer_t<Handle>, Release>;

/// The triangles of a geometry: all from `first` on, or those that are listed.
struct Part {
  uint32_t first = 0;
  std::vector<uint32_t> listed;

  uint32_t index_of(uint32_t primitive) const {
    return listed.empty() ? first + primitive : listed[primitive];
  }
};

/// A tree of Embree's over stored triangles.
struct Tree {
  Owned<RTCScene> scene;
  std::array<Part, 2> parts;  ///< by WHOLE, PARTLY
};

/// A triangle where it stands.
struct Target {
  std::array<vec3, 3> corners;
  uint32_t number, tag;
};

/// What Embree's callbacks learn of the ray, which they see in the space of a mesh.
struct Question {
  RTCIntersectContext context;
  const void* impl;
  TriangleTest test;
  vec3 origin, direction;
  float t_max;
};

RTCRay embree_ray(const vec3& origin, const vec3& direction, float t_max) {
  RTCRay ray{};
  ray.org_x = origin.x;
  ray.org_y = origin.y;
  ray.org_z = origin.z;
  ray.dir_x = direction.x;
  ray.dir_y = direction.y;
  ray.dir_z = direction.z;
  ray.tfar = t_max;
  ray.mask = 0xFFFFFFFFu;
  return ray;
}

bool is_in_range(const TriangleTest::Result& result, float t_max) {
  return result.has_area && result.tuv.x > 0 && result.tuv.x <= t_max;
}

/// Barycentrics of the place on the triangle: what Embree's test lets pass at an edge may lie outside by
/// rounding.
glm::vec2 on_triangle(const TriangleTest::Result& result) {
  const float u = std::clamp(result.tuv.y, 0.0F, 1.0F);
  return {u, std::clamp(result.tuv.z, 0.0F, 1 - u)};
}

}  // namespace

struct SceneQuery::Impl {
  const PreparedScene& prepared;
  Owned<RTCDevice> device{rtcNewDevice(nullptr)};
  std::vector<Tree> meshes;
  std::vector<uint32_t> mesh_of_copy;
  Tree world;

  explicit Impl(const PreparedScene& prepared_in) : prepared(prepared_in) {
    const scene::Scene& scene = prepared.scene;
    for (const scene::SharedMesh& mesh : scene.shared_meshes) {
      meshes.push_back(tree_of(mesh.first_triangle, mesh.triangle_count, true));
      rtcCommitScene(meshes.back().scene.get());
    }
    const auto first = static_cast<uint32_t>(scene::first_placed_triangle(scene));
    world = tree_of(first, static_cast<uint32_t>(scene.triangles.size()) - first, false);
    for (const Instance& copy : scene.instances) attach_copy(copy);
    rtcCommitScene(world.scene.get());
    if (const RTCError error = rtcGetDeviceError(device.get()); error != RTC_ERROR_NONE)
      throw Error(ErrorCode::Failed,
                  error == RTC_ERROR_OUT_OF_MEMORY
                      ? "no memory for the acceleration structure of --rays host; use --rays software"
                      : "Embree cannot build the acceleration structure of --rays host; use --rays software");
  }

  Owned<RTCScene> new_scene() const {
    Owned<RTCScene> scene(rtcNewScene(device.get()));
    rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);  // watertight
    return scene;
  }

  /// is_checked: every hit is to be confirmed by our own test, for it is found in another space.
  Tree tree_of(uint32_t first, uint32_t count, bool is_checked) const {
    Tree tree{new_scene(), {}};
    std::array<std::vector<uint32_t>, 2> by_part;
    if ((prepared.features.bits & FEATURE_ALPHA) != 0)
      for (uint32_t i = first; i < first + count; ++i)
        by_part[(prepared.bvh.triangles[i].tag & TRIANGLE_TAG_ALPHA) != 0 ? PARTLY : WHOLE].push_back(i);
    if (by_part[PARTLY].empty()) {
      if (count > 0) attach(tree, WHOLE, {first, {}}, count, is_checked);
      return tree;
    }
    for (const uint32_t part : {WHOLE, PARTLY}) {
      const auto size = static_cast<uint32_t>(by_part[part].size());
      if (size > 0) attach(tree, part, {first, std::move(by_part[part])}, size, is_checked || part == PARTLY);
    }
    return tree;
  }

  void attach(Tree& tree, uint32_t id, Part part, uint32_t count, bool is_checked) const {
    const scene::Scene& scene = prepared.scene;
    const Owned<RTCGeometry> geometry(rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_TRIANGLE));
    rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               scene.vertices.data(), 0, sizeof(Vertex), scene.vertices.size());
    if (part.listed.empty()) {
      rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                 scene.triangles.data() + part.first, 0, sizeof(Triangle), count);
    } else if (auto* corners = static_cast<uint32_t*>(
                   rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                           3 * sizeof(uint32_t), count))) {
      for (const uint32_t i : part.listed) {
        const Triangle& triangle = scene.triangles[i];
        for (const uint32_t corner : {triangle.v0, triangle.v1, triangle.v2}) *corners++ = corner;
      }
    }
    if (is_checked) {
      rtcSetGeometryIntersectFilterFunction(geometry.get(), check_hit);
      rtcSetGeometryOccludedFilterFunction(geometry.get(), check_hit);
    }
    rtcCommitGeometry(geometry.get());
    rtcAttachGeometryByID(tree.scene.get(), geometry.get(), id);
    tree.parts[id] = std::move(part);
  }

  void attach_copy(const Instance& copy) {
    const auto id = static_cast<uint32_t>(mesh_of_copy.size());
    mesh_of_copy.push_back(static_cast<uint32_t>(scene::mesh_index_of(prepared.scene, copy)));
    const Owned<RTCGeometry> geometry(rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_INSTANCE));
    rtcSetGeometryInstancedScene(geometry.get(), meshes[mesh_of_copy.back()].scene.get());
    const std::array<vec3, 4> columns = {copy.x_axis, copy.y_axis, copy.z_axis, copy.translation};
    rtcSetGeometryTransform(geometry.get(), 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns.data());
    rtcCommitGeometry(geometry.get());
    rtcAttachGeometryByID(world.scene.get(), geometry.get(), FIRST_COPY + id);
  }

  Target target_of(uint32_t geometry, uint32_t primitive, uint32_t instance) const {
    const Instance* copy = nullptr;
    const Tree* tree = &world;
    if (instance != RTC_INVALID_GEOMETRY_ID) {
      copy = &prepared.scene.instances[instance - FIRST_COPY];
      tree = &meshes[mesh_of_copy[instance - FIRST_COPY]];
    }
    const uint32_t index = tree->parts[geometry].index_of(primitive);
    const BvhTriangle& triangle = prepared.bvh.triangles[index];
    Target target{{triangle.v0, triangle.v1, triangle.v2}, index, triangle.tag};
    if (copy == nullptr) return target;
    target.number = index - copy->first_triangle + copy->first_number;
    for (vec3& corner : target.corners) corner = scene::placed_position(*copy, corner);
    if (copy->is_mirrored != 0) std::swap(target.corners[1], target.corners[2]);
    return target;
  }

  /// Embree's question whether a hit counts.
  static void check_hit(const RTCFilterFunctionNArguments* arguments) {
    const auto& question = *reinterpret_cast<const Question*>(arguments->context);
    const auto& hit = *reinterpret_cast<const RTCHit*>(arguments->hit);
    const Impl& impl = *static_cast<const Impl*>(question.impl);
    const Target target = impl.target_of(hit.geomID, hit.primID, hit.instID[0]);
    const TriangleTest::Result result = question.test.run(target.corners);
    const bool counts =
        is_in_range(result, question.t_max) &&
        ((target.tag & TRIANGLE_TAG_ALPHA) == 0 ||
         reference::is_covered(impl.prepared.scene, target.number, glm::dvec2(on_triangle(result)),
                               question.origin, question.direction));
    if (!counts) arguments->valid[0] = 0;
  }

  Question question_of(const vec3& origin, const vec3& direction, float t_max) const {
    Question question{{}, this, TriangleTest(origin, direction), origin, direction, t_max};
    rtcInitIntersectContext(&question.context);
    return question;
  }
};

const char* SceneQuery::why_not(const scene::Features& features) {
  if ((features.bits & FEATURE_CONTACTS) != 0) return "solids nest or surfaces touch (feature contacts)";
  if ((features.bits & FEATURE_CLIPPING) != 0) return "a camera has clipping planes (feature clipping)";
  return nullptr;
}

SceneQuery::SceneQuery(const PreparedScene& prepared) : impl_(std::make_unique<Impl>(prepared)) {}
SceneQuery::~SceneQuery() = default;

Hit SceneQuery::closest(const vec3& origin, const vec3& direction, float t_max, uint32_t& tag) const {
  tag = 0;
  if (!is_valid(origin, direction)) return {t_max, 0, 0, INVALID_INDEX};
  Question question = impl_->question_of(origin, direction, t_max);
  RTCRayHit found{embree_ray(origin, direction, t_max), {}};
  found.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  found.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(impl_->world.scene.get(), &question.context, &found);
  if (found.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {t_max, 0, 0, INVALID_INDEX};
  const Target target = impl_->target_of(found.hit.geomID, found.hit.primID, found.hit.instID[0]);
  tag = target.tag;
  const TriangleTest::Result result = question.test.run(target.corners);
  // Seen from so near its plane that our own test finds it behind the ray or without area.
  if (!is_in_range(result, t_max)) return {found.ray.tfar, found.hit.u, found.hit.v, target.number};
  if (result.is_inside) return {result.tuv.x, result.tuv.y, result.tuv.z, target.number};
  const glm::vec2 barycentrics = on_triangle(result);
  return {result.tuv.x, barycentrics.x, barycentrics.y, target.number};
}

bool SceneQuery::is_open(const vec3& origin, const vec3& direction, float t_max) const {
  if (!is_valid(origin, direction) || !(t_max > 0)) return true;
  Question question = impl_->question_of(origin, direction, t_max);
  RTCRay ray = embree_ray(origin, direction, t_max);
  rtcOccluded1(impl_->world.scene.get(), &question.context, &ray);
  return !(ray.tfar < 0);
}

}  // namespace regulus::rays
