#include "scene/keyframes.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace regulus::scene {
namespace {

// Below this angle between two quaternions a straight line between them is the arc, to double precision.
constexpr double NO_ANGLE = 1e-8;

std::vector<float> read_times(const Document& document, int accessor, const std::string& element) {
  const AccessorReader reader(document, accessor, TINYGLTF_TYPE_SCALAR, element + " input");
  if (reader.count() == 0) document.fail(reader.element() + " has no keys; export the file again");
  std::vector<float> times;
  times.reserve(reader.count());
  for (uint64_t i = 0; i < reader.count(); ++i) {
    times.push_back(reader.component_at(i, 0));
    if (!std::isfinite(times[i]) || (i > 0 && !(times[i] > times[i - 1])))
      document.fail(fmt::format("{}: time {} of key {} does not ascend; export the file again",
                                reader.element(), times[i], i));
  }
  return times;
}

AccessorReader open_values(const Document& document, int accessor, const std::string& element) {
  const int type = document.model.accessors.at(static_cast<size_t>(accessor)).type;
  return AccessorReader(document, accessor, type, element + " output");
}

double length_of(const std::vector<double>& v) {
  double sum = 0;
  for (const double x : v) sum += x * x;
  return std::sqrt(sum);
}

/// A zero quaternion stays: it is a fault of the node's rotation.
std::vector<double> normalized(std::vector<double> v) {
  const double length = length_of(v);
  if (length > 0)
    for (double& x : v) x /= length;
  return v;
}

}  // namespace

Keyframes::Keyframes(const Document& document, int times, int values, Interpolation interpolation,
                     size_t width, bool is_rotation, std::string element)
    : element_(std::move(element)),
      times_(read_times(document, times, element_)),
      values_(open_values(document, values, element_)),
      interpolation_(interpolation),
      width_(width),
      is_rotation_(is_rotation) {
  const uint64_t keys = times_.size() * (interpolation == Interpolation::CubicSpline ? 3 : 1);
  const uint64_t numbers = values_.count() * values_.components();
  if (width_ == 0) width_ = numbers / keys;
  if (width_ == 0 || keys * width_ != numbers ||
      (values_.components() != 1 && values_.components() != width_))
    document.fail(
        fmt::format("{} has {} elements of {} numbers, which is not {} for each of {} keys; export "
                    "the file again",
                    values_.element(), values_.count(), values_.components(),
                    interpolation == Interpolation::CubicSpline ? "three" : "one", times_.size()));
}

double Keyframes::number(uint64_t key, Part part, size_t component) const {
  const bool has_parts = interpolation_ == Interpolation::CubicSpline;
  const uint64_t index = (has_parts ? 3 * key + part : key) * width_ + component;
  return values_.component_at(index / values_.components(), index % values_.components());
}

std::vector<double> Keyframes::key_value(uint64_t key) const {
  std::vector<double> value(width_);
  for (size_t c = 0; c < width_; ++c) value[c] = number(key, Value, c);
  return value;
}

std::vector<double> Keyframes::linear(uint64_t key, double t) const {
  std::vector<double> value(width_);
  for (size_t c = 0; c < width_; ++c)
    value[c] = (1 - t) * number(key, Value, c) + t * number(key + 1, Value, c);
  return value;
}

std::vector<double> Keyframes::spherical(uint64_t key, double t) const {
  const std::vector<double> from = normalized(key_value(key)), to = normalized(key_value(key + 1));
  double dot = 0;
  for (size_t c = 0; c < width_; ++c) dot += from[c] * to[c];
  const double angle = std::acos(std::min(std::abs(dot), 1.0));
  const double of_from = angle > NO_ANGLE ? std::sin(angle * (1 - t)) / std::sin(angle) : 1 - t;
  const double of_to = (angle > NO_ANGLE ? std::sin(angle * t) / std::sin(angle) : t) * (dot < 0 ? -1 : 1);
  std::vector<double> value(width_);
  for (size_t c = 0; c < width_; ++c) value[c] = of_from * from[c] + of_to * to[c];
  return normalized(value);
}

std::vector<double> Keyframes::cubic(uint64_t key, double t, double duration) const {
  const double t2 = t * t, t3 = t2 * t;
  std::vector<double> value(width_);
  for (size_t c = 0; c < width_; ++c)
    value[c] = (2 * t3 - 3 * t2 + 1) * number(key, Value, c) +
               duration * (t3 - 2 * t2 + t) * number(key, OutTangent, c) +
               (-2 * t3 + 3 * t2) * number(key + 1, Value, c) +
               duration * (t3 - t2) * number(key + 1, InTangent, c);
  return is_rotation_ ? normalized(value) : value;
}

std::vector<double> Keyframes::at(const Document& document, double seconds) const {
  // The last key that is not after the time; the first one before all.
  const auto next = std::upper_bound(times_.begin(), times_.end(), seconds);
  const uint64_t key = next == times_.begin() ? 0 : static_cast<uint64_t>(next - times_.begin()) - 1;
  std::vector<double> value;
  if (next == times_.begin() || next == times_.end() || times_[key] == seconds ||
      interpolation_ == Interpolation::Step) {
    value = key_value(key);
  } else {
    const double duration = double{times_[key + 1]} - times_[key];
    const double t = (seconds - times_[key]) / duration;
    value = interpolation_ == Interpolation::CubicSpline ? cubic(key, t, duration)
            : is_rotation_                               ? spherical(key, t)
                                                         : linear(key, t);
  }
  if (!std::all_of(value.begin(), value.end(), [](double x) { return std::isfinite(x); }))
    document.fail(fmt::format("{}: the value at {} s is not finite; correct it", element_, seconds));
  return value;
}

}  // namespace regulus::scene
