// HDR-FLIP: the difference that an observer sees when flipping between two images.
#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>
#include <span>

#include "image/image.hpp"

namespace regulus::image {
namespace {

using glm::vec3;
using std::numbers::pi_v;

// Constants of the LDR paper, sections 4 and 5, by its names.
constexpr float Q_C = 0.7f, P_C = 0.4f, P_T = 0.95f, Q_F = 0.5f;
constexpr float FEATURE_WIDTH_DEGREES = 0.082f;
// Sum of a * sqrt(pi / b) * exp(-pi^2 x^2 / b) per channel: contrast sensitivity, x in degrees.
struct Sensitivity {
  float a, b;
};
constexpr Sensitivity ACHROMATIC{1, 0.0047f}, RED_GREEN{1, 0.0053f};
constexpr Sensitivity BLUE_YELLOW[2]{{34.1f, 0.04f}, {13.5f, 0.025f}};
constexpr float WIDEST_B = 0.04f;

/// D65 and the conversions of sRGB's primaries as the authors have them.
constexpr vec3 REFERENCE_WHITE{0.950428545f, 1.0f, 1.088900371f};
const glm::mat3 RGB_TO_XYZ =
    glm::transpose(glm::mat3{10135552.0f / 24577794.0f, 8788810.0f / 24577794.0f, 4435075.0f / 24577794.0f,
                             2613072.0f / 12288897.0f, 8788810.0f / 12288897.0f, 887015.0f / 12288897.0f,
                             1425312.0f / 73733382.0f, 8788810.0f / 73733382.0f, 70074185.0f / 73733382.0f});
const glm::mat3 XYZ_TO_RGB = glm::inverse(RGB_TO_XYZ);

/// The opponent space YCxCz: linear in XYZ.
vec3 to_ycxcz(const vec3& rgb) {
  const vec3 xyz = RGB_TO_XYZ * rgb / REFERENCE_WHITE;
  return {116 * xyz.y - 16, 500 * (xyz.x - xyz.y), 200 * (xyz.y - xyz.z)};
}

vec3 from_ycxcz(const vec3& ycxcz) {
  const float y = (ycxcz.x + 16) / 116;
  return XYZ_TO_RGB * (vec3{y + ycxcz.y / 500, y, y - ycxcz.z / 200} * REFERENCE_WHITE);
}

/// CIELAB with the Hunt effect: colour counts for more where it is bright.
vec3 to_hunt_lab(const vec3& rgb) {
  const auto f = [](float x) {
    constexpr float DELTA = 6.0f / 29;
    return x > DELTA * DELTA * DELTA ? std::cbrt(x) : x / (3 * DELTA * DELTA) + 4.0f / 29;
  };
  const vec3 xyz = RGB_TO_XYZ * rgb / REFERENCE_WHITE;
  const float y = f(xyz.y), lightness = 116 * y - 16;
  return {lightness, 0.01f * lightness * 500 * (f(xyz.x) - y), 0.01f * lightness * 200 * (y - f(xyz.z))};
}

float hyab(const vec3& a, const vec3& b) {
  return std::abs(a.x - b.x) + std::hypot(a.y - b.y, a.z - b.z);
}

/// Symmetric taps -radius ... radius.
using Kernel = std::vector<float>;

template <typename Function>
Kernel make_kernel(int radius, const Function& function) {
  Kernel kernel;
  for (int x = -radius; x <= radius; ++x) kernel.push_back(function(static_cast<float>(x)));
  return kernel;
}

/// Scales positive taps to a sum of 1 and negative ones to a sum of -1.
Kernel normalized(Kernel kernel) {
  float positive = 0, negative = 0;
  for (const float tap : kernel) (tap > 0 ? positive : negative) += std::abs(tap);
  for (float& tap : kernel) tap /= tap > 0 ? positive : negative;
  return kernel;
}

/// One channel of an image.
struct Plane {
  int width, height;
  std::vector<float> values;
};

/// Adds the taps along a row of `width` values; the row's ends are repeated.
void filter_row(const float* from, float* to, int width, const Kernel& kernel) {
  const size_t radius = kernel.size() / 2;
  std::vector<float> padded(radius, from[0]);
  padded.insert(padded.end(), from, from + width);
  padded.insert(padded.end(), radius, from[width - 1]);
  for (size_t tap = 0; tap < kernel.size(); ++tap)
    for (int x = 0; x < width; ++x) to[x] += kernel[tap] * padded[tap + static_cast<size_t>(x)];
}

/// Separable convolution; the image's border is repeated.
Plane convolve(const Plane& plane, const Kernel& across, const Kernel& down) {
  const int width = plane.width, height = plane.height, radius = static_cast<int>(down.size() / 2);
  Plane rows{width, height, std::vector<float>(plane.values.size())}, result = rows;
  const auto row = [width](auto& values, int y) { return values.data() + std::ptrdiff_t{y} * width; };
  for (int y = 0; y < height; ++y) filter_row(row(plane.values, y), row(rows.values, y), width, across);
  for (int y = 0; y < height; ++y)
    for (size_t tap = 0; tap < down.size(); ++tap) {
      const float weight = down[tap];
      const float* from = row(rows.values, std::clamp(y + static_cast<int>(tap) - radius, 0, height - 1));
      float* to = row(result.values, y);
      for (int x = 0; x < width; ++x) to[x] += weight * from[x];
    }
  return result;
}

/// The filters for a number of pixels per degree.
struct Filters {
  Kernel achromatic, red_green, blue_yellow[2];
  Kernel feature, edge, point;  ///< a Gaussian and its first two derivatives

