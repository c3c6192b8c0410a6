// `regulus bench stability`: families of computations, each swept over a parameter until its arithmetic ends,
// on the device and in the reference, against closed forms or more digits.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "gpu/gpu.hpp"
#include "stability/sweep.hpp"

namespace regulus::stability {

/// How much is swept: Quick is a test of seconds, Full takes minutes.
enum class Extent { Quick, Full };

/// Everything that was swept on one device.
struct Report {
  std::string device, driver, extent;
  std::vector<Sweep> sweeps;

  /// True if all sweeps hold.
  bool holds() const;
};

/// The families in the order of the report.
std::vector<std::string> family_names();

/// Sweeps the families.
/// @param families some of family_names(); empty: all
/// @param is_interrupted asked between families; the rest is given up if it says so. May be null
/// @throws regulus::Error as the device
Report measure(gpu::Device& device, Extent extent, const std::vector<std::string>& families,
               const std::function<bool()>& is_interrupted);

}  // namespace regulus::stability
