#include "scene/light_tree.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <span>

#include "interface/wavefront.h"

namespace regulus::scene {
namespace {

using glm::dvec3;

using std::numbers::pi;
constexpr int MAX_BUCKETS = 12;

double angle_between(const dvec3& a, const dvec3& b) {
  return 2 * std::atan2(length(a - b), length(a + b));
}

/// A unit vector at right angles to v.
dvec3 any_orthogonal(const dvec3& v) {
  return normalize(std::abs(v.x) > 0.5 ? cross(v, dvec3(0, 1, 0)) : cross(v, dvec3(1, 0, 0)));
}

// ---- nodes as they are stored

/// A sphere as walks know it, in single precision.
struct Sphere {
  glm::vec3 center{0};
  float radius = 0;
};

constexpr double BYTE_CENTER = 128, BYTE_SCALE = 127, BYTE_MAX = 255;
// Part of the coordinates by which a sphere is enlarged for the roundings of a walk down the tree.
constexpr double SLACK = 8 * 0x1p-24;

uint32_t pack_bytes(const glm::dvec4& bytes) {
  const glm::uvec4 b(bytes);
  return b.x | b.y << 8 | b.z << 16 | b.w << 24;
}

dvec3 signed_bytes(const dvec3& v) {
  return glm::clamp(glm::round(v * BYTE_SCALE) + BYTE_CENTER, dvec3(0), dvec3(BYTE_MAX));
}

/// Radius of the sphere around a centre that holds the box.
double radius_around(const dvec3& center, const LightBounds& bounds) {
  const dvec3 reach = glm::max(bounds.upper - center, center - bounds.lower);
  const dvec3 size = glm::max(abs(bounds.lower), abs(bounds.upper));
  return length(reach) * (1 + SLACK) + SLACK * std::max({size.x, size.y, size.z});
}

/// LightPair::places of a node, and its sphere. A node that does not fit into a smaller sphere has its
/// parent's.
std::pair<uint32_t, Sphere> place_of(const LightBounds& bounds, const Sphere& parent) {
  if (!(parent.radius > 0)) return {pack_bytes({BYTE_CENTER, BYTE_CENTER, BYTE_CENTER, BYTE_MAX}), parent};
  const dvec3 offset = 0.5 * (bounds.lower + bounds.upper) - dvec3(parent.center);
  const dvec3 bytes = signed_bytes(offset / double{parent.radius});
  const dvec3 center = dvec3(parent.center) + (bytes - BYTE_CENTER) / BYTE_SCALE * double{parent.radius};
  const double radius_byte = std::ceil(radius_around(center, bounds) / parent.radius * BYTE_MAX);
  if (!(radius_byte < BYTE_MAX))
    return {pack_bytes({BYTE_CENTER, BYTE_CENTER, BYTE_CENTER, BYTE_MAX}), parent};
  const Sphere sphere{glm::vec3(center), static_cast<float>(radius_byte / BYTE_MAX * parent.radius)};
  return {pack_bytes({bytes, radius_byte}), sphere};
}

/// LightPair::normals: a unit vector within the cone is no farther from its axis than the chord.
uint32_t normals_of(const LightBounds& bounds) {
  const dvec3 bytes = signed_bytes(bounds.axis);
  const double moved = length((bytes - BYTE_CENTER) / BYTE_SCALE - bounds.axis);
  const double ball = 2 * std::sin(0.5 * bounds.theta_o) + moved + SLACK;
  return pack_bytes({bytes, std::min(std::ceil(0.5 * ball * BYTE_MAX), BYTE_MAX)});
}

/// Neither of two nodes is lost to rounding.
float rounded_share(double share) {
  return static_cast<float>(std::clamp(share, 0x1p-24, 1 - 0x1p-24));
}

// ---- where to split

/// Sums over lights that can be added and tell roughly how their normals spread: a cone of half angle theta
/// filled evenly has a mean normal of length (1 + cos theta) / 2.
struct SplitSide {
  dvec3 lower{std::numeric_limits<double>::infinity()}, upper{-std::numeric_limits<double>::infinity()};
  dvec3 axis{0};  // sum of intensity * mean normal
  double intensity = 0, theta_e = 0;
  size_t count = 0;
  bool is_two_sided = false;

