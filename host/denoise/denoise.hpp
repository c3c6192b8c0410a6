// Pictures without their noise.
#pragma once

#include <string>
#include <vector>

#include "image/image.hpp"

namespace regulus::denoise {

/// What a denoiser sees of a picture, all of one size, row by row, three floats for each pixel.
struct Input {
  uint32_t width = 0, height = 0;
  std::vector<float> color;     ///< linear radiance
  std::vector<float> albedo;    ///< empty: not known
  std::vector<float> normal;    ///< empty: not known
  std::vector<float> variance;  ///< of color, as the mean of its samples; empty: not known
  /// What of the picture is left as it is, and not in `color`: lamps as they are seen, directly or by way of
  /// mirrors and glass. Empty: nothing.
  std::vector<float> kept;
};

/// Color and the channels `albedo`, `N`, `variance` and `emission`, where there are all three of each. What
/// is not finite becomes 0, and colors are made non-negative: a denoiser would spread a NaN over its whole
/// neighbourhood. Emission is kept out of color: a lamp that fills one pixel, a thousand times as bright as
/// its surroundings, is spread likewise, and has little noise where it is seen at all.
Input make_input(const image::Image& image, const image::Channels& channels);

/// @throws regulus::Error (Failed), with what to do, if Open Image Denoise cannot be loaded
void require_open_image_denoise(const std::string& library);

/// Open Image Denoise 2 (openimagedenoise.org), on the processor: albedo and normal are denoised first, then
/// the picture with them. Without a normal albedo is used alone, without an albedo neither.
/// @param library file of libOpenImageDenoise.so.2; empty: $REGULUS_OIDN, or else what the system finds
/// @returns colors like Input::color
/// @throws regulus::Error (Failed) if it cannot be loaded, or fails
std::vector<float> by_open_image_denoise(const Input& input, const std::string& library);

/// A cross filter of our own: means over windows of 15x15 pixels whose weights fall with the distance of
/// patches in color, relative to their variance, and of albedo and normal (as Rousselle, Manzi and Zwicker
/// 2013, in one pass).
/// @throws regulus::Error (BadFile) if variance, albedo or normal are not known
std::vector<float> by_cross_filter(const Input& input);

enum class Method { OpenImageDenoise, CrossFilter };

/// Open Image Denoise where it can be loaded, otherwise the cross filter.
Method best_available(const std::string& library);

/// The picture by one of them: denoised, and what was kept of it.
/// @throws regulus::Error as they do
std::vector<float> denoised(const Input& input, Method method, const std::string& library);

/// Gives the picture its denoised colors; those it had go to the channels noisy.R, noisy.G and noisy.B, and
/// `regulus:denoised` says by what.
void put_denoised(std::vector<float> colors, const std::string& by, image::Image& image,
                  image::Channels& channels, image::Attributes& attributes);

}  // namespace regulus::denoise
