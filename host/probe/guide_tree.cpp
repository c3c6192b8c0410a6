#include "probe/guide_tree.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>

#include "probe/light_guide.hpp"
#include "scene/alias_table.hpp"

namespace regulus::probe {

using namespace interface;

namespace {

// A box is halved while it holds so many deposits: each half is then known to within about a fifth.
constexpr size_t LEAST_TO_HALVE = 48;
// A box is halved where its halves differ by so many standard deviations, else along its longest side.
constexpr double CLEAR_DIFFERENCE = 3;
// Of a box in the one that it halves: what is left of 1 then has ten digits of single precision's 24.
constexpr float LEAST_SHARE = 0x1p-14F;
constexpr uint32_t BITS = GUIDE_HALVINGS;

using Deposits = std::span<Deposit>;

bool is_in_upper_half(const Deposit& deposit, size_t axis, uint32_t halvings) {
  return (deposit.cell[axis] >> (BITS - 1 - halvings) & 1) != 0;
}

uint64_t weight_of(std::span<const Deposit> deposits) {
  uint64_t sum = 0;
  for (const Deposit& deposit : deposits) sum += deposit.weight;
  return sum;
}

/// Which of the four numbers of a start make a difference that may be guided.
std::vector<size_t> guided_axes(uint32_t kind) {
  switch (kind) {
    case LIGHT_DIRECTIONAL:
      return {0, 1};
    case LIGHT_ENVIRONMENT:
      return {0, 1, 2, 3};
    default:
      return {2, 3};
  }
}

/// One tree of the guide.
class Tree {
 public:
  /// `defensive`: share of the whole box that is spread evenly. `least`: deposits of a box that is halved.
  Tree(std::vector<GuideNode>& nodes, std::vector<size_t> axes, Deposits deposits, double defensive,
       size_t least)
      : nodes_(nodes),
        axes_(std::move(axes)),
        whole_(static_cast<double>(weight_of(deposits))),
        defensive_(defensive),
        least_(least) {
    root_ = static_cast<uint32_t>(nodes_.size());
    nodes_.push_back({1, GUIDE_LEAF});
    grow(root_, deposits, {}, 1);
  }

  uint32_t root() const { return root_; }

 private:
  using Halvings = std::array<uint32_t, 4>;

  void grow(uint32_t index, Deposits inside, const Halvings& halvings, double volume) {
    if (inside.size() < least_) return;
    const std::optional<size_t> axis = axis_to_halve(inside, halvings);
    if (!axis) return;
    const auto upper = std::partition(inside.begin(), inside.end(), [&](const Deposit& deposit) {
      return !is_in_upper_half(deposit, *axis, halvings[*axis]);
    });
    const Deposits halves[] = {{inside.begin(), upper}, {upper, inside.end()}};
    const double lower_mass = mass_of(halves[0], volume / 2);
    const double upper_mass = mass_of(halves[1], volume / 2);
    const auto next = static_cast<uint32_t>(nodes_.size());
    const auto share = static_cast<float>(lower_mass / (lower_mass + upper_mass));
    nodes_[index] = {std::clamp(share, LEAST_SHARE, 1 - LEAST_SHARE),
                     next << GUIDE_AXIS_BITS | static_cast<uint32_t>(*axis)};
    nodes_.insert(nodes_.end(), 2, {1, GUIDE_LEAF});
    Halvings further = halvings;
    ++further[*axis];
    for (uint32_t i = 0; i < 2; ++i) grow(next + i, halves[i], further, volume / 2);
  }

  /// Share of starts in a box.
  double mass_of(Deposits inside, double volume) const {
    const double trained = whole_ > 0 ? static_cast<double>(weight_of(inside)) / whole_ : volume;
    return (1 - defensive_) * trained + defensive_ * volume;
  }

