// `regulus check`: the device's stages, whole paths and images against the scalar reference, on real data of
// a scene.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "check/tally.hpp"
#include "gpu/gpu.hpp"
#include "prepared/prepared_scene.hpp"
#include "reference/walk.hpp"
#include "render/stage_recorder.hpp"

namespace regulus::check {

/// A scene with what both backends do. Everything referred to must outlive it.
struct Subject {
  const PreparedScene& prepared;
  const reference::World& world;
  const reference::Camera& camera;
  const render::Plan& plan;
  const reference::Settings& reference_settings;
};

/// Every stage of a recorded wave, the reference run on the stage's own inputs.
std::vector<Tally> check_stages(const Subject& subject, render::Pass pass,
                                const render::Recording& recording);

/// What an iteration's light vertices are sorted into: their paths' lists and counts, the grid, and the scans
/// of both. Integers, judged by what they have to satisfy, whatever the hash.
std::vector<Tally> check_sorting(const Subject& subject, const render::ConnectionRecording& recording);

/// An iteration with connections to the cache and merges: which vertices are connected and merged, what that
/// contributes, and the weights that the device's recurrences give, each against its definition. `subject`'s
/// plan is that of the recorder.
std::vector<Tally> check_connections(const Subject& subject, uint32_t sample,
                                     const render::ConnectionRecording& recording);

/// Name of the line of check_connections() that judges weights.
inline constexpr const char* WEIGHTS = "weights (absolute)";

/// Whole camera paths, vertex by vertex, and what each carries to the film, weights included.
std::vector<Tally> check_paths(const Subject& subject, const render::Recording& recording);

/// The image of one iteration by a set of techniques, pixel by pixel: connections, merges and splats with
/// their weights.
Tally check_image(gpu::Device& device, const Subject& subject, const char* name, uint32_t techniques);

/// Undecided: the most samples that were tried neither confirm nor withdraw a difference.
enum class Agreement { Agree, Undecided, Differ };

/// What a statistical test of images found.
struct ImageTest {
  std::string line;
  Agreement agreement;
};

/// Student's t over `batches` >= 2 independent seeds of the device's image and of as many others: of the
/// reference, or of the device with other techniques that must find the same light. Of pixels, tiles and the
/// whole image, each channel; the false-alarm rate of all together is 1e-4. Alarms are settled on fresh seeds
/// with more samples. A systematic difference of the relative size `tolerance` is not counted. See
/// image::test_equal and image::settle.
std::vector<ImageTest> check_statistics(gpu::Device& device, const Subject& subject, uint32_t batches,
                                        std::optional<uint32_t> other_techniques, double tolerance);

/// With fewer batches a pixel raises no alarm in check_statistics() unless it differs by more than a hundred
/// standard errors, which is to say never.
uint32_t fewest_batches(const render::Plan& plan);

/// One camera path in full from both backends: vertices, bsdfs, pdfs, and every path that ends on it with the
/// weights of all techniques. `recording` holds the path in slot 0.
std::string describe_path(const Subject& subject, uint32_t pixel, uint32_t sample,
                          const render::Recording& recording);

}  // namespace regulus::check
