#include <algorithm>
#include <cmath>

#include "interface/wavefront.h"
#include "probe/probe.hpp"

namespace regulus::probe {

using glm::dvec3;

namespace {

constexpr uint32_t TILE = 6;  // pixels along each side

/// Of colours: squares averaged over channels.
double squared(const dvec3& color) {
  return dot(color, color) / 3;
}

/// The film in tiles, row by row.
struct Tiles {
  uint32_t width, height;
  uint32_t columns() const { return (width + TILE - 1) / TILE; }
  size_t count() const { return size_t{columns()} * ((height + TILE - 1) / TILE); }
  size_t of(uint32_t pixel) const { return size_t{pixel / width / TILE} * columns() + pixel % width / TILE; }
  /// Number of pixels of each.
  std::vector<double> sizes() const {
    std::vector<double> sizes(count(), 0);
    for (uint32_t pixel = 0; pixel < width * height; ++pixel) ++sizes[of(pixel)];
    return sizes;
  }
};

/// What a set makes of a path, whoever found it.
struct Share {
  double value = 0;   ///< factor of v for what the set would contribute
  double chance = 0;  ///< how often the set finds it, in terms of how often all techniques do
  double square = 0;  ///< factor of v^2 for what that adds to the squares of pixels
};

Share share_of(const FoundPath& path, uint32_t set, double splat_squares) {
  double weights = 0, densities = 0, squares = 0;
  for (size_t kind = 0; kind < path.weights.size(); ++kind)
    if ((set & 1u << kind) != 0) {
      weights += path.weights[kind];
      densities += path.densities[kind];
      squares += path.densities[kind] * (1u << kind == interface::TECHNIQUE_SPLAT ? splat_squares : 1);
    }
  return weights > 0 ? Share{1 / weights, densities, squares / (weights * weights)} : Share{};
}

/// What others find in a tile beyond what was found, and beyond their own errors; 0: nothing.
double unfound_light(const TileMeans& found, const TileMeans& others, double scale) {
  constexpr double OWN_ERRORS = 0.25;
  // The lesser half: what one sample found proves nothing.
  const dvec3 first = others[0] - found[0], second = others[1] - found[1];
  const double missed = std::min(first.r + first.g + first.b, second.r + second.g + second.b) / 3;
  return std::max(missed - OWN_ERRORS * scale, 0.0);
}

/// Sums over what one set finds.
class Judge {
 public:
  Judge(const Findings& findings, const std::vector<double>& scales, uint32_t set, double samples)
      : findings_(findings),
        scales_(scales),
        set_(set),
        samples_(samples),
        tiles_{findings.width, findings.height},
        variances_(tiles_.count(), 0),
        means_(tiles_.count(), TileMeans{}),
        camera_(size_t{findings.width} * findings.height, dvec3(0)),
        camera_squares_(camera_.size(), 0) {}

  double error(const std::vector<TileMeans>& truth) {
    const std::vector<FoundPath>& paths = findings_.paths;
    for (size_t begin = 0, end = 0; begin < paths.size(); begin = end) {
      while (end < paths.size() && is_same_sample(paths[begin], paths[end])) ++end;
      take_sample(begin, end);
    }
    take_off_means();
    const std::vector<double> sizes = tiles_.sizes();
    double variance = 0, bias = 0;
    for (size_t tile = 0; tile < tiles_.count(); ++tile) {
      const double weight = scales_[tile] > 0 ? 1 / (scales_[tile] * scales_[tile]) : 0;
      variance += weight * std::max(variances_[tile] / findings_.iterations, 0.0);
      // The product of two halves: chance moves it to both sides of the square.
      const double half = 0.5 * findings_.iterations * sizes[tile];
      bias += weight * sizes[tile] *
              dot(means_[tile][0] / half - truth[tile][0], means_[tile][1] / half - truth[tile][1]) / 3;
    }
    return (variance + samples_ * std::max(bias, 0.0)) / static_cast<double>(camera_.size());
  }

 private:
  static bool is_same_sample(const FoundPath& a, const FoundPath& b) {
    return a.pixel == b.pixel && a.iteration == b.iteration;
  }

  void take_sample(size_t begin, size_t end) {
    dvec3 total(0);
    double squares = 0;
    const uint32_t pixel = findings_.paths[begin].pixel;
    const size_t tile = tiles_.of(pixel);
    for (size_t i = begin; i < end; ++i) {
      const FoundPath& path = findings_.paths[i];
      const Share share = share_of(path, set_, findings_.splat_squares);
      const dvec3 value = share.value * path.value;
      variances_[tile] += share.square * squared(path.value);
      means_[tile][path.iteration % 2] += share.chance * value;
      if ((path.technique & set_) == 0 || path.technique == interface::TECHNIQUE_SPLAT) continue;
      total += value;
      squares += squared(value);
    }
    variances_[tile] += squared(total) - squares;
    camera_[pixel] += total;
    camera_squares_[pixel] += squared(total);
  }

