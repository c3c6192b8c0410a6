// What a sweep of stability collects: errors of the device and of the reference over one parameter, against a
// value known better than either, with what rounding alone explains. Nothing here knows what is computed.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace regulus::stability {

/// Numbers that stand for the truth: more digits than either side has.
using Exact = long double;

/// Relative roundings that inputs are moved by, one after the other: two units in the last place.
inline constexpr double ROUNDING_OF_INPUTS = 2 * 0x1p-23;

/// What a sweep is about, and what it allows. Errors are relative to the truth, or to `floor` where that is
/// larger.
struct SweepText {
  std::string family;        ///< as in "bsdf"
  std::string name;          ///< what is computed over what, as in "value over roughness"
  std::string parameter;     ///< with its unit
  std::string bound;         ///< where the bound comes from
  double own = 0;            ///< relative error that the device's arithmetic may have of its own
  double own_reference = 0;  ///< the same of the reference
  double floor = 1e-30;      ///< magnitude below which devices may flush to zero
  bool has_reference =
      true;  ///< false: the reference has no such thing, and Measured::reference does not count
};

/// Worst of all cases at one value of the parameter.
struct SweepPoint {
  double parameter = 0;
  size_t cases = 0;
  double device_error = 0, reference_error = 0;  ///< relative
  double bound = 0;                              ///< of the device's error, largest
};

/// One case: both results, the truth, and how far the truth moves (absolutely) when each input is rounded as
/// the device rounds it.
struct Measured {
  double parameter;
  double device, reference;
  Exact truth, moved;
  Exact device_chance = 0,
        reference_chance = 0;  ///< what sampling, or the case's model, may add to each error
};

/// See Sweep::add.
inline constexpr double ENDED = 0.5;

/// A parameter swept over its range.
class Sweep {
 public:
  explicit Sweep(SweepText text) : text_(std::move(text)) {}

  /// Where rounding of the inputs alone moves the truth by more than ENDED of itself, float has ended: such a
  /// case is drawn and has to be finite, but counts as lost.
  /// @param describe names the case; asked for only if it is the worst so far
  void add(const Measured& measured, const std::function<std::string()>& describe);
  /// Counts a case for which nothing could be compared.
  void lose() { ++lost_; }

  const SweepText& text() const { return text_; }
  std::vector<SweepPoint> points() const;
  size_t cases() const { return cases_; }
  size_t lost() const { return lost_; }
  size_t non_finite_device() const { return non_finite_device_; }
  size_t non_finite_reference() const { return non_finite_reference_; }
  double worst_device() const { return worst_device_; }          ///< relative error
  double worst_reference() const { return worst_reference_; }    ///< relative error
  double device_ratio() const { return device_ratio_; }          ///< error over bound, worst
  double reference_ratio() const { return reference_ratio_; }    ///< error over bound, worst
  const std::string& worst_case() const { return worst_case_; }  ///< of the device, closest to its bound
  const std::string& worst_reference_case() const { return worst_reference_case_; }
  /// True if every case is finite and within its bound.
  bool holds() const;
  /// Longest run of neighbouring parameters at which the device errs by less than `error`: first and last;
  /// (0, 0): none.
  std::pair<double, double> accurate_range(double error) const;

 private:
  SweepText text_;
  std::map<double, SweepPoint> points_;
  size_t cases_ = 0, lost_ = 0, non_finite_device_ = 0, non_finite_reference_ = 0;
  double worst_device_ = 0, worst_reference_ = 0, device_ratio_ = 0, reference_ratio_ = 0;
  std::string worst_case_, worst_reference_case_;
};

/// `count` values from `low` to `high` in equal ratios, both included.
std::vector<double> in_equal_ratios(double low, double high, int count);

}  // namespace regulus::stability