  void add(const SplitSide& other) {
    lower = glm::min(lower, other.lower);
    upper = glm::max(upper, other.upper);
    axis += other.axis;
    intensity += other.intensity;
    theta_e = std::max(theta_e, other.theta_e);
    count += other.count;
    is_two_sided = is_two_sided || other.is_two_sided;
  }

  /// Intensity times solid angle lit times surface (Conty Estevez and Kulla, section 4.4).
  double cost() const {
    const double cos_o = std::clamp(2 * length(axis) / intensity - 1, -1.0, 1.0);
    const double theta_o = std::acos(cos_o);
    const double sin_o = std::sqrt(1 - cos_o * cos_o);
    const double theta_w = std::min(theta_o + theta_e, pi);
    const double omega =
        2 * pi * (1 - cos_o) +
        pi / 2 * (2 * theta_w * sin_o - std::cos(theta_o - 2 * theta_w) - 2 * theta_o * sin_o + cos_o);
    const dvec3 e = upper - lower;
    // Lights on one line have no surface, but are better split where they are far apart.
    return intensity * omega * (e.x * e.y + e.y * e.z + e.z * e.x + 1e-3 * dot(e, e));
  }
};

struct Item {
  uint32_t light;
  dvec3 center;
  SplitSide side;
};

struct Split {
  int axis = 0;
  double position = 0;  // centres below go to the first side
  double cost = std::numeric_limits<double>::infinity();
};

Split best_split(std::span<const Item> items, const dvec3& lower, const dvec3& upper) {
  const int buckets = std::min(MAX_BUCKETS, static_cast<int>(items.size()));
  const dvec3 extent = upper - lower;
  const double longest = std::max({extent.x, extent.y, extent.z});
  Split best;
  for (int axis = 0; axis < 3; ++axis) {
    if (!(extent[axis] > 1e-6 * longest)) continue;
    std::array<SplitSide, MAX_BUCKETS> bucket{};
    const double scale = buckets / extent[axis];
    for (const Item& item : items) {
      const int b = static_cast<int>((item.center[axis] - lower[axis]) * scale);
      bucket[static_cast<size_t>(std::clamp(b, 0, buckets - 1))].add(item.side);
    }
    std::array<double, MAX_BUCKETS> above{};
    SplitSide side;
    for (int b = buckets - 1; b > 0; --b) {
      side.add(bucket[static_cast<size_t>(b)]);
      above[static_cast<size_t>(b)] = side.count == 0 ? 0 : side.cost();
    }
    side = {};
    for (int b = 1; b < buckets; ++b) {
      side.add(bucket[static_cast<size_t>(b - 1)]);
      if (side.count == 0 || side.count == items.size()) continue;
      // Thin slices of a long box are split across its length.
      const double cost = (side.cost() + above[static_cast<size_t>(b)]) * longest / extent[axis];
      if (cost < best.cost) best = {axis, lower[axis] + b / scale, cost};
    }
  }
  return best;
}

// ---- the tree

class Builder {
 public:
  explicit Builder(const std::vector<TreeLight>& lights) : lights_(lights) {
    tree_.trails.resize(lights.size(), 0);
    for (uint32_t i = 0; i < lights.size(); ++i) {
      if (lights[i].is_distant)
        distant_.push_back(i);
      else
        items_.push_back(item_of(i));
    }
  }

  LightTree build() {
    if (lights_.size() < 2) return {};
    tree_.pairs.reserve(lights_.size() - 1);
    bounds_.reserve(lights_.size() - 1);
    if (items_.empty()) {
      add_distant_pair(distant_, 0, 0);
      return std::move(tree_);
    }
    LightBounds all;
    uint32_t first_pair = 0;
    if (distant_.empty()) {
      all = add_pair(items_, 0, 0).bounds;
    } else {
      new_pair();
      const double count = static_cast<double>(distant_.size());
      const uint32_t distant = distant_child(distant_, 1, 0);
      const Child near = finite_child(items_, 1, 1);
      set_fixed(0, count / (count + 1), distant, near.word);
      all = near.bounds;
      first_pair = near.word;
    }
    tree_.center = glm::vec3(0.5 * (all.lower + all.upper));
    tree_.radius = static_cast<float>(radius_around(dvec3(tree_.center), all) * (1 + SLACK));
    if ((first_pair & interface::LIGHT_PAIR_LEAF) == 0) encode(first_pair, {tree_.center, tree_.radius});
    return std::move(tree_);
  }

