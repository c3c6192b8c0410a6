// How a picture becomes a file.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "image/image.hpp"

namespace regulus::image {

/// From linear radiance to what a screen shows.
enum class View {
  Neutral,   ///< colours up to 0.8 as they are, brighter ones compressed (tone_map), sRGB's curve
  Standard,  ///< cut off at 1, sRGB's curve
  Agx,       ///< AgX of Troy Sobotka, in Benjamin Wrensch's fit (2023): highlights lose colour slowly
  Filmic,    ///< John Hable's curve of "Uncharted 2" (2010), white at 11.2, sRGB's curve
  Raw        ///< cut off at 1, without a curve: for data
};

std::vector<std::string> view_names();
/// Precondition: `name` is one of view_names().
View view_of(const std::string& name);

/// The encoded colour, [0, 1]. NaN and negative values are 0.
std::array<float, 3> display(View view, const std::array<float, 3>& linear);

/// The exposure, in stops, that brings the mean logarithm of the picture's luminance to that of 0.18
/// (Reinhard et al. 2002). Pixels that are black or not finite do not count; 0 if all are.
float automatic_exposure(const Image& image);

/// How OpenEXR stores it.
struct ExrStorage {
  bool has_half_floats = false;  ///< colours and normals; depths, positions and integers keep their 32 bits
  bool is_dwaa = false;          ///< DWAA's lossy compression in place of ZIP
};

/// encode_exr (image.hpp) with a storage that may lose bits. @throws regulus::Error (Failed)
std::string encode_exr(const Image& image, const Attributes& attributes, const Channels& channels,
                       const Placement& placement, std::string_view name, const ExrStorage& storage);

class ColorTransform;  // image/color_config.hpp

/// How a picture is written.
struct Encoding {
  float exposure_ev = 0;  ///< of PNG and JPEG
  View view = View::Neutral;
  std::shared_ptr<const ColorTransform> transform{};  ///< in place of `view`; none: null
  ExrStorage storage{};
  /// Implicit: an exposure is all that most need to say.
  Encoding(float stops = 0) : exposure_ev(stops) {}
};

}  // namespace regulus::image
