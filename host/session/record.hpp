// The record of a render: JSON for --stats, `regulus:` attributes for the image.
#pragma once

#include <nlohmann/json.hpp>

#include "gpu/gpu.hpp"
#include "image/image.hpp"
#include "render/renderer.hpp"
#include "render/stages.hpp"
#include "scene/scene.hpp"

namespace regulus::session {

/// Wall seconds of the phases before rendering.
struct LoadTimes {
  double load_seconds = 0, bvh_seconds = 0, pipeline_seconds = 0;
};

/// samples_done is per pixel, complete ones.
nlohmann::json render_statistics(const gpu::Device& device, const PreparedScene& prepared,
                                 const render::Plan& plan, const render::Renderer& renderer,
                                 const LoadTimes& times);

/// What an image's header says of any backend's render: the settings and the scene.
image::Attributes scene_attributes(const scene::Scene& scene, const render::Plan& plan);

/// And what it says of a device's.
image::Attributes image_attributes(const gpu::Device& device, const scene::Scene& scene,
                                   const render::Plan& plan, const render::Renderer& renderer);

}  // namespace regulus::session