 private:
  struct Child {
    LightBounds bounds;
    uint32_t word;  // of LightPair::children
  };

  static Item item_of(uint32_t light, const LightBounds& bounds) {
    SplitSide side;
    side.lower = bounds.lower;
    side.upper = bounds.upper;
    side.axis = bounds.intensity * 0.5 * (1 + std::cos(bounds.theta_o)) * bounds.axis;
    side.intensity = bounds.intensity;
    side.theta_e = bounds.theta_e;
    side.count = 1;
    side.is_two_sided = bounds.is_two_sided;
    return {light, 0.5 * (bounds.lower + bounds.upper), side};
  }
  Item item_of(uint32_t light) const { return item_of(light, lights_[light].bounds); }

  uint32_t new_pair() {
    tree_.pairs.push_back({});
    bounds_.push_back({});
    return static_cast<uint32_t>(tree_.pairs.size() - 1);
  }

  /// A leaf or a pair over the items: `trail` leads there in `depth` steps.
  Child finite_child(std::span<Item> items, uint32_t depth, uint32_t trail) {
    if (items.size() > 1) return add_pair(items, depth, trail);
    const uint32_t light = items.front().light;
    tree_.trails[light] = trail;
    return {lights_[light].bounds, light | interface::LIGHT_PAIR_LEAF};
  }

  /// All of the pair but what encode() fills.
  Child add_pair(std::span<Item> items, uint32_t depth, uint32_t trail) {
    const uint32_t index = new_pair();
    const size_t middle = split(items, depth);
    const Child first = finite_child(items.first(middle), depth + 1, trail);
    const Child second = finite_child(items.subspan(middle), depth + 1, trail | 1u << depth);
    const double intensity = first.bounds.intensity + second.bounds.intensity;
    interface::LightPair& pair = tree_.pairs[index];
    pair.children[0] = first.word;
    pair.children[1] = second.word;
    pair.first_share = rounded_share(first.bounds.intensity / intensity);
    pair.normals[0] = normals_of(first.bounds);
    pair.normals[1] = normals_of(second.bounds);
    if (first.bounds.is_two_sided) pair.flags |= interface::LIGHT_PAIR_TWO_SIDED;
    if (second.bounds.is_two_sided) pair.flags |= interface::LIGHT_PAIR_TWO_SIDED << 1;
    bounds_[index] = {first.bounds, second.bounds};
    return {united(first.bounds, second.bounds), index};
  }

  /// Fills the places of the pairs from `index` downwards, whose parent's sphere is given.
  void encode(uint32_t index, const Sphere& parent) {
    for (size_t node = 0; node < 2; ++node) {
      const auto [place, sphere] = place_of(bounds_[index][node], parent);
      tree_.pairs[index].places[node] = place;
      const uint32_t child = tree_.pairs[index].children[node];
      if ((child & interface::LIGHT_PAIR_LEAF) == 0) encode(child, sphere);
    }
  }

  /// Orders the items so that those of the first child come first, and returns how many they are.
  static size_t split(std::span<Item> items, uint32_t depth) {
    if (items.size() == 2) return 1;
    dvec3 lower = items.front().center;
    dvec3 upper = lower;
    for (const Item& item : items) {
      lower = glm::min(lower, item.center);
      upper = glm::max(upper, item.center);
    }
    const Split best = best_split(items, lower, upper);
    const auto is_first = [&](const Item& item) { return item.center[best.axis] < best.position; };
    const auto middle = std::stable_partition(items.begin(), items.end(), is_first);
    const auto first = static_cast<size_t>(middle - items.begin());
    // A child at this depth has trails left for so many lights.
    const uint64_t room = uint64_t{1} << (interface::MAX_LIGHT_TREE_DEPTH - 1 - depth);
    if (first > 0 && first < items.size() && first <= room && items.size() - first <= room) return first;
    const dvec3 extent = upper - lower;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    std::stable_sort(items.begin(), items.end(),
                     [axis](const Item& a, const Item& b) { return a.center[axis] < b.center[axis]; });
    return items.size() / 2;
  }

