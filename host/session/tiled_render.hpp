// Pictures whose film is larger than a buffer of the device: rendered one band of rows after the other. A
// band has the bits that its pixels have in the whole.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "gpu/gpu.hpp"
#include "render/renderer.hpp"

namespace regulus::session {

/// The bands of rows in which a device can render the pixels that are asked for, the whole window if it fits:
/// of `pixels_at_most` pixels if that is not 0.
std::vector<render::Window> film_bands(const gpu::Device& device, const render::Plan& plan,
                                       uint64_t pixels_at_most);

struct TiledRender {
  image::Image image;
  image::Channels channels;  ///< as the plan's AOVs ask for
  uint64_t paths = 0;        ///< rendered; all if none was interrupted
  uint64_t non_finite = 0, overruns = 0;
  double render_seconds = 0;
  std::vector<std::string> warnings;  ///< of saturated sums
};

/// Renders band after band; those that are not reached when `progress` returns false stay black.
TiledRender render_in_bands(gpu::Device& device, const PreparedScene& prepared, const render::Plan& plan,
                            const std::vector<render::Window>& bands,
                            const render::ProgressCallback& progress);

}  // namespace regulus::session
