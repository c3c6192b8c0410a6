#include "probe/walk_cells.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <utility>

#include "probe/guide_tree.hpp"

namespace regulus::probe {

using namespace interface;
using std::numbers::pi;

namespace {

// A cell is halved while it holds so much: directions of each half are then still told by hundreds of
// arrivals.
constexpr size_t ARRIVALS_TO_HALVE = 768;
constexpr size_t VISITS_TO_HALVE = 48;
// A cell with fewer arrivals looks where the one looked that it is a half of.
constexpr size_t LEAST_ARRIVALS = 192;
// A normal's side tells halves apart where each has this share of the visits.
constexpr double LEAST_SIDE = 0.05;
// Directions are halved while so many deposits tell of them: a guide that is judged may be rougher than one
// that is not.
constexpr size_t DIRECTIONS_TO_HALVE = 24;
// The guide's own share that goes anywhere: a direction from which no light came may only have been missed.
constexpr double EVEN_SHARE = 0.02;
// Shares to choose from. What the guide does not know is sampled at least 1 - s times as often as without it.
constexpr double SHARES[] = {0.3, 0.5, 0.65, 0.8};
// A guide that makes the second moment less than this much smaller is left alone.
constexpr double LEAST_GAIN = 1.15;

using Visits = std::span<CellKey>;
using Arrivals = std::span<Arrival>;

bool is_upper_place(const CellKey& key, uint32_t axis, uint32_t halvings) {
  return (key.place[axis] >> (GUIDE_HALVINGS - 1 - halvings) & 1) != 0;
}

/// How far a node has been halved.
struct Box {
  std::array<uint32_t, 3> halvings{};
  uint32_t sides_told = 0;  // bits of CellKey::sides
};

bool is_upper(const CellKey& key, const Box& box, uint32_t axis) {
  return axis < WALK_GUIDE_NORMALS ? is_upper_place(key, axis, box.halvings[axis])
                                   : (key.sides >> (axis - WALK_GUIDE_NORMALS) & 1) != 0;
}

Deposit deposit_of(const Arrival& arrival) {
  return {0, {arrival.direction[0], arrival.direction[1], 0, 0}, arrival.weight};
}

/// What a cell does.
struct Look {
  float share = 0;
  uint32_t root = 0;
  double gain = 1;
};

class Maker {
 public:
  explicit Maker(const scene::WalkGuide& bounds) : extent_(1.0F / bounds.scale) { made_.guide = bounds; }

  MadeWalkGuide make(Visits visits, Arrivals arrivals) {
    nodes().assign(1, {});
    grow(0, visits, arrivals, {}, {});
    if (visit_count_ > 0) made_.gain = std::exp(log_gain_ / visit_count_);
    return std::move(made_);
  }

 private:
  std::vector<GuideNode>& nodes() { return made_.guide.nodes; }

  void grow(uint32_t index, Visits visits, Arrivals arrivals, const Box& box, const Look& inherited) {
    const bool is_told = arrivals.size() >= LEAST_ARRIVALS;
    const std::optional<uint32_t> axis =
        arrivals.size() >= ARRIVALS_TO_HALVE ? axis_to_halve(visits, box) : std::nullopt;
    if (!axis) {
      const Look look = visits.empty() ? Look{} : is_told ? look_for(arrivals) : inherited;
      nodes()[index] = {look.share, look.root << WALK_GUIDE_AXIS_BITS | WALK_GUIDE_CELL};
      log_gain_ += static_cast<double>(visits.size()) * std::log(look.gain);
      visit_count_ += static_cast<double>(visits.size());
      return;
    }
    const auto goes_down = [&](const auto& key) { return !is_upper(key, box, *axis); };
    const auto visit = std::partition(visits.begin(), visits.end(), goes_down);
    const auto arrival = std::partition(arrivals.begin(), arrivals.end(),
                                        [&](const Arrival& one) { return goes_down(one.key); });
    const Visits visits_of[] = {{visits.begin(), visit}, {visit, visits.end()}};
    const Arrivals arrivals_of[] = {{arrivals.begin(), arrival}, {arrival, arrivals.end()}};
    // Of a half that few arrivals tell about.
    Look own = inherited;
    if (std::min(arrivals_of[0].size(), arrivals_of[1].size()) < LEAST_ARRIVALS) own = look_for(arrivals);
    const auto next = static_cast<uint32_t>(nodes().size());
    nodes()[index] = {0, next << WALK_GUIDE_AXIS_BITS | *axis};
    nodes().insert(nodes().end(), 2, {});
    Box further = box;
    if (*axis < WALK_GUIDE_NORMALS)
      ++further.halvings[*axis];
    else
      further.sides_told |= 1u << (*axis - WALK_GUIDE_NORMALS);
    for (uint32_t i = 0; i < 2; ++i) grow(next + i, visits_of[i], arrivals_of[i], further, own);
  }

