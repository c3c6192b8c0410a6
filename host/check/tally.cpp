#include "check/tally.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace regulus::check {

namespace {
constexpr size_t MOST_DESCRIPTIONS = 3;
// Of a class, over the shares allowed of all. Classes differ by nature; but by Markov's inequality those
// whose own share is more than this many times the mean hold less than one over it of all items.
constexpr double CLASS_SHARE = 10;
constexpr double TIES_ALLOWED = 0.01;
// Probability with which a class whose differences come by chance is found to have too many.
constexpr double RATE_OF_TOO_MANY = 1e-6;

/// Most events that a Poisson process of this mean has, but for RATE_OF_TOO_MANY.
uint64_t most_by_chance(double mean) {
  if (mean > 100) return static_cast<uint64_t>(mean + 6 * std::sqrt(mean));
  double term = std::exp(-mean);
  double beyond = 1 - term;
  uint64_t count = 0;
  while (beyond > RATE_OF_TOO_MANY) {
    term *= mean / static_cast<double>(++count);
    beyond -= term;
  }
  return count;
}
}  // namespace

bool Tally::add_error(double error, double excused, const std::string& of_class) {
  const double own = std::isfinite(error) ? std::max(error - excused, 0.0) : HUGE_VAL;
  errors_.push_back(own);
  const bool is_real = own > bound_;
  real_ += is_real ? 1 : 0;
  if (!of_class.empty()) {
    ClassCounts& counts = classes_[of_class];
    ++counts.items;
    counts.real += is_real ? 1 : 0;
  }
  return !is_real;
}

void Tally::add_difference(Difference difference, const std::string& of_class) {
  (difference == Difference::Tie ? ties_ : difference == Difference::Edge ? edges_ : real_) += 1;
  if (of_class.empty()) return;
  ClassCounts& counts = classes_[of_class];
  ++counts.items;
  (difference == Difference::Real ? counts.real : counts.ties) += 1;
}

void Tally::describe(const std::string& text) {
  if (descriptions_.size() < MOST_DESCRIPTIONS) descriptions_.push_back(text);
}

void Tally::add(const Tally& more) {
  errors_.insert(errors_.end(), more.errors_.begin(), more.errors_.end());
  ties_ += more.ties_;
  edges_ += more.edges_;
  real_ += more.real_;
  expected_ties_ += more.expected_ties_;
  for (const auto& [name, counts] : more.classes_) {
    ClassCounts& own = classes_[name];
    own.items += counts.items;
    own.real += counts.real;
    own.ties += counts.ties;
  }
  for (const std::string& text : more.descriptions_) describe(text);
}

std::vector<std::string> Tally::failing_classes() const {
  std::vector<std::string> failing;
  const auto all = static_cast<double>(std::max<uint64_t>(items(), 1));
  for (const auto& [name, counts] : classes_) {
    const auto items = static_cast<double>(counts.items);
    const double ties = CLASS_SHARE * (TIES_ALLOWED + 2 * static_cast<double>(expected_ties_) / all);
    const bool is_passed =
        counts.real <= most_by_chance(std::min(CLASS_SHARE * allowed_share_, 1.0) * items) &&
        counts.ties <= 1 + most_by_chance(std::min(ties, 1.0) * items);
    if (!is_passed)
      failing.push_back(fmt::format("class {}: of {} items {} ties, {} real", name, counts.items, counts.ties,
                                    counts.real));
  }
  return failing;
}

bool Tally::is_passed() const {
  // Ties and edges are rare by nature; many of them are a bug that passes for one.
  const auto items = static_cast<double>(this->items());
  const auto expected = static_cast<double>(expected_ties_);
  return static_cast<double>(real_) <= allowed_share_ * items &&
         static_cast<double>(ties_ + edges_) <= 1 + TIES_ALLOWED * items + 2 * expected &&
         failing_classes().empty();
}

std::string Tally::header() {
  return fmt::format("{:<24} {:>9} {:>10} {:>10} {:>8} {:>6} {:>6} {:>6}  verdict", "stage", "items",
                     "largest", "99.9 %", "bound", "ties", "edges", "real");
}

std::string Tally::line() const {
  std::vector<double> sorted = errors_;
  std::sort(sorted.begin(), sorted.end());
  const double largest = sorted.empty() ? 0 : sorted.back();
  const double percentile = sorted.empty() ? 0 : sorted[(sorted.size() - 1) * 999 / 1000];
  std::string text =
      fmt::format("{:<24} {:>9} {:>10.2g} {:>10.2g} {:>8.0e} {:>6} {:>6} {:>6}  {}", name_, items(), largest,
                  percentile, bound_, ties_, edges_, real_, is_passed() ? "ok" : "MISMATCH");
  for (const std::string& words : failing_classes()) text += "\n    " + words;
  for (const std::string& description : descriptions_) text += "\n    " + description;
  return text;
}

}  // namespace regulus::check