  std::optional<size_t> axis_to_halve(Deposits inside, const Halvings& halvings) const {
    double squares = 0;
    for (const Deposit& deposit : inside)
      squares += static_cast<double>(deposit.weight) * static_cast<double>(deposit.weight);
    std::optional<size_t> clearest;
    std::optional<size_t> longest;
    double most = CLEAR_DIFFERENCE;
    for (const size_t axis : axes_) {
      if (halvings[axis] == GUIDE_HALVINGS) continue;
      if (!longest || halvings[axis] < halvings[*longest]) longest = axis;
      double difference = 0;
      for (const Deposit& deposit : inside)
        difference +=
            static_cast<double>(deposit.weight) * (is_in_upper_half(deposit, axis, halvings[axis]) ? 1 : -1);
      const double deviations = std::abs(difference) / std::sqrt(std::max(squares, 1.0));
      if (deviations <= most) continue;
      most = deviations;
      clearest = axis;
    }
    return clearest ? clearest : longest;
  }

  std::vector<GuideNode>& nodes_;
  std::vector<size_t> axes_;
  double whole_, defensive_;
  size_t least_;
  uint32_t root_ = 0;
};

/// The lights as they follow each other in the light tree: neighbours shine from the same place and alike.
std::vector<uint32_t> lights_in_order(const scene::Scene& scene) {
  std::vector<uint32_t> order;
  if (scene.light_tree.pairs.empty()) {
    order.resize(scene.lights.size());
    std::iota(order.begin(), order.end(), 0u);
    return order;
  }
  std::vector<uint32_t> open{0};  // pairs, or leaves
  while (!open.empty()) {
    const uint32_t next = open.back();
    open.pop_back();
    if ((next & LIGHT_PAIR_LEAF) != 0) {
      order.push_back(next & ~LIGHT_PAIR_LEAF);
    } else {
      open.push_back(scene.light_tree.pairs[next].children[1]);
      open.push_back(scene.light_tree.pairs[next].children[0]);
    }
  }
  return order;
}

class GuideMaker {
 public:
  GuideMaker(const scene::Scene& scene, std::vector<Deposit> deposits)
      : scene_(scene), order_(lights_in_order(scene)), deposits_(std::move(deposits)) {
    whole_ = static_cast<double>(weight_of(deposits_));
    std::vector<uint32_t> rank(order_.size());
    for (uint32_t i = 0; i < order_.size(); ++i) rank[order_[i]] = i;
    std::ranges::sort(deposits_, {}, [&](const Deposit& deposit) { return rank[deposit.light]; });
    first_deposit_.assign(order_.size() + 1, 0);
    for (const Deposit& deposit : deposits_) ++first_deposit_[rank[deposit.light] + 1];
    std::partial_sum(first_deposit_.begin(), first_deposit_.end(), first_deposit_.begin());
    power_before_.assign(order_.size() + 1, 0);
    for (size_t i = 0; i < order_.size(); ++i)
      power_before_[i + 1] = power_before_[i] + static_cast<double>(scene.lights[order_[i]].selection_pdf);
  }

  scene::LightGuide make() {
    probabilities_.assign(order_.size(), 0);
    guide_.lights.assign(order_.size(), {0, 0});
    guide_.nodes = {{1, GUIDE_LEAF}};
    divide(0, order_.size());
    guide_.aliases = scene::make_alias_table(probabilities_);
    const std::vector<double> pdf = scene::alias_table_pdf(guide_.aliases);
    for (size_t i = 0; i < pdf.size(); ++i) guide_.lights[i].selection_pdf = static_cast<float>(pdf[i]);
    return std::move(guide_);
  }

 private:
  Deposits deposits_of(size_t begin, size_t end) {
    return Deposits(deposits_).subspan(first_deposit_[begin], first_deposit_[end] - first_deposit_[begin]);
  }

