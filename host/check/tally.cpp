#include "check/tally.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace regulus::check {

namespace {
constexpr size_t MOST_DESCRIPTIONS = 3;
}

bool Tally::add_error(double error, double excused) {
  const double own = std::isfinite(error) ? std::max(error - excused, 0.0) : HUGE_VAL;
  errors_.push_back(own);
  if (own <= bound_) return true;
  ++real_;
  return false;
}

void Tally::add_difference(Difference difference) {
  (difference == Difference::Tie ? ties_ : difference == Difference::Edge ? edges_ : real_) += 1;
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
  for (const std::string& text : more.descriptions_) describe(text);
}

bool Tally::is_passed() const {
  // Ties and edges are rare by nature; many of them are a bug that passes for one.
  const auto items = static_cast<double>(this->items());
  const auto expected = static_cast<double>(expected_ties_);
  return static_cast<double>(real_) <= allowed_share_ * items &&
         static_cast<double>(ties_ + edges_) <= 1 + 0.01 * items + 2 * expected;
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
  for (const std::string& description : descriptions_) text += "\n    " + description;
  return text;
}

}  // namespace regulus::check
