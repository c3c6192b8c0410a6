#include "reference/light_choice.hpp"

#include <algorithm>
#include <cmath>

#include "reference/lights.hpp"

namespace regulus::reference {

using glm::dvec2;
using glm::dvec3;
using namespace interface;

namespace {

// A random number has 24 digits; after 12 of them the next number takes over.
constexpr double LAST_OF_FIRST_NUMBER = 1.0 / 4096;
// Share of a node that can send light, at least.
constexpr double LEAST_SHARE = 1.0 / 1048576;

/// Lights in a sphere, whose normals end in a ball.
struct Node {
  dvec3 center;
  double radius;
  dvec3 axis;
  double spread;
  bool is_two_sided;
};

int byte_of(uint32_t word, int i) {
  return static_cast<int>(word >> (8 * i) & 0xFFu);
}

dvec3 vector_of(uint32_t word) {
  return dvec3(byte_of(word, 0) - 128, byte_of(word, 1) - 128, byte_of(word, 2) - 128) / 127.0;
}

/// Bound on what a node sends to the receiver, for an intensity of 1.
double importance(const Node& node, const Receiver& receiver) {
  const dvec3 towards = receiver.position - node.center;
  const double distance = length(towards);
  const double least = std::max({distance, node.radius, 1e-15});
  const double along = dot(node.axis, towards);
  // How high above the plane of a light the receiver can be, and a light above that of the receiver.
  const double height = (node.is_two_sided ? std::abs(along) : along) + node.spread * distance + node.radius;
  const double cos_light = std::clamp(height / least, 0.0, 1.0);
  const double cos_receiver =
      receiver.normal == dvec3(0)
          ? 1
          : std::clamp((dot(receiver.normal, -towards) + node.radius) / least, 0.0, 1.0);
  return cos_light * cos_receiver / (least * least);
}

/// A walk down the tree, pair by pair.
class TreeWalk {
 public:
  TreeWalk(const World& world, const Receiver& receiver)
      : tree_(world.scene().light_tree), receiver_(receiver), center_(tree_.center), radius_(tree_.radius) {}

  bool is_at_light() const { return (child_ & LIGHT_PAIR_LEAF) != 0; }
  uint32_t light() const { return child_ & ~LIGHT_PAIR_LEAF; }

  /// Probability of the first node, or nothing if neither can light the receiver.
  std::optional<double> first_share() const {
    const double share = pair().first_share;
    if (is_fixed()) return share;
    const double first = share * importance(node(0), receiver_);
    const double second = (1 - share) * importance(node(1), receiver_);
    if (!(first + second > 0)) return std::nullopt;
    const double proportion = first / (first + second);
    return first > 0 && second > 0 ? std::clamp(proportion, LEAST_SHARE, 1 - LEAST_SHARE) : proportion;
  }

  void descend(int i) {
    if (!is_fixed()) {
      const Node next = node(i);
      center_ = next.center;
      radius_ = next.radius;
    }
    child_ = pair().children[i];
  }

 private:
  const LightPair& pair() const { return tree_.pairs[child_]; }
  bool is_fixed() const { return (pair().flags & LIGHT_PAIR_FIXED) != 0; }
  Node node(int i) const {
    const uint32_t place = pair().places[i];
    const uint32_t normals = pair().normals[i];
    return {center_ + radius_ * vector_of(place), radius_ * byte_of(place, 3) / 255, vector_of(normals),
            2.0 * byte_of(normals, 3) / 255, (pair().flags & LIGHT_PAIR_TWO_SIDED << i) != 0};
  }

  const scene::LightTree& tree_;
  const Receiver& receiver_;
  dvec3 center_;
  double radius_;
  uint32_t child_ = 0;
};

std::optional<uint32_t> choose_by_tree(const World& world, const Receiver& receiver, const dvec2& u) {
  double number = u.x;
  double probability = 1;
  bool is_first_number = true;
  TreeWalk walk(world, receiver);
  while (!walk.is_at_light()) {
    const std::optional<double> share = walk.first_share();
    if (!share) return std::nullopt;
    const bool takes_first = number < *share;
    const double taken = takes_first ? *share : 1 - *share;
    number = (takes_first ? number : number - *share) / taken;
    probability *= taken;
    if (is_first_number && probability < LAST_OF_FIRST_NUMBER) {
      number = u.y;
      is_first_number = false;
    }
    walk.descend(takes_first ? 0 : 1);
  }
  return walk.light();
}

double tree_probability(const World& world, const Receiver& receiver, uint32_t light) {
  double probability = 1;
  TreeWalk walk(world, receiver);
  for (uint32_t trail = world.scene().light_tree.trails[light]; !walk.is_at_light(); trail >>= 1) {
    const std::optional<double> share = walk.first_share();
    if (!share) return 0;
    const bool takes_second = (trail & 1) != 0;
    probability *= takes_second ? 1 - *share : *share;
    walk.descend(takes_second ? 1 : 0);
  }
  return probability;
}

}  // namespace

Receiver receiver_at(const World& world, const Surface& surface, const dvec3& w_light) {
  Receiver receiver{surface.position};
  if (world.scene().materials[surface.material].material_class != MATERIAL_CLASS_TRANSMISSIVE) {
    const double side = dot(w_light, surface.geometric_normal) > 0 ? 1 : -1;
    // Where a surface bulges the shading normal decides about light.
    receiver.normal = side * (side * surface.bulge > 0 ? surface.shading_normal : surface.geometric_normal);
  }
  return receiver;
}

double choice_probability(const World& world, const Receiver& receiver, uint32_t light) {
  switch (world.light_sampling()) {
    case LIGHT_SAMPLING_BVH:
      return tree_probability(world, receiver, light);
    case LIGHT_SAMPLING_UNIFORM:
      return 1.0 / static_cast<double>(world.scene().lights.size());
    default:
      return world.scene().lights[light].selection_pdf;
  }
}

std::optional<uint32_t> choose_light(const World& world, const Receiver& receiver, const dvec2& u) {
  switch (world.light_sampling()) {
    case LIGHT_SAMPLING_BVH:
      return choose_by_tree(world, receiver, u);
    case LIGHT_SAMPLING_UNIFORM: {
      // In single precision, like every decision.
      const auto count = static_cast<uint32_t>(world.scene().lights.size());
      const float place = static_cast<float>(u.x) * static_cast<float>(count);
      return std::min(static_cast<uint32_t>(place), count - 1);
    }
    default:
      return select_light(world.scene(), u);
  }
}

}  // namespace regulus::reference
