// Images on disk and in memory: OpenEXR in and out, tone-mapped PNG out (other formats: formats.hpp), error
// metrics. All files are written to a temporary name in the same folder and renamed, so no reader ever sees
// half a file.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace regulus::image {

/// Linear Rec. 709 RGB, row-major from the top row, interleaved.
struct Image {
  uint32_t width = 0, height = 0;
  std::vector<float> rgb;
  /// What the pixels of the file it was read from hold at most: 65504 if all are half floats.
  float largest_finite = std::numeric_limits<float>::max();
};

/// Named extra channels (AOVs such as "albedo.R", "Z"), each width * height values.
using Channel = std::variant<std::vector<float>, std::vector<uint32_t>>;
using Channels = std::map<std::string, Channel>;
/// String attributes of an EXR header, by full name ("regulus:seed").
using Attributes = std::map<std::string, std::string>;

/// The part of a film that an image shows: data window and display window of OpenEXR.
struct Placement {
  uint32_t x = 0, y = 0;                     ///< of the image's first pixel on the film
  uint32_t film_width = 0, film_height = 0;  ///< 0: the image is the film
};

/// Single part, 32 bits, ZIP. @throws regulus::Error (Failed) naming the file if it cannot be written.
void write_exr(const std::filesystem::path& path, const Image& image, const Attributes& attributes = {},
               const Channels& channels = {}, const Placement& placement = {});

/// The bytes of what write_exr writes; errors name `name`. @throws regulus::Error (Failed).
std::string encode_exr(const Image& image, const Attributes& attributes, const Channels& channels,
                       const Placement& placement, std::string_view name);

/// Everything that write_exr writes.
struct ExrContents {
  uint32_t width = 0, height = 0;
  Placement placement;
  Attributes attributes;  ///< those that are strings
  Channels channels;      ///< R, G and B among them
};

/// Reads a file with channels of 32 bits at full resolution, as write_exr writes them. @throws regulus::Error
/// (BadFile) naming the file.
ExrContents read_exr_contents(const std::filesystem::path& path);

/// Reads R, G, B of the first part (half or float, any compression; a single Y is copied to all three); the
/// image is the data window. String attributes go to `attributes`. @throws regulus::Error (BadFile) naming
/// the file.
Image read_exr(const std::filesystem::path& path, Attributes* attributes = nullptr);

/// The same of a file's bytes; `name` stands for it in errors. More than `max_pixels` are refused before
/// memory is taken for them.
Image decode_exr(const std::string& name, std::span<const unsigned char> bytes,
                 uint64_t max_pixels = UINT64_MAX);

/// Whether the bytes begin as a Radiance picture (.hdr, .pic) does.
bool is_radiance(std::span<const unsigned char> bytes);

/// A Radiance picture of format 32-bit_rle_rgbe, rows from the top (-Y +X); exposures in its header are
/// ignored. More than `max_pixels` are refused before memory is taken for them.
/// @throws regulus::Error (BadFile) naming `name`.
Image decode_radiance(const std::string& name, std::span<const unsigned char> bytes,
                      uint64_t max_pixels = UINT64_MAX);

/// Linear Rec. 709 to linear [0, 1] by the shoulder of Khronos' PBR Neutral tone mapper (2024): colours up to
/// 0.8 pass unchanged, brighter ones are compressed and turn white. Its toe, which takes the smallest channel
/// (up to 0.04) off every colour, is left out: it is meant for base colours under even light and turns soft
/// shadows black. NaN and negative values become 0.
std::array<float, 3> tone_map(const std::array<float, 3>& linear);

/// The sRGB transfer curve (IEC 61966-2-1), linear [0, 1] to encoded [0, 1].
float srgb_encode(float linear);

/// 8-bit sRGB PNG of the image scaled by 2^exposure_ev and tone-mapped. @throws regulus::Error (Failed).
void write_png(const std::filesystem::path& path, const Image& image, float exposure_ev = 0);

/// Metrics of image against reference. Sums in double. NaN if no value is finite in both images.
struct Metrics {
  double mse = 0;     ///< mean over pixels and channels of (a - r)^2
  double relmse = 0;  ///< mean of (a - r)^2 / (r^2 + 0.01)
  /// relmse of the pixels without TRIMMED_SHARE of them, those that are worst: a few fireflies decide relmse.
  double trimmed_relmse = 0;
  double mrse = 0;  ///< mean relative squared error, mean of (a - r)^2 / (mean(r_pixel)^2 + 0.01)
  double mae = 0;   ///< mean absolute error
  double psnr = 0;  ///< dB, peak = largest reference value; infinite for equal images
  std::array<double, 3> mean{}, reference_mean{};  ///< over the values that entered the metrics
  uint64_t non_finite = 0;  ///< values of either image that are NaN or infinite (left out of the metrics)
};

/// Added to squared reference values in relative errors, so that black pixels do not divide by zero.
constexpr double RELATIVE_EPSILON = 0.01;
/// Of the pixels, rounded down.
constexpr double TRIMMED_SHARE = 0.001;

/// @throws regulus::Error (BadFile) if the sizes differ.
Metrics compare(const Image& image, const Image& reference);

/// Pixels per degree of sight at which FLIP's authors compare by default: a screen of 3840 pixels and 0.7 m,
/// seen from 0.7 m.
constexpr float FLIP_PIXELS_PER_DEGREE = 67.0206433f;

/// HDR-FLIP of each pixel in [0, 1], rows from the top: the largest visible difference over the exposures
/// that the reference calls for (Andersson et al., "FLIP: A Difference Evaluator for Alternating Images",
/// 2020, and "Visualizing Errors in Rendered High Dynamic Range Images", 2021; ACES tone mapping). Values
/// that are not finite are seen as black. Where the median of the reference is black its darkest positive
/// luminance takes the median's place, an all-black reference is compared as it is: the papers leave both
/// open. @throws regulus::Error (BadFile) if the sizes differ.
std::vector<float> flip_map(const Image& image, const Image& reference,
                            float pixels_per_degree = FLIP_PIXELS_PER_DEGREE);

/// Mean of flip_map.
double flip(const Image& image, const Image& reference);

/// @throws regulus::Error (BadFile) if the sizes differ.
void require_same_size(const Image& image, const Image& reference);

/// Root of a pixel's mrse (see Metrics) of two RGB triples.
double relative_error(const float* pixel, const float* reference);

/// Picture with the relative error of each pixel on a logarithmic scale: 0.001 and less is black, 0.01
/// purple, 0.1 orange, 1 and more pale yellow; a pixel with NaN or infinity is cyan. PNG or JPEG, see
/// formats.hpp.
/// @throws regulus::Error (BadFile, Failed).
void write_heat_map(const std::filesystem::path& path, const Image& image, const Image& reference);

}  // namespace regulus::image
