// One wave of the wavefront, stage by stage with downloads in between: the queues before and after every
// stage, for `regulus check`. The kernels, buffers and the order are the renderer's own.
#pragma once

#include <memory>
#include <vector>

#include "bvh/bvh.hpp"
#include "gpu/gpu.hpp"
#include "render/settings.hpp"
#include "render/stages.hpp"
#include "scene/scene.hpp"

namespace regulus::render {

/// A bounce of a wave. Arrays are by path slot unless they say otherwise.
struct RecordedBounce {
  std::vector<uint32_t> slots;                             ///< list: traced in this bounce
  std::vector<interface::Path> before;                     ///< as traced
  std::vector<interface::Hit> hits;                        ///< triangle INVALID_INDEX: missed
  std::vector<interface::Path> after;                      ///< as the bounce stages left them
  std::vector<uint32_t> continuing;                        ///< list: traced in the next bounce
  std::vector<interface::VisibilityCandidate> candidates;  ///< list: light samples
  std::vector<glm::vec3> radiance_before_visibility;
  std::vector<glm::vec3> radiance;  ///< after trace_visibility
};

/// A wave: camera paths or light paths.
struct Recording {
  std::vector<interface::Path> generated;  ///< by slot; slot s holds path first_path + s
  std::vector<RecordedBounce> bounces;
};

/// Records waves with the techniques hit, nee and splat: all stages that walk, of both kinds of paths.
class StageRecorder {
 public:
  /// Scene and bvh as for Renderer. Of the settings' techniques only those named above are kept.
  StageRecorder(gpu::Device& device, const scene::Scene& scene, const bvh::Bvh& bvh,
                const RenderSettings& settings, uint32_t paths);
  ~StageRecorder();

  /// What the kernels were built for: the settings given, with effective techniques.
  const RenderSettings& settings() const;

  /// Runs `paths` paths (of the constructor) from path `first_path` of a sample on. Pass::Camera or
  /// Pass::Light.
  Recording record(Pass pass, uint32_t first_path, uint32_t sample);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace regulus::render