  void set_fixed(uint32_t index, double first_share, uint32_t first, uint32_t second) {
    interface::LightPair& pair = tree_.pairs[index];
    pair.first_share = rounded_share(first_share);
    pair.flags = interface::LIGHT_PAIR_FIXED;
    pair.children[0] = first;
    pair.children[1] = second;
  }

  uint32_t distant_child(std::span<const uint32_t> lights, uint32_t depth, uint32_t trail) {
    if (lights.size() > 1) return add_distant_pair(lights, depth, trail);
    tree_.trails[lights.front()] = trail;
    return lights.front() | interface::LIGHT_PAIR_LEAF;
  }

  double power_of(std::span<const uint32_t> lights) const {
    return std::accumulate(lights.begin(), lights.end(), 0.0,
                           [this](double sum, uint32_t light) { return sum + lights_[light].power; });
  }

  uint32_t add_distant_pair(std::span<const uint32_t> lights, uint32_t depth, uint32_t trail) {
    const uint32_t index = new_pair();
    const auto first = lights.first(lights.size() / 2);
    const auto second = lights.subspan(lights.size() / 2);
    const uint32_t first_child = distant_child(first, depth + 1, trail);
    const uint32_t second_child = distant_child(second, depth + 1, trail | 1u << depth);
    set_fixed(index, power_of(first) / power_of(lights), first_child, second_child);
    return index;
  }

  const std::vector<TreeLight>& lights_;
  std::vector<Item> items_;
  std::vector<uint32_t> distant_;
  std::vector<std::array<LightBounds, 2>> bounds_;  // of the nodes of finite pairs
  LightTree tree_;
};

struct Cone {
  dvec3 axis;
  double theta;
};

/// The least cone around two.
Cone united(const Cone& a, const Cone& b) {
  if (a.theta < b.theta) return united(b, a);
  const double between = angle_between(a.axis, b.axis);
  if (between + b.theta <= a.theta) return a;
  const double theta = 0.5 * (a.theta + between + b.theta);
  if (theta >= pi) return {a.axis, pi};
  // Turned from a's axis towards b's.
  const dvec3 across = b.axis - dot(a.axis, b.axis) * a.axis;
  const dvec3 towards = length(across) > 1e-9 ? normalize(across) : any_orthogonal(a.axis);
  const double turn = theta - a.theta;
  return {std::cos(turn) * a.axis + std::sin(turn) * towards, theta};
}

}  // namespace

LightBounds united(const LightBounds& a, const LightBounds& b) {
  const Cone cone = united(Cone{a.axis, a.theta_o}, Cone{b.axis, b.theta_o});
  return {glm::min(a.lower, b.lower),
          glm::max(a.upper, b.upper),
          cone.axis,
          cone.theta,
          std::max(a.theta_e, b.theta_e),
          a.intensity + b.intensity,
          a.is_two_sided || b.is_two_sided};
}

LightTree build_light_tree(const std::vector<TreeLight>& lights) {
  return Builder(lights).build();
}

uint32_t resolve_light_sampling(uint32_t asked, size_t lights) {
  // Measured (README.md): from two lamps on the walk is repaid by its lower noise; the two triangles of one
  // lamp it only makes dearer.
  constexpr size_t MANY_LIGHTS = 4;
  if (lights < 2) return interface::LIGHT_SAMPLING_POWER;
  if (asked != interface::LIGHT_SAMPLING_AUTO) return asked;
  return lights < MANY_LIGHTS ? interface::LIGHT_SAMPLING_POWER : interface::LIGHT_SAMPLING_BVH;
}

}  // namespace regulus::scene
