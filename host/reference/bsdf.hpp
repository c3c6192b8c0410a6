// The surface scattering model in double precision: a metal and a dielectric with a diffuse base or
// transmission below a microfacet interface (glTF metallic-roughness with transmission, volume, ior and
// specular). One function per definition; nothing here is shared with the shaders.
//
// Frame: z = shading normal on the front side. wo (to the camera side of the walk) and wi (to the light side)
// are unit, point away from the surface and may lie on either side of it.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <optional>

#include "reference/energy.hpp"
#include "reference/fresnel.hpp"
#include "reference/iridescence.hpp"
#include "reference/microfacet.hpp"
#include "reference/sampling.hpp"
#include "reference/sheen.hpp"

namespace regulus::reference {

/// What flows along a walk that arrives at wo and continues to wi. Radiance (camera walks) changes by the
/// squared ratio of indices when it crosses an interface, importance's dual (light walks) does not.
enum class TransportMode { Radiance, Importance };

/// Values of a material at one point, after textures.
struct BsdfParameters {
  glm::dvec3 base_color = glm::dvec3(0.8);
  double metallic = 0;
  glm::dvec2 alpha = glm::dvec2(1);  ///< perceptual roughness squared; (0, 0): the specular lobes are deltas
  double ior = 1.5;                  ///< n(back side) / n(front side) of the interface
  double transmission = 0;
  double specular = 1;
  glm::dvec3 specular_color = glm::dvec3(1);
  double clearcoat = 0;                   ///< weight of a dielectric lobe on top (KHR_materials_clearcoat)
  glm::dvec2 coat_alpha = glm::dvec2(0);  ///< its roughness; (0, 0): a delta
  /// Its normal on the front side, where that is not z.
  std::optional<glm::dvec3> coat_normal = std::nullopt;
  glm::dvec3 sheen_color = glm::dvec3(0);  ///< KHR_materials_sheen
  double sheen_roughness = 1;              ///< perceptual
  const SheenTable* sheen = nullptr;       ///< null: there is none
  double film_strength = 0;                ///< share that a thin film covers (KHR_materials_iridescence)
  ThinFilm film;
  bool is_dispersive = false;  ///< `ior` depends on the wavelength
  bool is_volume = false;      ///< MATERIAL_VOLUME: transmission refracts; otherwise it is thin-walled
  uint32_t ndf = interface::NDF_GGX;
  uint32_t shadowing = interface::SHADOWING_SMITH;
  /// fresnel_dielectric_average(ior), for callers that know it: its quadrature takes longer than all the
  /// rest.
  std::optional<double> fresnel_average = std::nullopt;
  const EnergyTables* energy = nullptr;  ///< energy is compensated by these; null: not at all
  /// What rough interfaces leave to the diffuse base, by these; null: as much as smooth ones. Not with
  /// `energy`.
  const EnergyTables* cover = nullptr;
  double cover_error = 0;  ///< added to what its tables hold
  /// Raised lobes keep their light by these (reference/regularization.hpp); null: they lose some.
  const EnergyTables* raised_light = nullptr;
};

/// A sampled direction.
struct BsdfSample {
  bool is_valid = false;  ///< false: the walk ends here (weight 0)
  bool is_delta = false;
  bool is_transmitted = false;
  bool is_diffuse = false;           ///< drawn by the diffuse lobe
  bool is_refracted = false;         ///< transmitted and bent
  bool is_coat = false;              ///< drawn by the clearcoat's lobe
  glm::dvec2 alpha = glm::dvec2(0);  ///< of the microfacet lobe that it was drawn by
  glm::dvec3 wi = glm::dvec3(0);
  glm::dvec3 weight = glm::dvec3(0);  ///< value |cos_i| / pdf; of a delta event its factor / probability
  double pdf_forward = 0;             ///< of wi given wo; of a delta event its discrete probability
  double pdf_reverse = 0;             ///< of wo given wi, likewise
};

/// One material at one point.
class Bsdf {
 public:
  explicit Bsdf(const BsdfParameters& parameters);

  /// rho(wo, wi), 1/sr, without the cosine; delta lobes are left out.
  glm::dvec3 value(const glm::dvec3& wo, const glm::dvec3& wi, TransportMode mode) const;

  /// Solid-angle density with which sample() at wo returns wi, delta events left out (they are not
  /// renormalized). The reverse density is pdf(wi, wo).
  double pdf(const glm::dvec3& wo, const glm::dvec3& wi) const;

  /// Draws wi; all numbers uniform in [0, 1). `u_lobe` decides diffuse (below diffuse_probability()) against
  /// specular; rescaled, it decides what is discrete about the visible normal, and what then remains
  /// reflection (below its probability) against transmission. `u` gives the direction.
  BsdfSample sample(const glm::dvec3& wo, double u_lobe, const glm::dvec2& u, TransportMode mode) const;

  /// Draws wi by the base's microfacet lobe alone; `u_choice` is what sample() has left of `u_lobe` then. The
  /// weight is that lobe's value, the clearcoat above it included, times |cos_i| over its own density.
  BsdfSample sample_facets(const glm::dvec3& wo, double u_choice, const glm::dvec2& u,
                           TransportMode mode) const;

