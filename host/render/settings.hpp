// What a render is asked to do. Everything here changes the image or the cost of it, and is recorded in the
// image's metadata.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "interface/wavefront.h"

namespace regulus::render {

/// Density to which regularization bounds a lobe where none is given, 1/sr.
inline constexpr float DEFAULT_TAU = 5;

/// Techniques that need light subpaths.
inline constexpr uint32_t LIGHT_SUBPATH_TECHNIQUES =
    interface::TECHNIQUE_SPLAT | interface::TECHNIQUE_CONNECT | interface::TECHNIQUE_MERGE;
/// Techniques that ask whether two points see each other.
inline constexpr uint32_t SHADOW_RAY_TECHNIQUES =
    interface::TECHNIQUE_NEE | interface::TECHNIQUE_SPLAT | interface::TECHNIQUE_CONNECT;
inline constexpr uint32_t ALL_TECHNIQUES =
    interface::TECHNIQUE_HIT | interface::TECHNIQUE_NEE | LIGHT_SUBPATH_TECHNIQUES;

/// A rectangle of pixels.
struct Window {
  uint32_t x = 0, y = 0, width = 0, height = 0;
  uint64_t pixels() const { return uint64_t{width} * height; }
  bool operator==(const Window&) const = default;
};

/// Extra channels of an image (docs/user-guide/rendering.md). Bits of RenderSettings::aovs.
inline constexpr uint32_t AOV_ALBEDO = 1, AOV_SHADING_NORMAL = 2, AOV_GEOMETRIC_NORMAL = 4, AOV_POSITION = 8,
                          AOV_DEPTH = 16, AOV_MATERIAL = 32, AOV_INSTANCE = 64, AOV_VARIANCE = 128,
                          AOV_SAMPLES = 256, AOV_SIGMA = 512;
/// Light of one kind (interface::LIGHT_*) and of each group of lights (scene/light_groups.hpp).
inline constexpr uint32_t AOV_EMISSION = 1u << 10, AOV_DIRECT = 1u << 11, AOV_CAUSTICS = 1u << 12,
                          AOV_INDIRECT = 1u << 13, AOV_LIGHTS = 1u << 14;
inline constexpr uint32_t LIGHT_AOVS = AOV_EMISSION | AOV_DIRECT | AOV_CAUSTICS | AOV_INDIRECT | AOV_LIGHTS;
/// Cryptomattes (render/cryptomatte.hpp).
inline constexpr uint32_t AOV_CRYPTO_OBJECT = 1u << 15, AOV_CRYPTO_MATERIAL = 1u << 16;
inline constexpr uint32_t CRYPTO_AOVS = AOV_CRYPTO_OBJECT | AOV_CRYPTO_MATERIAL;
/// Those that say what camera rays meet first.
inline constexpr uint32_t SURFACE_AOVS = AOV_ALBEDO | AOV_SHADING_NORMAL | AOV_GEOMETRIC_NORMAL |
                                         AOV_POSITION | AOV_DEPTH | AOV_MATERIAL | AOV_INSTANCE | CRYPTO_AOVS;

/// Settings that are always done as asked: the same in RenderSettings and in the Plan made from them.
struct CommonSettings {
  uint32_t width = 0, height = 0;  ///< film, pixels
  Window crop{};                   ///< pixels that are rendered; without pixels: the whole film
  uint32_t camera = 0;             ///< index into Scene::cameras
  uint32_t first_sample = 0;       ///< sample range [first_sample, first_sample + samples) of every pixel
  uint32_t samples = 16;           ///< per pixel
  uint32_t max_depth = 12;         ///< path edges
  uint32_t seed = 0;
  uint32_t sampler = interface::SAMPLER_SOBOL;
  uint32_t cache_connections = 0;  ///< light vertices a camera vertex connects to, drawn from all of the
                                   ///< iteration's; 0: those of its own light path (paired)
  float merge_reduction =
      1.0f / 6;  ///< the radius of iteration i = 1, 2, ... is the first one's times i^-merge_reduction
  uint32_t sampler_quality = interface::SAMPLER_QUALITY_OFF;
  uint32_t bound = interface::BOUND_PEAK;
  uint32_t mis = interface::MIS_BLENDED;
  float tau = DEFAULT_TAU;  ///< largest density of a regularized lobe, 1/sr; infinite: nothing is regularized
  /// The most that one technique may add to one sample of a pixel, in any channel; infinite: no clamping.
  float largest_contribution = std::numeric_limits<float>::infinity();
  uint32_t ndf = interface::NDF_GGX;
  uint32_t shadowing = interface::SHADOWING_SMITH;
  uint32_t filter = interface::FILTER_BLACKMAN_HARRIS;
  float filter_radius = 1.5f;  ///< pixels; box: half the pixel is 0.5
  float filter_sigma = 0.5f;   ///< pixels, Gaussian
  uint32_t aovs = 0;           ///< AOV_* bits
  bool has_energy_compensation = false;
  bool has_strategy_images = false;  ///< keeps images of each strategy (render/strategies.hpp)
  bool keeps_doublings = false;  ///< film() is brought up to date whenever the number of paths has doubled
  uint32_t wave_paths = 0;       ///< path slots per wave; 0: chosen for the device. Never changes the image
  uint32_t rays = interface::RAYS_SOFTWARE;  ///< RAYS_*: who traces them (render/rays_choice.hpp)

  /// The pixels that are rendered.
  Window window() const { return crop.pixels() != 0 ? crop : Window{0, 0, width, height}; }
};

/// What a render is asked to do. The Plan (render/plan.hpp) says what is done, and decides what is left open
/// here.
struct RenderSettings : CommonSettings {
  /// TECHNIQUE_* bits; none: those that suit the scene, see choose_techniques().
  std::optional<uint32_t> techniques = interface::TECHNIQUE_HIT | interface::TECHNIQUE_NEE;
  uint32_t light_sampling = interface::LIGHT_SAMPLING_AUTO;  ///< LIGHT_SAMPLING_*: nee's choice of a light
  uint32_t light_guide = interface::LIGHT_GUIDE_OFF;         ///< LIGHT_GUIDE_*: how light paths start
  uint32_t walk_guide = interface::LIGHT_GUIDE_OFF;          ///< LIGHT_GUIDE_*: how camera walks go on
  /// Shadow rays that would carry less than this, W/(m^2 sr), play roulette; 0: every one is traced; none: by
  /// how bright what the camera sees typically is.
  std::optional<float> shadow_roulette = 0.0f;
  std::optional<uint32_t> light_paths;  ///< per iteration (one sample of every pixel); none: one per pixel
  std::optional<float> merge_radius;    ///< metres, of the first iteration; none: by what the camera sees
  std::optional<float> merge_radius_share;  ///< instead of metres: a share of the extent that the camera sees
  bool keeps_merge_radius = false;          ///< a given radius is not fitted to what the camera sees
  /// REGULARIZATION_* bits; none: left to the plan.
  std::optional<uint32_t> regularization = interface::REGULARIZATION_NONE;
  uint32_t regularization_modes = 0;  ///< REGULARIZATION_CONSISTENT, _DIFFUSION: beside the kind
};

}  // namespace regulus::render
