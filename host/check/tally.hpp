// What a comparison of device and reference found: errors of the items that agree in kind, and classes of
// those that do not.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace regulus::check {

/// Why an item differs in kind (another triangle, another lobe, alive against dead).
enum class Difference {
  Tie,   ///< a decision that single precision may take either way
  Edge,  ///< a ray that passes an edge within single precision
  Real,  ///< a bug
};

/// One line of the report.
class Tally {
 public:
  /// `bound`: largest relative error of an item that is well-conditioned. `allowed_share`: of all items, how
  /// many may be real differences (0 where each has a cause of its own; whole paths diverge for reasons that
  /// the stages' own lines judge).
  Tally(std::string name, double bound, double allowed_share = 0)
      : name_(std::move(name)), bound_(bound), allowed_share_(allowed_share) {}

  /// An item of the same kind on both sides: its error, and how much of it is the item's own conditioning.
  /// Returns false if it counts as a real difference. of_class: what it has in common with others that one
  /// fault would hit (lobe, medium, kind of light); "": it is judged among all alone.
  bool add_error(double error, double excused = 0, const std::string& of_class = "");

  /// An item that differs in kind.
  void add_difference(Difference difference, const std::string& of_class = "");

  /// How many ties (and edges) there would be by the reference's own measure; a few are always expected.
  void expect_ties(uint64_t count) { expected_ties_ = count; }

  /// Words about a real difference; the first few are kept.
  void describe(const std::string& text);

  /// Adds the items of a line of the same name.
  void add(const Tally& more);

  /// Classes with more differences than a class may have: ten times the share of all, since what is rare in
  /// all may come from few classes, and what chance adds to that.
  std::vector<std::string> failing_classes() const;

  uint64_t items() const { return errors_.size() + ties_ + edges_; }
  bool is_passed() const;
  const std::string& name() const { return name_; }

  /// Name, items, largest and 99.9th-percentile error, bound, items by class, verdict; then the descriptions.
  std::string line() const;
  static std::string header();

 private:
  struct ClassCounts {
    uint64_t items = 0, real = 0, ties = 0;
  };

  std::string name_;
  double bound_, allowed_share_;
  std::vector<double> errors_;  // of items of the same kind, conditioning taken off
  uint64_t ties_ = 0, edges_ = 0, real_ = 0, expected_ties_ = 0;
  std::map<std::string, ClassCounts> classes_;
  std::vector<std::string> descriptions_;
};

}  // namespace regulus::check
