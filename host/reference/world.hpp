// The scene as the reference sees it: surfaces, materials and media at points, in double precision, from the
// same arrays that kernels read.
#pragma once

#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "prepared/prepared_scene.hpp"
#include "reference/bsdf.hpp"
#include "reference/media.hpp"
#include "reference/traversal.hpp"
#include "reference/wavelength.hpp"
#include "scene/light_guide.hpp"
#include "scene/placement.hpp"
#include "scene/scene.hpp"
#include "scene/texture.hpp"
#include "scene/walk_guide.hpp"

namespace regulus::reference {

/// A point of a triangle with what the vertices carry. Normals are unit and point to the front side.
struct Surface {
  glm::dvec3 position{0};
  glm::dvec3 geometric_normal{0};
  glm::dvec3 shading_normal{0};  ///< in the hemisphere of geometric_normal
  glm::dvec3 coat_normal{0};     ///< of the clearcoat likewise, where it is not shading_normal; else 0
  scene::TextureCoordinates uv;
  glm::dvec4 color{1};  ///< vertex colour
  /// Direction in which the roughness of an anisotropic material is stretched: unit, orthogonal to
  /// shading_normal. Zero if the material is isotropic.
  glm::dvec3 tangent{0};
  double anisotropy = 0;     ///< strength
  double cover_error = 0;    ///< by which to move the tables of rough interfaces, as single precision may
  double fresnel_error = 0;  ///< the same for the mean reflectance of smooth ones
  double coverage = 1;       ///< share of the surface that is there
  double area = 0;           ///< of the triangle, m^2
  uint32_t triangle = interface::INVALID_INDEX;
  uint32_t material = interface::INVALID_INDEX;
  uint32_t light = interface::INVALID_INDEX;  ///< of the triangle, if it emits
  bool has_relief = false;                    ///< the shading normal is a normal map's
  /// The side on which the vertex normals spread: 1 the front, -1 the back, 0 neither.
  int bulge = 0;
  glm::dvec3 rise{0};  ///< way to the curved surface that they suggest on that side, m (Hanika 2021)
  const scene::WalkGuide* walk_guide = nullptr;  ///< by which camera walks look for light; null: by none
};

/// Where a ray starts: the solids around it and the surface that it leaves, if any.
struct Place {
  Media around;
  uint32_t triangle = interface::INVALID_INDEX;
  glm::dvec2 barycentrics{0};  ///< only where a walk was recorded
};

/// A scene with a microfacet model. The scene must outlive it.
class World {
 public:
  explicit World(const PreparedScene& prepared, uint32_t ndf = interface::NDF_GGX,
                 uint32_t shadowing = interface::SHADOWING_SMITH,
                 uint32_t light_sampling = interface::LIGHT_SAMPLING_AUTO, bool compensates_energy = false,
                 std::shared_ptr<const scene::LightGuide> light_guide = nullptr,
                 std::shared_ptr<const scene::WalkGuide> walk_guide = nullptr);

  const scene::Scene& scene() const { return scene_; }

  /// What rough interfaces of this scene reflect and refract.
  const EnergyTables& energy_tables() const { return energy_; }
  const Traversal& traversal() const { return traversal_; }

  /// How next-event estimation chooses a light: LIGHT_SAMPLING_*, resolved.
  uint32_t light_sampling() const { return light_sampling_; }

  /// How light paths start; null: by power.
  const scene::LightGuide* light_guide() const { return light_guide_.get(); }

  /// Centre and radius of the sphere around the scene's bounds: where directional light starts.
  const glm::dvec3& center() const { return center_; }
  double radius() const { return radius_; }

  /// The point of a triangle with these barycentrics (of its second and third vertex).
  Surface surface_at(uint32_t triangle, const glm::dvec2& barycentrics) const;

  /// Mean curvature of a triangle's interpolated normals: half their divergence over its plane, 1/m, positive
  /// where the front is convex; at most one over the longest edge. 0 without vertex normals.
  double mean_curvature(uint32_t triangle) const;

  /// The material at a surface point, textures applied. Where the scene has contacts, `around` (the solids on
  /// one of its sides) says what is in front of it.
  Bsdf bsdf_at(const Surface& surface, const Media& around = {}, const Wavelength& wavelength = {}) const;

  /// Radiance that the surface's material emits there, whatever the side.
  glm::dvec3 emission_at(const Surface& surface) const;

  /// True if the surface emits from its back as well as from its front.
  bool emits_from_both_sides(const Surface& surface) const;

  /// Transmittance of `distance` metres of a material's interior; INVALID_INDEX: vacuum. Beer and Lambert.
  glm::dvec3 transmittance(uint32_t medium, double distance) const;