  // The squares of pixels' means, from products of different samples, which chance does not raise.
  void take_off_means() {
    const double n = findings_.iterations;
    for (uint32_t pixel = 0; pixel < camera_.size(); ++pixel)
      variances_[tiles_.of(pixel)] -= (squared(camera_[pixel]) - camera_squares_[pixel]) / (n - 1);
  }

  const Findings& findings_;
  const std::vector<double>& scales_;
  uint32_t set_;
  double samples_;
  Tiles tiles_;
  std::vector<double> variances_;  // by tile, summed over pixels and iterations
  std::vector<TileMeans> means_;   // likewise
  std::vector<dvec3> camera_;      // by pixel: sums of what camera paths bring
  std::vector<double> camera_squares_;
};

}  // namespace

std::vector<TileMeans> tile_means(const Findings& findings) {
  const Tiles tiles{findings.width, findings.height};
  const std::vector<double> sizes = tiles.sizes();
  std::vector<TileMeans> means(tiles.count(), TileMeans{});
  for (const FoundPath& path : findings.paths) means[tiles.of(path.pixel)][path.iteration % 2] += path.value;
  for (size_t tile = 0; tile < means.size(); ++tile)
    for (dvec3& mean : means[tile]) mean /= 0.5 * findings.iterations * sizes[tile];
  return means;
}

double typical_brightness(const Findings& findings) {
  double sum = 0;
  const std::vector<TileMeans> means = tile_means(findings);
  for (const TileMeans& tile : means) sum += std::sqrt(std::sqrt(squared(0.5 * (tile[0] + tile[1]))));
  return std::pow(sum / static_cast<double>(means.size()), 2);
}

std::vector<double> tile_scales(const std::vector<TileMeans>& means) {
  const auto mean_of = [](const TileMeans& halves) { return 0.5 * (halves[0] + halves[1]); };
  dvec3 whole(0);
  for (const TileMeans& tile : means) whole += mean_of(tile) / static_cast<double>(means.size());
  std::vector<double> scales;
  scales.reserve(means.size());
  for (const TileMeans& tile : means) scales.push_back(std::sqrt(squared(mean_of(tile)) + squared(whole)));
  return scales;
}

void clamp_values(Findings& findings, const std::vector<double>& scales, double most) {
  const Tiles tiles{findings.width, findings.height};
  for (FoundPath& path : findings.paths) {
    const double size = std::sqrt(squared(path.value)), limit = most * scales[tiles.of(path.pixel)];
    if (size > limit) path.value *= limit / size;
  }
}

double relative_error(const Findings& findings, const std::vector<TileMeans>& truth,
                      const std::vector<double>& scales, uint32_t techniques, double samples) {
  return Judge(findings, scales, techniques, samples).error(truth);
}

double missing_share(const Findings& findings, uint32_t techniques) {
  double all = 0, missing = 0;
  for (const FoundPath& path : findings.paths) {
    const double light = path.value.r + path.value.g + path.value.b;
    all += light;
    if (share_of(path, techniques, 1).chance == 0) missing += light;
  }
  return all > 0 ? missing / all : 0;
}

double unfound_variance(const Findings& plain, const Findings& regularized,
                        const std::vector<double>& scales) {
  const std::vector<TileMeans> found = tile_means(plain), all = tile_means(regularized);
  const std::vector<double> sizes = Tiles{plain.width, plain.height}.sizes();
  double sum = 0, pixels = 0;
  for (size_t tile = 0; tile < scales.size(); ++tile) {
    pixels += sizes[tile];
    const double missed = unfound_light(found[tile], all[tile], scales[tile]);
    if (missed > 0)
      sum += sizes[tile] * sizes[tile] * plain.iterations * missed * missed / (scales[tile] * scales[tile]);
  }
  return sum / pixels;
}

std::vector<TileMeans> joint_means(const Findings& plain, const Findings& regularized,
                                   const std::vector<double>& scales) {
  std::vector<TileMeans> means = tile_means(plain);
  const std::vector<TileMeans> all = tile_means(regularized);
  for (size_t tile = 0; tile < means.size(); ++tile)
    if (unfound_light(means[tile], all[tile], scales[tile]) > 0) means[tile] = all[tile];
  return means;
}

double hidden_variance(const Findings& findings, const std::vector<double>& scales, uint32_t techniques) {
  const Tiles tiles{findings.width, findings.height};
  double sum = 0;
  for (const FoundPath& path : findings.paths) {
    const double scale = scales[tiles.of(path.pixel)];
    if ((path.other_finders & techniques) == 0 && scale > 0)
      sum += dot(path.value, path.value_of_hit) / 3 / (scale * scale);
  }
  return sum / (static_cast<double>(findings.width) * findings.height * findings.iterations);
}

}  // namespace regulus::probe
