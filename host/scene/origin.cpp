#include "scene/origin.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "base/components.hpp"
#include "scene/placement.hpp"
#include "scene/primitive.hpp"

namespace regulus::scene {
namespace {

using glm::dvec3;

// Share of a mesh's extent whose loss is worth a warning.
constexpr double NOTABLE_LOSS = 1e-3;

/// Distance of neighbouring floats at `value`.
double float_spacing(double value) {
  return value > 0 ? std::ldexp(1.0, std::ilogb(value) - 23) : 0;
}

/// The mesh that loses most, and how many lose notably.
struct Loss {
  size_t mesh = 0, count = 0;
  double share = 0;  // of its extent
  double reach = 0, spacing = 0;

  void add(size_t index, const Box& box) {
    const double size = box.extent(), distance = box.reach(), step = float_spacing(distance);
    if (!(step > NOTABLE_LOSS * size)) return;
    ++count;
    const double own_share = std::min(size > 0 ? step / size : 1, 1.0);
    if (own_share > share) *this = {index, count, own_share, distance, step};
  }

  /// "mesh 3 'chair' (the worst of 7)"
  std::string name(const Document& document) const {
    const std::string own = element_name("mesh", mesh, document.model.meshes[mesh].name);
    return count > 1 ? fmt::format("{} (the worst of {})", own, count) : own;
  }
};

}  // namespace

void Box::add(const dvec3& point) {
  lower = min(lower, point);
  upper = max(upper, point);
}

void Box::add(const Box& box) {
  lower = min(lower, box.lower);
  upper = max(upper, box.upper);
}

double Box::extent() const {
  return is_empty() ? 0 : largest_magnitude(upper - lower);
}

double Box::reach() const {
  return is_empty() ? 0 : std::max(largest_magnitude(lower), largest_magnitude(upper));
}

Box Box::placed(const glm::dmat4& transform) const {
  if (is_empty()) return {};
  const glm::dmat3 axes(transform);
  const dvec3 half = 0.5 * (upper - lower), middle = axes * center() + dvec3(transform[3]);
  const dvec3 around = abs(axes[0]) * half.x + abs(axes[1]) * half.y + abs(axes[2]) * half.z;
  return {middle - around, middle + around};
}

PlacedBoxes::PlacedBoxes(const Document& document, const std::vector<PlacedNode>& places)
    : document_(document), places_(places), meshes_(document.model.meshes.size()) {
  for (size_t i = 0; i < places.size(); ++i) {
    const PlacedNode& place = places[i];
    const auto [entry, is_new] = posed_.try_emplace({mesh_of(place), place.pose.get()});
    if (is_new) {
      const MeshPose unskinned{place.pose ? place.pose->weights : std::vector<double>(), nullptr};
      entry->second = around(place, glm::dmat4(1.0), &unskinned);
      meshes_[mesh_of(place)].add(entry->second);
    }
    if (place.pose && place.pose->joints) skinned_[i] = around(place, place.to_world, place.pose.get());
  }
}

size_t PlacedBoxes::mesh_of(const PlacedNode& place) const {
  return static_cast<size_t>(document_.model.nodes[place.node].mesh);
}

Box PlacedBoxes::around(const PlacedNode& place, const glm::dmat4& to_world, const MeshPose* pose) const {
  Box box;
  const size_t mesh = mesh_of(place);
  for (size_t i = 0; i < document_.model.meshes[mesh].primitives.size(); ++i)
    box.add(primitive_box(document_, {mesh, i, to_world, interface::INVALID_INDEX, pose}));
  return box;
}

Box PlacedBoxes::at(size_t place) const {
  const auto skinned = skinned_.find(place);
  if (skinned != skinned_.end()) return skinned->second;
  const PlacedNode& placed = places_[place];
  return posed_.at({mesh_of(placed), placed.pose.get()}).placed(placed.to_world);
}

Box PlacedBoxes::all() const {
  Box box;
  for (size_t i = 0; i < places_.size(); ++i) box.add(at(i));
  return box;
}

dvec3 choose_origin(const Box& box) {
  const double extent = box.extent(), distance = extent > 0 ? largest_magnitude(box.center()) : 0;
  if (!(distance > FAR_IN_EXTENTS * extent) && !(box.reach() > double{MAX_COORDINATE})) return dvec3(0);
  const double unit = std::exp2(std::ceil(std::log2(extent)));
  return extent > 0 ? unit * round(box.center() / unit) : dvec3(0);
}

void take_off(const dvec3& origin, std::vector<PlacedNode>& nodes) {
  const glm::dvec4 by(origin, 0);
  std::map<const MeshPose*, std::shared_ptr<const MeshPose>> moved;  // equal poses stay one object
  for (PlacedNode& placed : nodes) {
    placed.to_world[3] -= by;
    if (!placed.pose || !placed.pose->joints) continue;
    std::shared_ptr<const MeshPose>& own = moved[placed.pose.get()];
    if (!own) {
      auto joints = std::make_shared<JointMatrices>(*placed.pose->joints);
      for (glm::dmat4& joint : *joints) joint[3] -= by;
      own = std::make_shared<const MeshPose>(MeshPose{placed.pose->weights, joints});
    }
    placed.pose = own;
  }
}

void require_fitting_extent(const Document& document, const Box& box) {
  if (!(box.extent() <= 2 * double{MAX_COORDINATE}))
    document.fail(fmt::format(
        "the scene is {:.3g} units wide, more than the {:g} that single precision can compute with; "
        "scale it down, or remove what is so far away",
        box.extent(), 2 * double{MAX_COORDINATE}));
}

void warn_of_rounding(Document& document, const std::vector<PlacedNode>& places, const PlacedBoxes& boxes,
                      const dvec3& origin) {
  Loss in_file, in_scene;
  for (size_t mesh = 0; mesh < boxes.meshes().size(); ++mesh) in_file.add(mesh, boxes.meshes()[mesh]);
  for (size_t i = 0; i < places.size(); ++i) {
    const Box box = boxes.at(i);
    in_scene.add(static_cast<size_t>(document.model.nodes[places[i].node].mesh),
                 {box.lower - origin, box.upper - origin});
  }
  if (in_file.count > 0)
    document.warn(fmt::format(
        "{}: its vertices lie up to {:.3g} units from its own origin, where the file's floats are "
        "multiples of {:.2g}, {:.2g} % of its size; export it with a translation of its node",
        in_file.name(document), in_file.reach, in_file.spacing, 100 * in_file.share));
  if (in_scene.count > 0)
    document.warn(fmt::format(
        "{}: lies {:.3g} units from the scene's centre, where single precision holds multiples of "
        "{:.2g}, {:.2g} % of its size; remove what is far from it, or scale neither so small",
        in_scene.name(document), in_scene.reach, in_scene.spacing, 100 * in_scene.share));
}

}  // namespace regulus::scene