  /// The medium on the side of the surface that w points to, for a path that arrived through `medium` from
  /// the side of `from`, where `around` is.
  /// `is_beyond`: w lies beyond the facet's horizon, but leaves to the side of `from`.
  uint32_t medium_towards(const Surface& surface, uint32_t medium, const Media& around,
                          const glm::dvec3& from, const glm::dvec3& w, bool is_beyond = false) const;

  /// Where a ray along w starts from a surface that was reached from the side of `from`, where `around` is.
  /// `is_beyond` as above: then it starts from no surface, because its own facet may be in the way.
  Place place_towards(const Surface& surface, const Media& around, const glm::dvec3& from,
                      const glm::dvec3& w, bool is_beyond = false) const;

  /// Whether the scene has FEATURE_CONTACTS. Otherwise places do not matter.
  bool has_contacts() const { return scene_.solids.has_contacts; }

  /// Whether some solid is dispersive. Otherwise wavelengths do not matter.
  bool has_dispersion() const { return has_dispersion_; }

  /// Material of the medium where several solids are; INVALID_INDEX: none.
  uint32_t medium_of(const Media& around) const;

  /// Medium at the middle of a camera's lens, which reaches to its near plane.
  uint32_t medium_of_lens(uint32_t camera) const {
    return has_contacts() ? scene::medium_of_lens(scene_, camera) : interface::INVALID_INDEX;
  }

  /// What holds a camera's ray, or a light's, that starts (to see) at `origin`.
  Media media_of_camera(uint32_t camera, const glm::dvec3& origin) const;
  Media media_of_light(uint32_t light, const glm::dvec3& origin) const;

  /// The solids that hold a point: those that a ray from there leaves without having entered them.
  Media media_at(const glm::dvec3& point) const;

  /// What the ray meets next, between its t_min and t_max; `place` is at t_min. Interfaces that are none are
  /// passed, and `place` is brought up to date.
  std::optional<Intersection> meet(const Ray& ray, Place& place) const;

  /// Ray from a surface point. `is_beyond`: from the curved surface that the facet stands for, in a direction
  /// beyond its horizon.
  Ray ray_from(const Surface& surface, const glm::dvec3& direction, bool is_beyond = false) const;

  /// True if nothing lies strictly between a surface point and another point (on triangle `target`, if any).
  bool is_visible(const Surface& from, const Place& place, const glm::dvec3& to,
                  uint32_t target = interface::INVALID_INDEX, bool is_beyond = false) const;

  /// The same towards what is infinitely far away.
  bool is_open(const Surface& from, const Place& place, const glm::dvec3& direction,
               bool is_beyond = false) const;

 private:
  /// Sets the index of refraction of the interface, with `in_front` (a material or INVALID_INDEX) before it.
  void set_index(const interface::Material& material, uint32_t in_front, const Wavelength& wavelength,
                 double smooth_average, BsdfParameters& p) const;
  /// Fills the members that concern bulges. `sign_of_normals`: -1 if the vertex normals point to the back.
  void set_bulge(Surface& surface, const scene::PlacedTriangle& placed, const glm::dvec3& b,
                 double sign_of_normals) const;
  uint32_t solid_of(uint32_t triangle) const;  // INVALID_INDEX: it bounds none
  bool bounds_closed_solid(uint32_t triangle) const;
  bool is_passed(const Media& around, uint32_t solid) const;
  Media media_of_set(uint32_t set, const glm::dvec3& origin) const;
  /// Front shading normal by a normal map; `normal` is the vertices' sum, that of the surface their
  /// direction.
  glm::dvec3 mapped_normal(const Surface& surface, const scene::PlacedTriangle& placed, const glm::dvec3& b,
                           const glm::dvec3& normal, uint32_t texture, double normal_scale) const;
  /// Fills the members that concern anisotropy, once the shading normal is known.
  void set_anisotropy(Surface& surface, const scene::PlacedTriangle& placed, const glm::dvec3& b) const;
  /// Tangent interpolated between the vertices, not normalized; w: sign of the bitangent.
  glm::dvec4 tangent_at(const scene::PlacedTriangle& placed, const glm::dvec3& b) const;
  glm::dvec4 texture_at(uint32_t index, const scene::TextureCoordinates& uv) const;

  const scene::Scene& scene_;
  Traversal traversal_;
  uint32_t ndf_, shadowing_, light_sampling_;
  std::shared_ptr<const scene::LightGuide> light_guide_;
  std::shared_ptr<const scene::WalkGuide> walk_guide_;
  glm::dvec3 center_;
  double radius_;
  bool has_smooth_normals_;
  std::vector<double> fresnel_average_;                         // by material
  std::map<std::pair<float, float>, double> relative_average_;  // by index behind and in front, with contacts
  bool compensates_energy_ = false, has_rough_bases_ = false, has_dispersion_ = false;
  std::unique_ptr<const SheenTable> sheen_;  // if some material has it
  EnergyTables energy_;
};

}  // namespace regulus::reference
