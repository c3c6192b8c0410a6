// How time and memory of a render grow with what it is made of: pixels, samples, triangles, lights, depth,
// light paths, instances. Each is varied alone, on a scene made for it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "gpu/gpu.hpp"

namespace regulus::bench {

/// y = c x^exponent, by least squares between the logarithms.
struct PowerFit {
  double exponent = 0;
  double deviation = 0;  ///< standard error of the exponent by the residuals; 0 for two points
  double last = 0;       ///< exponent between the two largest x alone: fixed costs weigh less there
};

/// @param points (x, y), both positive, x ascending; at least two
PowerFit fit_power(const std::vector<std::pair<double, double>>& points);

/// What one render took. Seconds are CPU seconds of this process on software devices, otherwise those of the
/// clock.
struct GrowthPoint {
  double size = 0;             ///< of what is varied
  double prepare_seconds = 0;  ///< reading the file, and all that is made of it before a device is needed
  double render_seconds = 0;   ///< kernels compiled, the scene on the device
  double device_bytes = 0;     ///< held at the end
};

/// Renders over which one thing grows.
struct GrowthSweep {
  std::string name;  ///< "triangles"
  std::string text;  ///< what is rendered
  std::vector<GrowthPoint> points;
};

/// The sizes of one quantity, a pointer to a member of GrowthPoint, over those of the sweep.
PowerFit fit_of(const GrowthSweep& sweep, double GrowthPoint::*quantity);

/// The exponent that n log n has between the two largest sizes of the sweep; 1 if these are 1.
double log_linear_exponent(const GrowthSweep& sweep);

struct GrowthBudget {
  bool is_full = false;                            ///< to 10^7 triangles and 10^6 lights instead of seconds
  uint32_t repeats = 3;                            ///< the least time counts
  std::vector<std::string> names;                  ///< sweeps that are made; none: all
  std::function<bool()> is_interrupted = nullptr;  ///< if it says so, measuring is given up
};

/// The names of all sweeps.
std::vector<std::string> growth_names();
/// @throws regulus::Error (BadUsage) unless these are some of them
void require_growth_names(const std::vector<std::string>& names);

/// Calls `use` with each sweep when it is measured.
/// @throws regulus::Error (Interrupted), and as require_growth_names() and render::Renderer
void measure_growth(gpu::Device& device, const GrowthBudget& budget,
                    const std::function<void(const GrowthSweep&)>& use);

}  // namespace regulus::bench