  /// First by which way surfaces face, which tells most about where their light comes from, then the longest
  /// side.
  std::optional<uint32_t> axis_to_halve(Visits visits, const Box& box) const {
    if (visits.size() < VISITS_TO_HALVE) return std::nullopt;
    for (uint32_t k = 0; k < SIDE_BITS; ++k) {
      if ((box.sides_told >> k & 1) != 0) continue;
      const auto above = static_cast<double>(
          std::ranges::count_if(visits, [&](const CellKey& key) { return (key.sides >> k & 1) != 0; }));
      const double share = above / static_cast<double>(visits.size());
      if (std::min(share, 1 - share) > LEAST_SIDE) return WALK_GUIDE_NORMALS + k;
    }
    std::optional<uint32_t> longest;
    double most = 0;
    for (uint32_t axis = 0; axis < 3; ++axis) {
      const double side =
          std::ldexp(double{extent_[static_cast<int>(axis)]}, -static_cast<int>(box.halvings[axis]));
      if (box.halvings[axis] == GUIDE_HALVINGS || side <= most) continue;
      most = side;
      longest = axis;
    }
    return longest;
  }

  /// Directions of these arrivals, and how much to trust them: by one half of them, judged by the other.
  Look look_for(Arrivals arrivals) {
    std::vector<Deposit> all, trained;
    for (const Arrival& arrival : arrivals) {
      all.push_back(deposit_of(arrival));
      if (!arrival.is_second) trained.push_back(deposit_of(arrival));
    }
    Look look;
    look.root = add_tree(nodes(), {0, 1}, all, EVEN_SHARE, DIRECTIONS_TO_HALVE);
    std::vector<GuideNode> half;
    add_tree(half, {0, 1}, trained, EVEN_SHARE, DIRECTIONS_TO_HALVE);
    // Second moments of light that arrives, by density per steradian of the samples.
    double plain = 0;
    std::array<double, std::size(SHARES)> guided{};
    for (const Arrival& arrival : arrivals) {
      if (!arrival.is_second || !(arrival.cosine > 0)) continue;
      const Deposit deposit = deposit_of(arrival);
      const double light = static_cast<double>(arrival.weight) * tree_density(nodes(), look.root, deposit);
      const double of_lobe = arrival.cosine / pi;
      const double of_guide = tree_density(half, 0, deposit) / (4 * pi);
      plain += light / of_lobe;
      for (size_t i = 0; i < guided.size(); ++i) guided[i] += light / std::lerp(of_lobe, of_guide, SHARES[i]);
    }
    const size_t best = static_cast<size_t>(std::ranges::min_element(guided) - guided.begin());
    if (!(guided[best] > 0) || plain / guided[best] < LEAST_GAIN) return look;
    look.share = static_cast<float>(SHARES[best]);
    look.gain = plain / guided[best];
    return look;
  }

  MadeWalkGuide made_;
  glm::vec3 extent_;
  double log_gain_ = 0, visit_count_ = 0;
};

}  // namespace

CellKey cell_key(const scene::WalkGuide& bounds, const glm::dvec3& position, const glm::dvec3& normal) {
  constexpr double CELLS = 1u << GUIDE_HALVINGS;
  CellKey key;
  for (int axis = 0; axis < 3; ++axis) {
    const double place = (position[axis] - double{bounds.corner[axis]}) * double{bounds.scale[axis]};
    key.place[static_cast<size_t>(axis)] = static_cast<uint16_t>(std::clamp(place * CELLS, 0.0, CELLS - 1));
    if (normal[axis] >= WALK_GUIDE_SIDE / 100.0) key.sides |= static_cast<uint8_t>(1u << axis);
    if (normal[axis] >= WALK_GUIDE_SIDE / -100.0) key.sides |= static_cast<uint8_t>(8u << axis);
  }
  return key;
}

MadeWalkGuide make_walk_guide(const scene::WalkGuide& bounds, std::vector<CellKey> visits,
                              std::vector<Arrival> arrivals) {
  return Maker(bounds).make(visits, arrivals);
}

}  // namespace regulus::probe
