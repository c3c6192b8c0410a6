#include "stability/sweep.hpp"

#include <algorithm>
#include <cmath>

namespace regulus::stability {
namespace {

// Float's rounding over double's: 2^-24 / 2^-53. What moving inputs does shrinks by as much.
constexpr double DOUBLE_SHARE = 0x1p-29;

double relative_error(double value, Exact truth, double floor) {
  const Exact error = std::abs(static_cast<Exact>(value) - truth);
  if (error <= floor && std::abs(truth) <= floor) return 0;
  return static_cast<double>(error / std::max(std::abs(truth), static_cast<Exact>(floor)));
}

}  // namespace

void Sweep::add(const Measured& measured, const std::function<std::string()>& describe) {
  ++cases_;
  SweepPoint& point = points_[measured.parameter];
  point.parameter = measured.parameter;
  ++point.cases;
  const bool is_device_finite = std::isfinite(measured.device);
  const bool is_reference_finite = !text_.has_reference || std::isfinite(measured.reference);
  non_finite_device_ += is_device_finite ? 0 : 1;
  non_finite_reference_ += is_reference_finite ? 0 : 1;
  const Exact scale = std::max(std::abs(measured.truth), static_cast<Exact>(text_.floor));
  const double moved = static_cast<double>(measured.moved / scale);
  const bool is_known = moved <= ENDED;
  lost_ += is_known ? 0 : 1;
  const double device_error =
      is_device_finite ? relative_error(measured.device, measured.truth, text_.floor) : 0;
  const double reference_error = text_.has_reference && is_reference_finite
                                     ? relative_error(measured.reference, measured.truth, text_.floor)
                                     : 0;
  const double bound = text_.own + moved + static_cast<double>(measured.device_chance / scale);
  point.device_error = std::max(point.device_error, device_error);
  point.reference_error = std::max(point.reference_error, reference_error);
  point.bound = std::max(point.bound, bound);
  if (!is_known) return;
  worst_device_ = std::max(worst_device_, device_error);
  worst_reference_ = std::max(worst_reference_, reference_error);
  if (device_error / bound > device_ratio_) {
    device_ratio_ = device_error / bound;
    worst_case_ = describe();
  }
  const double reference_bound =
      text_.own_reference + moved * DOUBLE_SHARE + static_cast<double>(measured.reference_chance / scale);
  if (reference_error / reference_bound > reference_ratio_) {
    reference_ratio_ = reference_error / reference_bound;
    worst_reference_case_ = describe();
  }
}

std::vector<SweepPoint> Sweep::points() const {
  std::vector<SweepPoint> points;
  for (const auto& [parameter, point] : points_) points.push_back(point);
  return points;
}

bool Sweep::holds() const {
  return non_finite_device_ == 0 && non_finite_reference_ == 0 && device_ratio_ <= 1 && reference_ratio_ <= 1;
}

std::pair<double, double> Sweep::accurate_range(double error) const {
  std::pair<double, double> best(0, 0);
  size_t longest = 0;
  size_t length = 0;
  double first = 0;
  for (const auto& [parameter, point] : points_) {
    length = point.device_error < error ? length + 1 : 0;
    if (length == 1) first = parameter;
    if (length <= longest) continue;
    longest = length;
    best = {first, parameter};
  }
  return best;
}

std::vector<double> in_equal_ratios(double low, double high, int count) {
  std::vector<double> values;
  values.reserve(static_cast<size_t>(count));
  for (int i = 0; i < count; ++i)
    values.push_back(low * std::pow(high / low, i / std::max(count - 1.0, 1.0)));
  return values;
}

}  // namespace regulus::stability
