// A finished path and its measured function, straight from the path integral (Veach 1997, chapter 8; notation
// of Georgiev et al. 2012): x_0 on a light, x_K on the lens, K edges. All that techniques and weights need of
// it is here; nothing depends on how the path was found.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "reference/camera.hpp"
#include "reference/lights.hpp"
#include "reference/regularization.hpp"
#include "reference/sampling.hpp"
#include "reference/walk_guide.hpp"
#include "reference/world.hpp"

namespace regulus::reference {

/// Products over long paths leave the range of double.
using Wide = long double;
using WideColor = glm::vec<3, Wide>;

/// Scattering at a vertex as connections and merges see it.
struct ConnectedScattering {
  glm::dvec3 value{0};  ///< rho^, like VertexScattering::value
  double forward = 0;   ///< pdfs that weights use in place of VertexScattering's: times rho^W / rho
  double reverse = 0;
  bool is_possible = false;  ///< whether a connection or merge can find a path that scatters here like this
  double ratio = 1;          ///< rho^W / rho; 0 of a delta event
};

/// Scattering at an interior vertex, for directions w_light to x_{i-1} and w_camera to x_{i+1}.
/// A delta event carries the factors of its delta distribution with respect to the solid angle of w_light:
/// all techniques that can find the path share the distribution itself.
struct VertexScattering {
  glm::dvec3 value{0};  ///< rho, 1/sr, with |w_light . n_s| / |w_light . n_g| (Veach 1997, 5.3)
  double forward = 0;   ///< solid-angle pdf of w_camera for a walk that came from w_light
  double reverse = 0;   ///< solid-angle pdf of w_light for a walk that came from w_camera
  double guiding = 1;   ///< that over what it would be without a guide
  bool is_delta = false;
  bool diffuses = false;  ///< see diffuses(): vertices on the light's side of this one are regularized
  bool is_always_raised = false;  ///< without path diffusion, or by the camera path's own bundle
  bool has_bundle = false;        ///< by the bundle; lights without extent still need a vertex that diffuses
  double bound = 0;               ///< estimator_bound(), if wanted
  bool is_beyond = false;         ///< see is_beyond_horizon(): no light walk arrives here
  bool is_dispersive = false;     ///< the bsdf depends on the wavelength
  /// What a connection sees if the vertex is regularized and that makes a difference. Its pdfs are finite
  /// even for a delta event, because all techniques that can find the path share the delta.
  std::optional<ConnectedScattering> raised;
};

/// The edge x_i x_{i+1}. Cosines are absolute, with geometric normals; 1 at ends that are no surfaces.
struct Edge {
  double distance = 0;
  double cos_light_end = 1;   ///< at x_i
  double cos_camera_end = 1;  ///< at x_{i+1}
  glm::dvec3 transmittance{1};
};

/// x_0 as the path sees it.
struct LightEnd {
  uint32_t kind = interface::LIGHT_TRIANGLE;
  glm::dvec3 emitted{0};   ///< towards x_1, see reference::emitted()
  double point_pdf = 0;    ///< of choosing x_0, see light_point_pdf()
  RayDensity density;      ///< of a light walk's direction to x_1
  double connect_pdf = 0;  ///< of choosing x_0 from x_1, see connection_pdf(); 0 on a path of one edge
  double bound = 0;        ///< rho-bar: largest density of the emitted light per steradian
  uint32_t index = 0;      ///< of the light
};

/// The path.
struct Path {
  LightEnd light;
  std::vector<VertexScattering> vertices;  ///< vertices[i] of x_i; 1 .. K-1, the ends unused
  std::vector<Edge> edges;                 ///< edges[i] from x_i to x_{i+1}; K of them
  RayDensity camera;                       ///< of camera rays towards x_{K-1}, film density 1 / px^2
  double camera_bound = 0;                 ///< rho-bar of the camera, see camera_bound()
  glm::dvec3 response{1};                  ///< of its wavelength: a factor if some vertex is dispersive
  double longest_edge = 0;                 ///< m: for sampler quality no edge counts as longer than this