  /// Lights [begin, end) of the order: alike, or half of the power for itself and the other half.
  void divide(size_t begin, size_t end) {
    const Deposits deposits = deposits_of(begin, end);
    if (end - begin == 1 || deposits.size() < LEAST_TO_HALVE) return treat_alike(begin, end, deposits);
    const double middle = 0.5 * (power_before_[begin] + power_before_[end]);
    const auto found = std::upper_bound(power_before_.begin() + static_cast<std::ptrdiff_t>(begin),
                                        power_before_.begin() + static_cast<std::ptrdiff_t>(end), middle);
    const size_t split = std::clamp(static_cast<size_t>(found - power_before_.begin()), begin + 1, end - 1);
    divide(begin, split);
    divide(split, end);
  }

  void treat_alike(size_t begin, size_t end, Deposits deposits) {
    const double power = power_before_[end] - power_before_[begin];
    const double trained = static_cast<double>(weight_of(deposits)) / whole_;
    const double share = (1 - DEFENSIVE_SHARE) * trained + DEFENSIVE_SHARE * power;
    const uint32_t kind = scene_.lights[order_[begin]].kind;
    const bool is_of_one_kind =
        end - begin == 1 ||
        std::ranges::all_of(std::span(order_).subspan(begin, end - begin),
                            [&](uint32_t light) { return scene_.lights[light].kind == LIGHT_TRIANGLE; });
    uint32_t root = 0;
    // So that light by power alone is DEFENSIVE_SHARE of what it is without a guide, start by start.
    if (is_of_one_kind && deposits.size() >= LEAST_TO_HALVE)
      root = Tree(guide_.nodes, guided_axes(kind), deposits, DEFENSIVE_SHARE * power / share, LEAST_TO_HALVE)
                 .root();
    for (size_t i = begin; i < end; ++i) {
      const uint32_t light = order_[i];
      probabilities_[light] = share * static_cast<double>(scene_.lights[light].selection_pdf) / power;
      guide_.lights[light].root = root;
    }
  }

  const scene::Scene& scene_;
  std::vector<uint32_t> order_;
  std::vector<Deposit> deposits_;      // by the order of their lights
  std::vector<size_t> first_deposit_;  // of each light of the order
  std::vector<double> power_before_;   // of all lights before, of the order
  double whole_ = 0;
  std::vector<double> probabilities_;  // by light
  scene::LightGuide guide_;
};

}  // namespace

uint64_t whole_weight(double weight, double mean) {
  constexpr double MOST_OF_MEAN = 32;
  constexpr double UNIT_OF_MEAN = 0x1p-16;
  return static_cast<uint64_t>(std::min(weight / mean, MOST_OF_MEAN) / UNIT_OF_MEAN);
}

uint32_t add_tree(std::vector<GuideNode>& nodes, const std::vector<size_t>& axes, Deposits deposits,
                  double defensive, size_t least) {
  return Tree(nodes, axes, deposits, defensive, least).root();
}

double tree_density(const std::vector<GuideNode>& nodes, uint32_t root, const Deposit& deposit) {
  double density = 1;
  std::array<uint32_t, 4> halvings{};
  uint32_t index = root;
  while (nodes[index].next != GUIDE_LEAF) {
    const GuideNode node = nodes[index];
    const size_t axis = node.next & GUIDE_AXIS_MASK;
    const bool is_upper = is_in_upper_half(deposit, axis, halvings[axis]++);
    density *= 2 * (is_upper ? 1 - double{node.first_share} : double{node.first_share});
    index = (node.next >> GUIDE_AXIS_BITS) + (is_upper ? 1 : 0);
  }
  return density;
}

scene::LightGuide make_light_guide(const scene::Scene& scene, std::vector<Deposit> deposits) {
  return GuideMaker(scene, std::move(deposits)).make();
}

double share_of_start(const scene::Scene& scene, const scene::LightGuide& guide, const Deposit& deposit) {
  const GuidedLight& light = guide.lights[deposit.light];
  return double{light.selection_pdf} / double{scene.lights[deposit.light].selection_pdf} *
         tree_density(guide.nodes, light.root, deposit);
}

}  // namespace regulus::probe