  explicit Filters(float pixels_per_degree) {
    constexpr float PI = pi_v<float>;
    const int radius =
        static_cast<int>(std::ceil(3 * std::sqrt(WIDEST_B / (2 * PI * PI)) * pixels_per_degree));
    const auto gaussian = [&](const Sensitivity& s, float amplitude) {
      return make_kernel(radius, [&](float x) {
        const float degrees = x / pixels_per_degree;
        return amplitude * std::exp(-PI * PI * degrees * degrees / s.b);
      });
    };
    achromatic = normalized(gaussian(ACHROMATIC, 1));
    red_green = normalized(gaussian(RED_GREEN, 1));
    // The sum of two Gaussians is not separable, each of them is: half of its amplitude's logarithm per pass.
    float total = 0;
    for (size_t k = 0; k < 2; ++k) {
      const Sensitivity& s = BLUE_YELLOW[k];
      blue_yellow[k] = gaussian(s, std::sqrt(s.a * std::sqrt(PI / s.b)));
      float sum = 0;
      for (const float tap : blue_yellow[k]) sum += tap;
      total += sum * sum;
    }
    for (Kernel& kernel : blue_yellow)
      for (float& tap : kernel) tap /= std::sqrt(total);

    const float sigma = 0.5f * FEATURE_WIDTH_DEGREES * pixels_per_degree;
    const int feature_radius = static_cast<int>(std::ceil(3 * sigma));
    const auto g = [&](float x) { return std::exp(-x * x / (2 * sigma * sigma)); };
    feature = normalized(make_kernel(feature_radius, g));
    edge = normalized(make_kernel(feature_radius, [&](float x) { return -x * g(x); }));
    point = normalized(
        make_kernel(feature_radius, [&](float x) { return (x * x / (sigma * sigma) - 1) * g(x); }));
  }
};

/// What is compared of one image at one exposure.
struct Appearance {
  std::vector<vec3> lab;           ///< filtered as the eye does, CIELAB with the Hunt effect
  std::vector<float> edge, point;  ///< lengths of the filtered gradient and second derivative
};

std::vector<float> lengths(const Plane& x, const Plane& y) {
  std::vector<float> result(x.values.size());
  for (size_t i = 0; i < result.size(); ++i) result[i] = std::hypot(x.values[i], y.values[i]);
  return result;
}

Appearance appearance(const std::vector<vec3>& rgb, int width, int height, const Filters& filters) {
  Plane y{width, height, {}}, cx = y, cz = y, luminance = y;
  for (const vec3& color : rgb) {
    const vec3 ycxcz = to_ycxcz(color);
    y.values.push_back(ycxcz.x);
    cx.values.push_back(ycxcz.y);
    cz.values.push_back(ycxcz.z);
    luminance.values.push_back((ycxcz.x + 16) / 116);
  }
  y = convolve(y, filters.achromatic, filters.achromatic);
  cx = convolve(cx, filters.red_green, filters.red_green);
  const Plane cz_wide = convolve(cz, filters.blue_yellow[0], filters.blue_yellow[0]);
  const Plane cz_narrow = convolve(cz, filters.blue_yellow[1], filters.blue_yellow[1]);
  Appearance result;
  for (size_t i = 0; i < rgb.size(); ++i) {
    const vec3 ycxcz{y.values[i], cx.values[i], cz_wide.values[i] + cz_narrow.values[i]};
    result.lab.push_back(to_hunt_lab(glm::clamp(from_ycxcz(ycxcz), 0.0f, 1.0f)));
  }
  result.edge = lengths(convolve(luminance, filters.edge, filters.feature),
                        convolve(luminance, filters.feature, filters.edge));
  result.point = lengths(convolve(luminance, filters.point, filters.feature),
                         convolve(luminance, filters.feature, filters.point));
  return result;
}

/// LDR-FLIP of two pixels.
float difference(const Appearance& a, const Appearance& b, size_t i) {
  static const float LARGEST =
      std::pow(hyab(to_hunt_lab({0, 1, 0}), to_hunt_lab({0, 0, 1})), Q_C);  // of any two colours in gamut
  const float distance = std::pow(hyab(a.lab[i], b.lab[i]), Q_C), knee = P_C * LARGEST;
  const float color =
      distance < knee ? distance * P_T / knee : P_T + (distance - knee) / (LARGEST - knee) * (1 - P_T);
  const float feature = std::max(std::abs(a.edge[i] - b.edge[i]), std::abs(a.point[i] - b.point[i]));
  return std::pow(color, 1 - std::pow(feature / std::numbers::sqrt2_v<float>, Q_F));
}

/// The tone mapper of the HDR paper: ACES as fitted by Narkowicz, with its exposure of 0.6 taken out.
constexpr float ACES[6] = {0.36f * 2.51f, 0.6f * 0.03f, 0, 0.36f * 2.43f, 0.6f * 0.59f, 0.14f};

std::vector<vec3> exposed(const Image& image, float exposure) {
  const float scale = std::exp2(exposure);
  std::vector<vec3> result;
  result.reserve(image.rgb.size() / 3);
  for (size_t i = 0; i + 2 < image.rgb.size(); i += 3) {
    vec3 color;
    for (int c = 0; c < 3; ++c) {
      const float value = image.rgb[i + static_cast<size_t>(c)];
      // A linear value this large is white; squared it would overflow.
      const float x = std::isfinite(value) ? std::min(value * scale, 1e15f) : 0;
      color[c] = (ACES[0] * x * x + ACES[1] * x + ACES[2]) / (ACES[3] * x * x + ACES[4] * x + ACES[5]);
    }
    result.push_back(glm::clamp(color, 0.0f, 1.0f));
  }
  return result;
}

/// Exposures from the one that brings the brightest pixel of the reference to 0.85 after tone mapping to the
/// one that brings its median there, at steps of a stop or less (HDR paper, section 3).
std::vector<float> exposures(const Image& reference) {
  std::vector<float> luminances;
  for (size_t i = 0; i + 2 < reference.rgb.size(); i += 3) {
    const float* rgb = &reference.rgb[i];
    const float luminance = 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2];
    if (std::isfinite(luminance)) luminances.push_back(luminance);
  }
  std::sort(luminances.begin(), luminances.end());
  if (luminances.empty() || !(luminances.back() > 0)) return {0};
  float median = luminances[luminances.size() / 2];
  if (!(median > 0)) median = *std::upper_bound(luminances.begin(), luminances.end(), 0.0f);
  constexpr float T = 0.85f;
  const float a = ACES[0] - T * ACES[3], b = ACES[1] - T * ACES[4], c = ACES[2] - T * ACES[5];
  const float half = -0.5f * b / a, bright = half + std::sqrt(half * half - c / a);
  const float start = std::log2(bright / luminances.back()), stop = std::log2(bright / median);
  const int count = std::max(2, static_cast<int>(std::ceil(stop - start)));
  std::vector<float> result(static_cast<size_t>(count));
  for (size_t i = 0; i < result.size(); ++i)
    result[i] = start + static_cast<float>(i) * (stop - start) / static_cast<float>(count - 1);
  return result;
}

}  // namespace

std::vector<float> flip_map(const Image& image, const Image& reference, float pixels_per_degree) {
  require_same_size(image, reference);
  const Filters filters(pixels_per_degree);
  const int width = static_cast<int>(reference.width), height = static_cast<int>(reference.height);
  std::vector<float> map(reference.rgb.size() / 3);
  for (const float exposure : exposures(reference)) {
    const Appearance seen = appearance(exposed(image, exposure), width, height, filters);
    const Appearance expected = appearance(exposed(reference, exposure), width, height, filters);
    for (size_t i = 0; i < map.size(); ++i) map[i] = std::max(map[i], difference(seen, expected, i));
  }
  return map;
}

double flip(const Image& image, const Image& reference) {
  double sum = 0;
  const std::vector<float> map = flip_map(image, reference);
  for (const float value : map) sum += value;
  return sum / static_cast<double>(map.size());
}

}  // namespace regulus::image