  /// The same by the clearcoat's lobe alone.
  BsdfSample sample_coat_facets(const glm::dvec3& wo, double u_choice, const glm::dvec2& u,
                                TransportMode mode) const;

  /// Probability of the diffuse lobe seen from wo.
  double diffuse_probability(const glm::dvec3& wo) const;

  /// Probability of reflection, not transmission, at a facet whose cosine is this on the side of index 1 /
  /// eta.
  double reflection_probability(double cos_facet, double eta) const;

  /// Relative index n(other side) / n(side of w) that a direction w sees.
  double relative_index(const glm::dvec3& w) const;

  /// True if the specular lobes are delta events.
  bool is_delta() const { return parameters_.alpha == glm::dvec2(0); }

  /// True if some lobe that w meets is not a delta: something that connections and merges can use.
  bool has_finite_lobe(const glm::dvec3& w) const {
    return !is_delta() || diffuse_albedo_ != glm::dvec3(0) || largest_sheen(w) > 0 ||
           (coat_towards(w) > 0 && !is_coat_delta());
  }

  /// True if the clearcoat's lobe is a delta event.
  bool is_coat_delta() const { return parameters_.coat_alpha == glm::dvec2(0); }

  /// Clearcoat on the side of w: solids are coated on their outside, the rest on both sides.
  double coat_towards(const glm::dvec3& w) const { return refracts() && w.z < 0 ? 0 : parameters_.clearcoat; }

  /// A direction where z is the clearcoat's normal on the back of the surface, or else on its front.
  glm::dvec3 to_coat(const glm::dvec3& w, bool is_back) const;

  /// Probability of the clearcoat's lobe seen from wo.
  double coat_probability(const glm::dvec3& wo) const;

  const BsdfParameters& parameters() const { return parameters_; }
  const Microsurface& microsurface() const { return surface_; }

  const Microsurface& coat_microsurface() const { return coat_; }

  /// The same material with another alpha; (0, 0): its value() and pdf() are those without the microfacet
  /// lobe.
  Bsdf with_alpha(const glm::dvec2& alpha) const;

  /// The same with another alpha of the clearcoat's lobe; (0, 0): value() and pdf() are without it.
  Bsdf with_coat_alpha(const glm::dvec2& alpha) const;

  /// The same with the values of the base's and of the clearcoat's microfacet lobe scaled; pdfs are not.
  Bsdf with_scaled_lobes(double base, double coat) const;

  /// Number of its index of refraction among the tables of its parameters.
  uint32_t energy_index() const { return energy_index_; }

  /// The same with another normal of the clearcoat.
  Bsdf with_coat_normal(const glm::dvec3& normal) const;

  /// The same where a relief shadows it: the diffuse lobe is dark, the choice between lobes stays.
  Bsdf in_relief_shadow() const;

  /// The same where, for one pair of directions, a guide with this density (1/sr) draws a share of the
  /// diffuse lobe's samples: pdf() is that of the direction towards the light.
  Bsdf with_guide(double share, double density) const;

  /// The same without it.
  Bsdf without_guide() const { return with_guide(0, 0); }

  /// The same with a density of facets of 1 in value() and pdf(), see Microsurface::has_unit_density.
  Bsdf with_unit_density() const;

