#include "scene/environment.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scene/light_power.hpp"

namespace regulus::scene {
namespace {

using std::numbers::pi;
// Every cell that shines gets at least about this share of its row, and every row of the map: less would be
// lost in the rounding of single-precision sums near 1 and of 24-bit random numbers.
constexpr double LEAST_SHARE = 0x1p-20;

/// Share of a texel in the mean over its own cell, and of each neighbour along one axis: bilinear weights
/// integrated from the texel's centre to its border.
constexpr double OWN_SHARE = 0.75, NEIGHBOUR_SHARE = 0.125;

/// Appends the cumulative distribution of `weights` (n + 1 entries from 0 to 1; uniform if all are 0).
void append_cdf(const std::vector<double>& weights, std::vector<float>& cdf) {
  double total = 0;
  for (const double weight : weights) total += weight;
  std::vector<double> shares(weights.size(), 1);
  if (total > 0)
    for (size_t i = 0; i < weights.size(); ++i)
      shares[i] = weights[i] > 0 ? weights[i] / total + LEAST_SHARE : 0;
  double sum = 0;
  for (const double share : shares) sum += share;
  double below = 0;
  cdf.push_back(0);
  for (const double share : shares) {
    below += share;  // in the order of `sum`, so that behind the last cell with a share stands exactly 1
    cdf.push_back(static_cast<float>(below / sum));
  }
}

/// Mean luminances of the cells of row y.
std::vector<double> row_means(const std::vector<glm::vec3>& texels, size_t width, size_t height, size_t y) {
  const size_t above = y == 0 ? 0 : y - 1;
  const size_t below = std::min(y + 1, height - 1);
  std::vector<double> blended(width);
  for (size_t x = 0; x < width; ++x)
    blended[x] = OWN_SHARE * luminance(glm::dvec3(texels[y * width + x])) +
                 NEIGHBOUR_SHARE * (luminance(glm::dvec3(texels[above * width + x])) +
                                    luminance(glm::dvec3(texels[below * width + x])));
  std::vector<double> means(width);
  for (size_t x = 0; x < width; ++x)
    means[x] = OWN_SHARE * blended[x] +
               NEIGHBOUR_SHARE * (blended[(x + width - 1) % width] + blended[(x + 1) % width]);
  return means;
}

}  // namespace

Environment uniform_environment(const glm::vec3& radiance) {
  Environment environment;
  environment.parameters.radiance = radiance;
  environment.integral = 4 * pi * luminance(glm::dvec3(radiance));
  return environment;
}

Environment map_environment(std::vector<glm::vec3> texels, uint32_t width, double rotation) {
  if (std::all_of(texels.begin(), texels.end(), [&](const glm::vec3& t) { return t == texels.front(); }))
    return uniform_environment(texels.front());
  const size_t height = texels.size() / width;
  Environment environment;
  environment.parameters.width = width;
  environment.parameters.height = static_cast<uint32_t>(height);
  environment.parameters.rotation = static_cast<float>(rotation - std::floor(rotation));
  std::vector<double> rows;
  std::vector<float> conditional;
  conditional.reserve(height * (width + 1));
  for (size_t y = 0; y < height; ++y) {
    const double step = pi / static_cast<double>(height);
    const double cell_solid_angle =
        2 * pi / width *
        (std::cos(step * static_cast<double>(y)) - std::cos(step * static_cast<double>(y + 1)));
    const std::vector<double> means = row_means(texels, width, height, y);
    double sum = 0;
    for (const double mean : means) sum += mean;
    rows.push_back(sum * cell_solid_angle);
    environment.integral += rows.back();
    append_cdf(means, conditional);
  }
  append_cdf(rows, environment.cdf);
  environment.cdf.insert(environment.cdf.end(), conditional.begin(), conditional.end());
  environment.texels = std::move(texels);
  return environment;
}

}  // namespace regulus::scene
