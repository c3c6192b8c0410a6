// Random walks from the camera and from lights, vertex by vertex with the device's random numbers. They use
// the unregularized bsdfs only; how their vertices become paths is the business of subpaths.hpp.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <limits>
#include <optional>
#include <vector>

#include "reference/camera.hpp"
#include "reference/footprint.hpp"
#include "reference/lights.hpp"
#include "reference/path.hpp"
#include "reference/wavelength.hpp"
#include "reference/world.hpp"

namespace regulus::reference {

/// A rectangle of the film's pixels.
struct Window {
  uint32_t x = 0, y = 0, width = 0, height = 0;

  uint32_t pixels() const { return width * height; }
  /// Number on a film of `film_width` of the window's `index`-th pixel, row by row.
  uint32_t pixel_of(uint32_t index, uint32_t film_width) const {
    return (y + index / width) * film_width + x + index % width;
  }
};

/// What a render is asked to do. The fields are those of render::RenderSettings.
struct Settings {
  uint32_t width = 0, height = 0;
  Window crop;          ///< pixels that are rendered; without any: the whole film
  uint32_t camera = 0;  ///< index into Scene::cameras
  uint32_t first_sample = 0;
  uint32_t samples = 16;
  uint32_t max_depth = 12;  ///< path edges
  uint32_t seed = 0;
  uint32_t sampler = interface::SAMPLER_SOBOL;
  uint32_t techniques = interface::TECHNIQUE_HIT | interface::TECHNIQUE_NEE;
  uint32_t light_paths = 0;  ///< per iteration; 0: one per pixel
  double merge_radius = 0;   ///< metres, of the first iteration
  double merge_reduction = 1.0 / 6;
  uint32_t cache_connections = 0;  ///< light vertices drawn for every camera vertex; 0: its own light path's
  uint32_t expected_light_vertices = 0;  ///< connectible ones of iteration 0, for weights; 0: to be counted
  uint32_t regularization = interface::REGULARIZATION_NONE;  ///< REGULARIZATION_* bits
  uint32_t bound = interface::BOUND_PEAK;
  uint32_t mis = interface::MIS_BLENDED;
  double tau = 5;  ///< 1/sr; the command line's default
  uint32_t sampler_quality = interface::SAMPLER_QUALITY_OFF;
  uint32_t ndf = interface::NDF_GGX;
  uint32_t shadowing = interface::SHADOWING_SMITH;
  Filter filter;
  /// 0: exact. Otherwise every random number, ray and texture coordinate of a walk is moved by a unit or two
  /// in the last place of single precision, up or down as this pattern says: how far results move then tells
  /// how well conditioned they are.
  uint32_t rounding_pattern = 0;

  /// Layers of the film, see render::Layers: of each kind of light, of group 0, and the group of each light.
  uint32_t layers = 0;
  std::array<uint32_t, interface::LIGHT_KINDS> kind_layers{};
  uint32_t first_group_layer = interface::INVALID_INDEX;
  std::vector<uint32_t> group_of_light{};

  double largest_contribution = std::numeric_limits<double>::infinity();  ///< of one technique to a sample
  double shadow_roulette = 0;  ///< shadow rays that would carry less play roulette; 0: none does

