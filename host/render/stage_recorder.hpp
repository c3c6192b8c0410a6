// Records one wave stage by stage, with downloads in between: the queues before and after every stage, for
// `regulus check`. Kernels, buffers and order are the renderer's own.
#pragma once

#include <memory>
#include <vector>

#include "gpu/gpu.hpp"
#include "prepared/prepared_scene.hpp"
#include "render/plan.hpp"
#include "render/stages.hpp"

namespace regulus::render {

/// A segment that trace_visibility was given in addition to the candidates.
struct Probe {
  interface::VisibilityCandidate segment;  ///< contribution 1
  bool is_open = false;
};

/// A bounce of a wave. Arrays are by path slot unless they say otherwise.
struct RecordedBounce {
  std::vector<uint32_t> slots;          ///< list: traced in this bounce
  std::vector<interface::Path> before;  ///< as traced
  std::vector<interface::PathMedia>
      media_before;  ///< likewise; these three are empty without FEATURE_CONTACTS
  std::vector<interface::PathMedia> media_on_arrival;
  std::vector<interface::PathMedia> candidate_media;       ///< list, as `candidates`
  std::vector<interface::Hit> hits;                        ///< triangle INVALID_INDEX: missed
  std::vector<interface::Path> after;                      ///< as the bounce stages left them
  std::vector<uint32_t> continuing;                        ///< list: traced in the next bounce
  std::vector<interface::VisibilityCandidate> candidates;  ///< list: light samples
  std::vector<glm::vec3> radiance_before_visibility;
  std::vector<glm::vec3> radiance;  ///< after trace_visibility
  /// List: segments along this bounce's rays that end PROBE_MARGIN of their length short of what was hit, and
  /// the same beyond it. Few candidates end so near an occluder that the end would matter.
  std::vector<Probe> probes;
};

/// A wave: camera paths or light paths.
struct Recording {
  std::vector<interface::Path> generated;  ///< by slot; slot s holds path first_path + s
  std::vector<RecordedBounce> bounces;
};

/// See RecordedBounce::probes.
inline constexpr float PROBE_MARGIN = 1e-3F;

/// The connections and merges of a bounce of a wave of camera paths. Lists unless they say otherwise.
struct RecordedConnections {
  std::vector<uint32_t> slots;       ///< traced in this bounce
  std::vector<interface::Hit> hits;  ///< by slot; triangle INVALID_INDEX: missed
  std::vector<glm::vec3> met;        ///< by slot: emitted light that the ray met, technique `hit`
  std::vector<interface::CameraVertex> camera_vertices;       ///< by slot; edges 0: none
  std::vector<interface::ConnectionPair> pairs;               ///< of all material classes
  std::vector<interface::VisibilityCandidate> light_samples;  ///< candidates of technique `nee`
  std::vector<interface::VisibilityCandidate> connections;    ///< and of `connect`
  std::vector<glm::dvec3> merged;                             ///< by pixel: what `merge` added
};

/// Which light vertices a camera vertex connects to: some drawn from those of all light paths, or all of its
/// own light path.
enum class Connections { Cache, Paired };

/// An iteration: a wave of light paths, the sorting of their vertices, and a wave of camera paths.
struct ConnectionRecording {
  Connections connections = Connections::Cache;
  float merge_radius = 0;          ///< m
  uint32_t expected_vertices = 0;  ///< light vertices of iteration 0, with which weights reckon
  std::vector<std::vector<interface::Hit>> light_hits;  ///< by bounce and light path, as above
  std::vector<interface::LightPathHead> heads;          ///< by light path
  std::vector<interface::LightVertex> light_vertices;   ///< in the order in which they were stored
  std::vector<interface::SplatCandidate> splats;        ///< of all bounces
  std::vector<interface::PathMedia> splat_media;        ///< likewise; empty without FEATURE_CONTACTS
  std::vector<glm::dvec3> splat_film;                   ///< by pixel: what trace_splats made of them
  std::vector<uint32_t> path_counts, path_ends;         ///< by light path, before and after the scan
  std::vector<uint32_t> cell_counts, cell_ends;         ///< by cell and one more, likewise
  std::vector<uint32_t> ranks;                          ///< by light vertex: its place in its cell
  std::vector<interface::GridEntry> entries;            ///< of the grid
  std::vector<RecordedConnections> bounces;
};

/// Techniques of the stages that walk, of both kinds of paths.
inline constexpr uint32_t WALK_TECHNIQUES =
    interface::TECHNIQUE_HIT | interface::TECHNIQUE_NEE | interface::TECHNIQUE_SPLAT;

/// The plan of a recording: those of `techniques` that the settings ask for, with a light path per pixel.
Plan plan_recording(const PreparedScene& prepared, RenderSettings settings,
                    uint32_t techniques = WALK_TECHNIQUES);

/// Records waves.
class StageRecorder {
 public:
  /// @param plan of plan_recording()
  StageRecorder(gpu::Device& device, const PreparedScene& prepared, const Plan& plan, uint32_t paths);
  ~StageRecorder();

  /// What the kernels were built for.
  const Plan& plan() const;

  /// Runs `paths` paths (of the constructor) from path `first_path` of a sample on. Pass::Camera or
  /// Pass::Light.
  Recording record(Pass pass, uint32_t first_path, uint32_t sample);

  /// Records the light paths of the iteration of a sample and what their vertices are sorted into. The camera
  /// paths will connect as `connections` says, by the same kernels. Preconditions: connections and merges are
  /// among the techniques, plan().cache_connections is not 0, and there are as many paths as pixels.
  ConnectionRecording record_light_vertices(uint32_t sample, Connections connections = Connections::Cache);

  /// Goes on with the camera paths of that iteration. Lists that are broken may crash the device's driver.
  void record_connections(uint32_t sample, ConnectionRecording& recording);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace regulus::render
