// What each set of techniques would leave as noise and cost, from few paths of all of them: Grittmann,
// Yazici, Georgiev and Slusallek, "Efficiency-aware multiple importance sampling for bidirectional rendering
// algorithms", 2022. The scalar reference finds the paths, so that nothing is compiled for it and the answer
// is the same on every machine.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "reference/walk.hpp"
#include "reference/world.hpp"

namespace regulus::probe {

/// What one sample of every pixel takes: counts per pixel.
struct Work {
  double camera_rays = 0;    ///< closest hits of camera walks
  double light_rays = 0;     ///< and of light walks
  double light_samples = 0;  ///< camera vertices that `nee` connects to a light
  double splats = 0;         ///< light vertices that are connected to the lens
  double pairs = 0;          ///< of camera and light vertices that `connect` connects
  double lookups = 0;        ///< camera vertices for which `merge` looks up the vertices near them
  double merges = 0;         ///< those that it finds
};

inline constexpr std::array<double Work::*, 7> WORK_COUNTS = {
    &Work::camera_rays, &Work::light_rays, &Work::light_samples, &Work::splats,
    &Work::pairs,       &Work::lookups,    &Work::merges};

/// A path that a technique found, in terms of all that could have.
struct FoundPath {
  uint32_t pixel = 0;
  uint32_t iteration = 0;  ///< 0, 1, ... of the probe
  uint32_t technique = 0;  ///< TECHNIQUE_*, the one that found it
  glm::dvec3 value{0};     ///< weight times f_k / (n p), W/(m^2 sr) of its pixel
  /// By the bit of TECHNIQUE_*: shares in the sum of what weights compare, and in the density with which
  /// paths like this one are found.
  std::array<double, 5> weights{}, densities{};
  /// Of a path that only regularization lets a technique find, and hits find without it: what a hit is worth,
  /// and which techniques TECHNIQUE_* find it without regularization, too.
  glm::dvec3 value_of_hit{0};
  uint32_t other_finders = 0;
};

/// What few iterations by all of some techniques found.
struct Findings {
  uint32_t width = 0, height = 0, iterations = 0;
  uint32_t techniques = 0;       ///< TECHNIQUE_* bits
  double splat_squares = 1;      ///< what the pixel filter leaves of the squares of splats, which it spreads
  std::vector<FoundPath> paths;  ///< of at least two edges; those of one camera path follow each other
  Work work;                     ///< of all techniques
};

/// Makes the iterations of the settings' sample range with the scalar reference, on all processors. The
/// result does not depend on their number.
/// @param settings a film of few pixels, with techniques and regularization as a whole render would have them
Findings find_paths(const reference::World& world, const reference::Settings& settings);

/// The part of the work that a set of techniques would do.
Work work_of(const Work& all, uint32_t techniques);

/// Means of a tile of the film, of the even iterations and of the odd ones: two that chance moves apart.
using TileMeans = std::array<glm::dvec3, 2>;

/// What all techniques of the findings tell of each tile, row by row.
std::vector<TileMeans> tile_means(const Findings& findings);

/// Brightness of the tiles without what is seen to shine itself, W/(m^2 sr): the square of the mean of their
/// roots, for which dark tiles count more than for the mean.
double typical_brightness(const Findings& findings);

/// Of each tile, what errors are compared with: root of the sum of the squares of its mean and the picture's.
/// So nobody asks for the dark to be exact.
std::vector<double> tile_scales(const std::vector<TileMeans>& means);

/// Lets no path count for more than `most` times its tile's scale: what all techniques together find as
/// rarely as that is luck of the probe, and would decide alone.
void clamp_values(Findings& findings, const std::vector<double>& scales, double most);

/// Squared error, relative to the tiles' scales and averaged over the film, that a picture of `samples`
/// samples by a set of techniques is expected to have, times that number.
///
/// A path x that one of all techniques found has the value v = f / sum n p. A set S would have the second
/// moment, integral of f^2 / sum_S n p, of which v^2 (sum n p / sum_S n p) is an estimate, whoever found x:
/// light that S hardly ever meets counts as what it is. What the contributions of one camera path have in
/// common is added, and the square of the pixel's mean is taken off. Light that the set cannot find, or finds
/// too much or too little of by regularization, is an error of the mean.
/// @param truth of each tile, by findings without regularization
/// @param techniques a part of those of the findings
double relative_error(const Findings& findings, const std::vector<TileMeans>& truth,
                      const std::vector<double>& scales, uint32_t techniques, double samples);

/// Share of the light that no technique of a set can find, however long it renders.
double missing_share(const Findings& findings, uint32_t techniques);

/// What `techniques` without regularization have as variance beyond relative_error(), by light that no
/// technique but `hit` finds then, so rarely that a probe without regularization hardly meets it: lamps in
/// mirrors and behind glass. A hit that finds it is worth h, so that its second moment is the integral of f
/// h; regularized paths tell f.
/// @param findings with regularization
double hidden_variance(const Findings& findings, const std::vector<double>& scales, uint32_t techniques);

/// What every set without regularization has as variance at least, if regularized paths find light where
/// others have found none: n samples of a tile that miss light of the mean m miss something that is found
/// less often than once in n, and so has a second moment of n m^2 or more. A quarter of a tile's scale is
/// left to regularization's own errors.
double unfound_variance(const Findings& plain, const Findings& regularized,
                        const std::vector<double>& scales);

/// The means of plain findings, and of regularized ones where those find what the plain ones do not.
std::vector<TileMeans> joint_means(const Findings& plain, const Findings& regularized,
                                   const std::vector<double>& scales);

}  // namespace regulus::probe
