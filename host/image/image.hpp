// Images on disk and in memory: OpenEXR in and out, tone-mapped PNG out, error metrics. All files are
// written to a temporary name in the same folder and renamed, so no reader ever sees half a file.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace regulus::image {

/// Linear Rec. 709 RGB, row-major from the top row, interleaved.
struct Image {
  uint32_t width = 0, height = 0;
  std::vector<float> rgb;
};

/// Named extra channels (AOVs such as "albedo.R", "Z"), each width * height floats.
using Channels = std::map<std::string, std::vector<float>>;
/// String attributes of an EXR header, by full name ("regulus:seed").
using Attributes = std::map<std::string, std::string>;

/// Single part, float32, ZIP. @throws regulus::Error (Failed) naming the file if it cannot be written.
void write_exr(const std::filesystem::path& path, const Image& image, const Attributes& attributes = {},
               const Channels& channels = {});

/// Reads R, G, B (half or float; a single Y is copied to all three). @throws regulus::Error (BadFile).
Image read_exr(const std::filesystem::path& path, Attributes* attributes = nullptr);

/// 8-bit sRGB PNG of the image scaled by 2^exposure_ev and tone-mapped. @throws regulus::Error (Failed).
void write_png(const std::filesystem::path& path, const Image& image, float exposure_ev = 0);

/// Metrics of image against reference. Sums in double.
struct Metrics {
  double mse = 0;     ///< mean over pixels and channels of (a - r)^2
  double relmse = 0;  ///< mean of (a - r)^2 / (r^2 + 0.01)
  double mrse = 0;    ///< mean relative squared error, mean of (a - r)^2 / (mean(r_pixel)^2 + 0.01)
  double mae = 0;     ///< mean absolute error
  double psnr = 0;    ///< dB, peak = largest reference value
  std::array<double, 3> mean{}, reference_mean{};
  uint64_t non_finite = 0;  ///< values of either image that are NaN or infinite (left out of the metrics)
};

/// @throws regulus::Error (BadFile) if the sizes differ.
Metrics compare(const Image& image, const Image& reference);

}  // namespace regulus::image
