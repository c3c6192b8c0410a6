// Keyframes of an animation sampler and what lies between them (glTF 2.0, appendix C).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scene/accessor.hpp"
#include "scene/document.hpp"

namespace regulus::scene {

enum class Interpolation { Step, Linear, CubicSpline };

class Keyframes {
 public:
  /// @param times, values accessors
  /// @param width numbers per key; 0: as many as there are for each
  /// @param is_rotation unit quaternions, interpolated on the sphere
  /// @param element names the sampler in errors
  /// @throws Error on times that do not ascend, and on another number of values than the keys need
  Keyframes(const Document& document, int times, int values, Interpolation interpolation, size_t width,
            bool is_rotation, std::string element);

  size_t width() const { return width_; }

  /// The value at a time in seconds; that of the first key before it, that of the last key after it.
  /// @throws Error if it is not finite
  std::vector<double> at(const Document& document, double seconds) const;

 private:
  /// Of a cubic spline's three values per key.
  enum Part : uint64_t { InTangent = 0, Value = 1, OutTangent = 2 };

  double number(uint64_t key, Part part, size_t component) const;
  std::vector<double> key_value(uint64_t key) const;
  std::vector<double> linear(uint64_t key, double t) const;
  std::vector<double> spherical(uint64_t key, double t) const;
  std::vector<double> cubic(uint64_t key, double t, double duration) const;

  std::string element_;
  std::vector<float> times_;
  AccessorReader values_;
  Interpolation interpolation_;
  size_t width_;
  bool is_rotation_;
};

}  // namespace regulus::scene
