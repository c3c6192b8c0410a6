#include "images/support/report_cases.hpp"

#include <algorithm>

namespace regulus::test {
namespace {

// Of floats: edges of emitters run between pixels.
constexpr double EXACT = 1e-5;

/// Five standard errors of the mean of so many paths, none of which brings more than 1.
double random_bound(double radiance, double paths) {
  return EXACT + 5 * std::sqrt(radiance * std::max(1 - radiance, 0.0) / paths);
}

/// Between faces, as the file's floats have it, of a slab of index 1.5 in front of something white.
double behind_slab(double thickness_in_half_lives) {
  const double f = 0.04, t = std::pow(0.5, thickness_in_half_lives);
  return (1 - f) * (1 - f) * t / (1 - f * f * t * t);
}

/// How thick a slab is that begins at height .5.
double thickness(double nominal) {
  return (double{static_cast<float>(0.5 + nominal)} - 0.5) / nominal;
}

/// Two metres of a medium of .5 per metre along the axis, more at the edges of a field of .3: mean over the
/// film.
double through_fog() {
  constexpr int CELLS = 8;
  double sum = 0;
  for (int i = 0; i < CELLS * CELLS; ++i) {
    const double x = std::tan(0.15) * (2 * (i % CELLS + 0.5) / CELLS - 1);
    const double y = std::tan(0.15) * (2 * (i / CELLS + 0.5) / CELLS - 1);
    sum += std::pow(0.5, 2 * std::sqrt(1 + x * x + y * y));
  }
  return sum / (CELLS * CELLS);
}

ReportCase slab(const char* file, double nominal) {
  constexpr uint32_t SIZE = 12, SAMPLES = 64;
  const double radiance = behind_slab(thickness(nominal));
  return {file, radiance, random_bound(radiance, SIZE * SIZE * SAMPLES), Part::Whole, 0, SIZE, SAMPLES};
}

}  // namespace

std::vector<ReportCase> report_cases() {
  return {
      {"camera-in-medium/c3.gltf", through_fog(), 2e-4},
      {"clear-inside-absorbing/c2a.gltf", 0.125, random_bound(0.125, 1024)},
      {"clear-inside-absorbing/c2b.gltf", 0.25, random_bound(0.25, 1024)},
      {"touching-glass/c25b.gltf", 1, 1e-4},
      {"touching-glass/c25c.gltf", 1, 1e-4},
      {"liquid-overlaps-glass/c26.gltf", 0.5, random_bound(0.5, 1024)},
      {"far-from-origin/c22a.gltf", 0.25, EXACT},
      {"far-from-origin/c22b.gltf", 0.25, EXACT},
      {"skin-at-rest/c5a.gltf", 0.25, EXACT},
      {"morph-default-weights/c4a.gltf", 0, EXACT, Part::Left},
      {"morph-default-weights/c4a.gltf", 0.5, EXACT, Part::Right},
      {"node-visibility/c21.gltf", 0, EXACT, Part::Left},
      {"node-visibility/c21r.gltf", 0, EXACT, Part::Left},
      {"rounded-matrix/c18a.gltf", 1, EXACT},
      // Walks that roulette keeps carry 1 but for the last weight, at most 1.06 T(cos) / T: varying by less
      // than .3.
      {"half-transmissive-furnace/c13a.gltf", 1, 5 * 0.3 / std::sqrt(12 * 12 * 32.0), Part::Whole, 0, 12, 32,
       64},
      {"film-range/lamp-2e16.gltf", 2e16, 2e16 * EXACT, Part::Whole, 0, 8, 5},
      slab("thin-absorbing-slab/slab-0.01.gltf", 1e-2),
      slab("thin-absorbing-slab/slab-1e-05.gltf", 1e-5),
      slab("thin-absorbing-slab/slab-1e-06.gltf", 1e-6),
      slab("thin-absorbing-slab/slab-1e-07.gltf", 1e-7),
      // By rational arithmetic (tilted.py beside the files); the bound is of a thousand samples of what
      // varies by .02.
      {"thin-absorbing-slab/tilted-17.gltf", 0.47424, 1e-3, Part::Whole, 0, 12, 64},
      {"thin-absorbing-slab/tilted-30.gltf", 0.42390, 1e-3, Part::Whole, 0, 12, 64},
      {"thin-absorbing-slab/tilted-30-reversed.gltf", 0.45390, 1e-3, Part::Whole, 0, 12, 64},
      // By quadrature (docs/derivations/rough_base.py), to three digits; most of the light at depth 2.
      {"rough-dielectric-furnace/f0.5.glb", 0.823, 0.02, Part::Whole, 2, 8, 512, 2},
      {"rough-dielectric-furnace/f1.glb", 0.812, 0.02, Part::Whole, 3, 8, 512, 2},
  };
}

std::filesystem::path report_file(const ReportCase& c) {
  return std::filesystem::path(REGULUS_SOURCE_DIR) / "tests" / "cases" / c.file;
}

double mean_of_part(const image::Image& image, Part part) {
  double sum = 0;
  size_t count = 0;
  for (uint32_t y = 0; y < image.height; ++y)
    for (uint32_t x = 0; x < image.width; ++x) {
      if (part != Part::Whole && (part == Part::Left) != (2 * x < image.width)) continue;
      sum += double{image.rgb[3 * (size_t{y} * image.width + x)]};
      ++count;
    }
  return sum / static_cast<double>(count);
}

}  // namespace regulus::test
