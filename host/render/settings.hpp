// What a render is asked to do. Everything here changes the image or the cost of it, and is recorded in the
// image's metadata.
#pragma once

#include <cstdint>

#include "interface/wavefront.h"

namespace regulus::render {

struct RenderSettings {
  uint32_t width = 0, height = 0;  ///< film, pixels
  uint32_t camera = 0;             ///< index into Scene::cameras
  uint32_t first_sample = 0;       ///< sample range [first_sample, first_sample + samples) of every pixel
  uint32_t samples = 16;           ///< per pixel
  uint32_t max_depth = 12;         ///< path edges
  uint32_t seed = 0;
  uint32_t techniques = interface::TECHNIQUE_HIT | interface::TECHNIQUE_NEE;  ///< TECHNIQUE_* bits
  uint32_t ndf = interface::NDF_GGX;
  uint32_t shadowing = interface::SHADOWING_SMITH;
  uint32_t filter = interface::FILTER_GAUSSIAN;
  float filter_radius = 1.5f;  ///< pixels; box: half the pixel is 0.5
  float filter_sigma = 0.5f;   ///< pixels, Gaussian
  uint32_t wave_paths = 0;     ///< path slots per wave; 0: chosen for the device. Never changes the image
};

}  // namespace regulus::render