  size_t length() const { return edges.size(); }
};

/// G of an edge without the camera's: cos cos / d^2; for distant light, whose x_0 is a direction, cos at x_1.
double geometry_term(const Path& path, size_t edge);

/// P_i^->: density per area with which a light walk at x_{i-1} finds x_i; 1 <= i <= K-1.
double pdf_from_light(const Path& path, size_t i);

/// P_i^<-: density per area with which a camera walk at x_{i+1} finds x_i; 0 <= i <= K-1. Of distant light,
/// per steradian.
double pdf_from_camera(const Path& path, size_t i);

/// What a connection or merge sees at interior vertex x_i. The vertex is regularized if some vertex between
/// it and the camera diffuses: path diffusion with two levels (docs/mathematics.md 3.8 A).
ConnectedScattering connected_at(const Path& path, size_t i);

/// f of the path as a technique measures it that connects or merges at vertices first .. last (none if first
/// > last): emitted * product of G, rho (there: rho^) and transmittance * importance. The importance of one
/// square pixel times the last edge's G is pdf_from_camera(K - 1): a film point has density 1.
WideColor measured_function(const Path& path, size_t first = 1, size_t last = 0);

/// What kind of light the path is, LIGHT_*: by which of its vertices diffuse.
uint32_t kind_of_light(const Path& path);

/// rho-bar of a camera: one over the solid angle of its film. An orthographic one's is one over its area,
/// where its edge counts as long as the longest.
double camera_bound(const Camera& camera, double longest_edge);

/// Numbers of a virtual merge's tries, and the end at which its lobe is sampled.
struct VirtualTries {
  std::vector<glm::dvec3> of_base;  ///< by its microfacet lobe
  std::vector<glm::dvec3> of_coat;  ///< by the clearcoat's
  bool is_from_light = false;       ///< from w_light
};

/// Scattering at a surface between two unit directions that point away from it; non-delta lobes. `tries` only
/// where virtual merges are measured.
VertexScattering scattering_between(const Surface& surface, const Bsdf& bsdf, const glm::dvec3& w_light,
                                    const glm::dvec3& w_camera, const Regularization& regularization = {},
                                    const VirtualTries& tries = {});

/// Scattering of a walk's step: like scattering_between(), with the delta event if `sample` is one.
/// `transport` tells what came first: Radiance, w_camera; Importance, w_light.
VertexScattering scattering_of_sample(const Surface& surface, const Bsdf& bsdf, const glm::dvec3& w_light,
                                      const glm::dvec3& w_camera, const BsdfSample& sample,
                                      TransportMode transport, const Regularization& regularization = {});

/// x_0 for a path that goes on along `direction` (the way light travels), through `at`: for distant light any
/// point of the edge, for others x_0 itself will do.
LightEnd light_end(const World& world, const LightPoint& point, const glm::dvec3& direction,
                   const glm::dvec3& at);

/// Frame on one side of a surface (the front if `normal` is the shading normal, the back if it is its
/// negative) that device and reference share.
Basis material_basis(const Surface& surface, const glm::dvec3& normal);

/// Direction w in the frame of Bsdf: z along the shading normal of the front side.
glm::dvec3 to_material(const Surface& surface, const glm::dvec3& w);

/// A direction in the frame in which device and reference sample the bsdf at a surface that a walk from
/// `w_back` has met: of Bsdf, with x and y as chosen on that side.
struct SamplingFrame {
  SamplingFrame(const Surface& surface, const glm::dvec3& w_back);
  glm::dvec3 to_local(const glm::dvec3& w) const;
  glm::dvec3 to_world(const glm::dvec3& w) const;
  /// The surface's bsdf for directions in this frame.
  Bsdf bsdf_of(const Surface& surface, const Bsdf& bsdf) const;

 private:
  bool is_back_;
  Basis basis_;
};

/// How a guided camera walk that arrives from unit direction w_camera looks for light there.
GuideCell cell_towards(const Surface& surface, const glm::dvec3& w_camera);

/// True if both normals see w on the same side.
bool sides_agree(const Surface& surface, const glm::dvec3& w);

/// True if the surface bulges on the side of w_camera and w_light lies beyond the facet's horizon, but on the
/// same side of the shading normal: light that reaches the curved surface for which the facet stands.
bool is_beyond_horizon(const Surface& surface, const glm::dvec3& w_light, const glm::dvec3& w_camera);

/// How light from w_light counts at a surface seen from w_camera. The rule is that of
/// shaders/lib/shading.glsl.
struct Lit {
  bool is_dark = false;              ///< not at all
  bool is_beyond = false;            ///< see is_beyond_horizon()
  bool is_turned = false;            ///< half-turned
  bool is_in_relief_shadow = false;  ///< the diffuse lobe is dark
  glm::dvec3 w{0};                   ///< w_light as the bsdf sees it
};
Lit lit_from(const Surface& surface, const glm::dvec3& w_light, const glm::dvec3& w_camera);

/// The direction w as a surface's bsdf sees it: w itself, or, if the normals disagree about its side, w after
/// a half-turn about the line in which their planes meet. Its own inverse; keeps solid angles and absolute
/// cosines with both normals.
glm::dvec3 as_seen(const Surface& surface, const glm::dvec3& w);

}  // namespace regulus::reference
