// Pictures in memory and in files, and how far they are apart.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <variant>
#include <vector>

namespace regulus {

/// A picture, rows from the top.
struct Picture {
  uint32_t width = 0;      ///< pixels
  uint32_t height = 0;     ///< likewise
  std::vector<float> rgb;  ///< linear Rec. 709, interleaved, height * width * 3
  /// AOVs by channel ("albedo.R", "N.X", "Z", "variance.G"; "material" is an integer), height * width each.
  std::map<std::string, std::variant<std::vector<float>, std::vector<uint32_t>>> channels;
  /// What the file's header says of how it was made ("regulus:seed").
  std::map<std::string, std::string> attributes;
  uint32_t x = 0;            ///< left edge on the film: more than 0 for a crop
  uint32_t y = 0;            ///< top edge likewise
  uint32_t film_width = 0;   ///< pixels of the film; 0: the picture is the whole film
  uint32_t film_height = 0;  ///< likewise
};

/// Reads R, G and B of an OpenEXR file, and its attributes. @throws Error (BadFile)
Picture read_picture(const std::filesystem::path& path);

/// Writes .exr with everything; .png and .jpg tone-mapped after a factor 2^exposure_ev; .hdr. The file
/// appears as a whole or not at all. @throws Error (BadUsage) for another extension, (Failed) naming the file
void write_picture(const std::filesystem::path& path, const Picture& picture, float exposure_ev = 0);

/// How far a picture is from a reference.
struct Comparison {
  double mse = 0;                          ///< mean of (a - r)^2 over pixels and channels
  double relmse = 0;                       ///< mean of (a - r)^2 / (r^2 + 0.01)
  double mae = 0;                          ///< mean of |a - r|
  double psnr = 0;                         ///< dB
  double flip = 0;                         ///< mean HDR-FLIP, 0 to 1
  std::array<double, 3> mean{};            ///< of the picture, linear RGB
  std::array<double, 3> reference_mean{};  ///< of the reference
  uint64_t non_finite = 0;                 ///< values left out
};

/// @throws Error (BadFile) if the sizes differ
Comparison compare(const Picture& picture, const Picture& reference);

}  // namespace regulus