 private:
  glm::dvec3 reflectance(double cos_facet, double eta) const;  // F_r
  /// F_r with the film, by that without it. thin_cosine: on the thin side of the interface.
  glm::dvec3 film_over(const glm::dvec3& plain, double thin_cosine, const glm::dvec3& metal_gain,
                       double dielectric_gain) const;
  /// Luminances by which a walk chooses where there is a film: what is reflected, and of the rest what a base
  /// of this colour gets. The film counts with its mean over thicknesses: at normal incidence, and by the
  /// Fresnel position from there to all.
  double chosen_reflection(double cosine, double position) const;
  double chosen_base(const glm::dvec3& color, double position) const;
  /// What energy compensation multiplies a rough lobe with, for the side and cosine of the camera's direction
  /// (its z in the material's frame): dielectric reflection and all transmission by one factor, metal by
  /// another.
  double dielectric_gain(double camera_z) const;
  glm::dvec3 metal_gain(double camera_z) const;
  glm::dvec3 compensated_reflectance(double cos_facet, double eta, double camera_z) const;
  /// Of the interface, for the diffuse lobe: at one direction, and its mean over all of that side.
  glm::dvec2 cover(double cosine, double eta) const;
  glm::dvec3 diffuse_transmittance(double cosine, double eta) const;
  /// Share of the diffuse lobe's samples that are drawn from the cone in which light leaves a solid.
  double cone_share(double eta) const;
  /// Of the diffuse lobe's samples, per solid angle. `sheen`: its share of them.
  double diffuse_pdf(double cosine, double eta, double sheen) const;
  glm::dvec3 sample_diffuse(const glm::dvec2& u, double eta, double sheen) const;
  /// Largest component of the sheen's colour on the side of w: solids have it on their outside, the rest on
  /// both.
  double largest_sheen(const glm::dvec3& w) const;
  /// Share of light from w that white sheen reflects, at most 1; 0 without any.
  double sheen_albedo(const glm::dvec3& w) const;
  /// Factor on what lies below the sheen.
  double sheen_passage(const glm::dvec3& wo, const glm::dvec3& wi) const;
  glm::dvec3 sheen_value(const glm::dvec3& wo, const glm::dvec3& wi) const;
  double sheen_share(const glm::dvec3& w) const;
  glm::dvec3 interface_value(const glm::dvec3& wo, const glm::dvec3& wi, TransportMode mode) const;
  glm::dvec3 mean_transmittance(bool is_back) const;
  /// F_d as the diffuse base and the choice of lobes see it: of a rough interface by its own albedo, where
  /// what it loses between facets counts as reflected at normal incidence.
  glm::dvec3 base_reflectance(double cosine, double eta) const;
  /// Luminance of what diffuse lobe and facets would reflect or transmit of light from w.
  struct Shares {
    double diffuse, facets;
  };
  Shares shares(const glm::dvec3& w) const;
  /// Likewise of sheen, and of both below it.
  struct Layers {
    double sheen, diffuse, facets;
  };
  Layers layers(const glm::dvec3& w) const;
  /// (1 - m) t base (1 - F_d). `exact`: reflectance of the bare interface at `thin_cosine`
  glm::dvec3 transmittance(double exact, double thin_cosine, double eta) const;
  double reflection_probability(double cos_facet, double exact, double eta) const;
  double coat_reflectance(const glm::dvec3& w) const;  // on the side of w, at its cosine
  /// Of the coat's lobe alone, deltas left out; the density that of its own samples.
  double coat_value(const glm::dvec3& wo, const glm::dvec3& wi, TransportMode mode) const;
  double coat_pdf(const glm::dvec3& wo, const glm::dvec3& wi) const;
  glm::dvec3 from_coat(const glm::dvec3& w, bool is_back) const;
  Basis coat_basis(bool is_back) const;
  glm::dvec3 base_value(const glm::dvec3& wo, const glm::dvec3& wi, TransportMode mode) const;
  double base_pdf(const glm::dvec3& wo, const glm::dvec3& wi) const;
  BsdfSample sample_base(const glm::dvec3& wo, double u_lobe, const glm::dvec2& u, TransportMode mode) const;
  BsdfSample sample_coat(const glm::dvec3& wo, double u_choice, const glm::dvec2& u) const;
  BsdfSample coated_delta(const glm::dvec3& wo, BsdfSample sample, TransportMode mode) const;
  glm::dvec3 diffuse_value(const glm::dvec3& wo, const glm::dvec3& wi, double eta) const;
  glm::dvec3 mirror_lobe_value(const glm::dvec3& wo, const glm::dvec3& wi) const;
  glm::dvec3 refraction_value(const glm::dvec3& wo, const glm::dvec3& wi, double eta,
                              TransportMode mode) const;
  double refraction_pdf(const glm::dvec3& wo, const glm::dvec3& wi, double eta) const;
  BsdfSample sample_delta(const glm::dvec3& wo, double eta, double p_diffuse, bool reflects,
                          TransportMode mode) const;
  bool refracts() const { return parameters_.is_volume && parameters_.transmission > 0; }

  BsdfParameters parameters_;
  Microsurface surface_;
  Microsurface coat_;
  SpecularDielectric dielectric_;
  uint32_t energy_index_ = 0;  // of the tables for this index of refraction
  bool is_in_relief_shadow_ = false;
  double guide_share_ = 0, guide_density_ = 0;
  double base_scale_ = 1, coat_scale_ = 1;  // of the microfacet lobes' values
  glm::dvec2 own_alpha_ = glm::dvec2(0);    // of the material itself, also where a lobe is raised
  double energy_roughness_ = 0;             // likewise
  // Of parameters_.cover in the base's light, likewise, from outside and from inside.
  std::array<double, 2> cover_share_{};
  glm::dvec3 diffuse_albedo_;  // (1 - m) (1 - t) base
  // That over pi and mean_transmittance, at the front and at the back.
  std::array<glm::dvec3, 2> diffuse_scale_;
};

/// Luminance of a linear Rec. 709 colour.
double luminance(const glm::dvec3& color);

/// Half vector of a reflection: unit, between wi and wo.
glm::dvec3 reflection_half_vector(const glm::dvec3& wo, const glm::dvec3& wi);

/// Half vector of a refraction with index `eta` = n(wi side) / n(wo side): unit, z > 0; zero for eta = 1 and
/// opposite directions. Walter 2007, eq. 16.
glm::dvec3 refraction_half_vector(const glm::dvec3& wo, const glm::dvec3& wi, double eta);

/// Mirror direction of wo at h.
glm::dvec3 reflect_at(const glm::dvec3& wo, const glm::dvec3& h);

/// Refracted direction of wo at h (wo.h > 0), or the zero vector under total internal reflection.
/// Walter 2007, eq. 40.
glm::dvec3 refract_at(const glm::dvec3& wo, const glm::dvec3& h, double eta);

}  // namespace regulus::reference