  Window window() const { return crop.pixels() != 0 ? crop : Window{0, 0, width, height}; }
  uint32_t paths_per_iteration() const { return light_paths == 0 ? width * height : light_paths; }
};

/// Regularization in the iteration of a sample: with the consistent schedule alpha_tau shrinks by i^(-1/6) in
/// iteration i = 1, 2, ... (docs/mathematics.md 7).
Regularization regularization_of(const Settings& settings, uint32_t sample);

/// The same for a vertex where camera paths arrive with `footprint`. With light subpaths, whose vertices
/// cannot know it, or without path diffusion, the footprint does not matter.
Regularization regularization_at(const Settings& settings, uint32_t sample, const Footprint& footprint);

/// Block `block` of a stream's random numbers: a camera path's stream is its pixel, a light path's its index;
/// a light path's sample is the iteration.
glm::dvec4 random_block(const Settings& settings, uint32_t stream, uint32_t sample, uint32_t block);

/// A surface vertex of a walk.
struct WalkVertex {
  Surface surface;
  Bsdf bsdf;
  glm::dvec3 w_back;                           ///< unit, towards the vertex before
  Edge edge{};                                 ///< from the vertex before, oriented as in a path
  uint32_t medium = interface::INVALID_INDEX;  ///< through which the walk arrived
  Media around{};                              ///< the solids on that side
  double survival = 1;                         ///< probability that roulette let the walk come this far
  glm::dvec3 throughput{1};  ///< of the walk on arrival, roulette divided out; for roulette and for reading
  Regularization regularization{};  ///< the walk's, or in path tracing with path diffusion this vertex's
  VertexScattering scattering{};    ///< of the step to the next vertex; means nothing at the last one
  BsdfSample sample{};              ///< likewise
};

/// What a walk carries from vertex to vertex.
struct WalkState {
  glm::dvec3 position{0}, direction{0};
  glm::dvec3 throughput{1};
  double survival = 1;
  double eta_scale = 1;  ///< product of squared index ratios, which camera roulette undoes (PBR 4ed, 14.2);
                         ///< of what a guide does, too
  uint32_t medium = interface::INVALID_INDEX;
  Place place{};   ///< where the next ray starts; on arrival the solids there
  double cut = 0;  ///< m of the next edge that lie before the camera's near plane
  uint32_t cut_medium = interface::INVALID_INDEX;  ///< the medium there
  Wavelength wavelength{};                         ///< of the walk's iteration
};

/// The vertex where a walk in `state` arrives after `distance` metres: takes the medium's share of the
/// throughput. `is_from_camera` orients the edge; `cos_start` is the cosine at its start.
WalkVertex arrive(const World& world, const Surface& surface, double distance, WalkState& state,
                  double cos_start, bool is_from_camera);

/// Takes the share that the light of limited range at the walk's start sends to its first vertex. False if
/// that is nothing: the walk has no vertex then.
bool end_by_range(const World& world, const LightPoint& point, WalkVertex& vertex, WalkState& state);

/// Samples the next direction of a camera walk (of a light walk) at its vertex `bounce` + 1 with the block
/// `u`, and plays Russian roulette. False if the walk ends there.
bool scatter_from_camera(const World& world, WalkVertex& vertex, WalkState& state, uint32_t bounce,
                         const glm::dvec4& u, const Regularization& regularization = {});
bool scatter_from_light(const World& world, WalkVertex& vertex, WalkState& state, uint32_t bounce,
                        const glm::dvec4& u, const Regularization& regularization = {});

/// The last ray of a camera walk that left the scene.
struct Escape {
  glm::dvec3 direction;  ///< unit
  double cos_start;      ///< absolute, at the last vertex; 1 at the lens
  double survival;       ///< see WalkVertex
};

/// Which random numbers a walk draws.
struct Stream {
  uint32_t seed = 0;
  uint32_t index = 0;   ///< pixel or light path
  uint32_t sample = 0;  ///< or iteration
};

/// Numbers of a virtual merge's tries at `end` (VIRTUAL_MERGE_*) of a path with so many edges from the camera
/// and from the light path `light_path`, drawn by the walk of `stream`.
VirtualTries virtual_tries(const Stream& stream, uint32_t end, size_t camera_edges, size_t light_edges,
                           uint32_t light_path);

/// A walk from the lens: vertices[m - 1] is the vertex after m edges.
struct CameraSubpath {
  glm::dvec2 film{0};
  CameraRay ray{};
  RayDensity density;  ///< of the ray, see Path::camera
  std::vector<WalkVertex> vertices;
  std::optional<Escape> escape;
  Stream stream;
  double bound = 0;         ///< see Path::camera_bound
  double longest_edge = 0;  ///< see Path
  glm::dvec3 response{1};   ///< likewise
};

/// A walk from a light: vertices[m - 1] is x_m.
struct LightSubpath {
  LightPoint point;  ///< x_0
  EmissionRay ray{};
  LightEnd end;  ///< x_0 as seen by paths that start with this walk
  Regularization regularization;
  std::vector<WalkVertex> vertices;
  Stream stream;
  glm::dvec3 response{1};  ///< see Path
};

/// A surface point where another walk (the device's) arrived.
struct GivenHit {
  uint32_t triangle;
  glm::dvec2 barycentrics;
};

/// The camera path of a sample of a pixel, up to max_depth edges. `given`, if not null: where it meets
/// surfaces, one after the other. The walk then traces no rays, and ends where its next direction does not
/// lead to the next of these points. So a walk can be followed without its errors adding up.
CameraSubpath walk_from_camera(const World& world, const Camera& camera, const Settings& settings,
                               uint32_t pixel, uint32_t sample, const std::vector<GivenHit>* given = nullptr);

/// Light path `index` of an iteration, up to max_depth - 1 edges (the last edge of a path is never its own).
/// `given` as above. Precondition: the scene has lights.
LightSubpath walk_from_light(const World& world, const Settings& settings, uint32_t index, uint32_t iteration,
                             const std::vector<GivenHit>* given = nullptr);

}  // namespace regulus::reference
