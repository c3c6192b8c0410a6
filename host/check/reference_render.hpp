// `render --backend reference`: the same scene and settings by the scalar reference.
#pragma once

#include <functional>

#include "image/image.hpp"
#include "prepared/prepared_scene.hpp"
#include "reference/renderer.hpp"
#include "render/plan.hpp"

namespace regulus::check {

/// A render by the reference: the mean image and the iterations (samples of every pixel) in it.
struct ReferenceRender {
  image::Image image;
  image::Channels channels;  ///< --aov
  uint32_t samples = 0;
};

/// Renders on all processors until done or `progress` returns false; called with paths done and in all.
ReferenceRender render_with_reference(const PreparedScene& prepared, const render::Plan& plan,
                                      const std::function<bool(uint64_t done, uint64_t total)>& progress);

}  // namespace regulus::check
