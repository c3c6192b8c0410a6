#include <algorithm>
#include <cmath>

#include "image/encoding.hpp"

namespace regulus::image {

namespace {

constexpr std::array<const char*, 5> NAMES = {"neutral", "standard", "agx", "filmic", "raw"};  // as in View
constexpr float BRIGHTEST = 1e6f;  // keeps infinity out of what follows

using Color = std::array<float, 3>;

Color transformed(const float (&matrix)[3][3], const Color& color) {
  Color result{};
  for (int row = 0; row < 3; ++row)
    for (int i = 0; i < 3; ++i) result[row] += matrix[row][i] * color[i];
  return result;
}

/// Wrensch, "Minimal AgX Implementation": into AgX's primaries, logarithm of base 2 between two exposures, a
/// sigmoid fitted by a polynomial of degree 6, and back. The result is encoded.
Color agx(const Color& color) {
  constexpr float INTO[3][3] = {{0.842479062253094f, 0.0784335999999992f, 0.0792237451477643f},
                                {0.0423282422610123f, 0.878468636469772f, 0.0791661274605434f},
                                {0.0423756549057051f, 0.0784336f, 0.879142973793104f}};
  constexpr float BACK[3][3] = {{1.19687900512017f, -0.0980208811401368f, -0.0990297440797205f},
                                {-0.0528968517574562f, 1.15190312990417f, -0.0989611768448433f},
                                {-0.0529716355144438f, -0.0980434501171241f, 1.15107367264116f}};
  constexpr float LEAST_STOPS = -12.47393f, MOST_STOPS = 4.026069f;
  Color value = transformed(INTO, color);
  for (float& v : value) {
    v = std::clamp(std::log2(std::max(v, 1e-10f)), LEAST_STOPS, MOST_STOPS);
    const float x = (v - LEAST_STOPS) / (MOST_STOPS - LEAST_STOPS);
    v = (((((15.5f * x - 40.14f) * x + 31.96f) * x - 6.868f) * x + 0.4298f) * x + 0.1191f) * x - 0.00232f;
  }
  return transformed(BACK, value);
}

/// Hable, "Filmic Tonemapping Operators" (2010).
float hable(float x) {
  constexpr float A = 0.15f, B = 0.5f, C = 0.1f, D = 0.2f, E = 0.02f, F = 0.3f;
  return (x * (A * x + C * B) + D * E) / (x * (A * x + B) + D * F) - E / F;
}

Color filmic(const Color& color) {
  constexpr float EXPOSURE_BIAS = 2, WHITE = 11.2f;
  Color result{};
  for (int i = 0; i < 3; ++i) result[i] = hable(EXPOSURE_BIAS * color[i]) / hable(WHITE);
  return result;
}

Color encoded(Color color) {
  for (float& value : color) value = srgb_encode(std::clamp(value, 0.0f, 1.0f));
  return color;
}

}  // namespace

std::vector<std::string> view_names() {
  return {NAMES.begin(), NAMES.end()};
}

View view_of(const std::string& name) {
  return static_cast<View>(std::ranges::find(NAMES, name) - NAMES.begin());
}

Color display(const View view, const Color& linear) {
  Color color = linear;
  for (float& value : color) value = value > 0 ? std::min(value, BRIGHTEST) : 0;  // NaN becomes 0
  switch (view) {
    case View::Neutral:
      return encoded(tone_map(color));
    case View::Standard:
      return encoded(color);
    case View::Agx:
      color = agx(color);
      break;
    case View::Filmic:
      return encoded(filmic(color));
    case View::Raw:
      break;
  }
  for (float& value : color) value = std::clamp(value, 0.0f, 1.0f);
  return color;
}

float automatic_exposure(const Image& image) {
  constexpr double MIDDLE_GREY = 0.18;
  double sum = 0;
  uint64_t count = 0;
  for (size_t i = 0; i + 2 < image.rgb.size(); i += 3) {
    const double luminance = 0.2126 * static_cast<double>(image.rgb[i]) +
                             0.7152 * static_cast<double>(image.rgb[i + 1]) +
                             0.0722 * static_cast<double>(image.rgb[i + 2]);
    if (!std::isfinite(luminance) || luminance <= 0) continue;
    sum += std::log2(luminance);
    ++count;
  }
  return count == 0 ? 0 : static_cast<float>(std::log2(MIDDLE_GREY) - sum / static_cast<double>(count));
}

}  // namespace regulus::image
