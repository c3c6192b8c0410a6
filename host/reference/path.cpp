#include "reference/path.hpp"

#include <algorithm>
#include <cmath>

#include "reference/light_guide.hpp"
#include "reference/sampling.hpp"

namespace regulus::reference {

using glm::dvec3;

namespace {

/// |w . n_s| / |w . n_g|; 0 for directions along the surface, from where no light arrives.
double normal_correction(const Surface& surface, const dvec3& w) {
  const double arrives = dot(w, surface.geometric_normal);
  return arrives == 0 ? 0 : std::abs(dot(w, surface.shading_normal) / arrives);
}

/// (n_camera / n_light)^2 of a refraction: n is the index on the side of each direction.
double squared_index_ratio(const Bsdf& bsdf, const Surface& surface, const dvec3& w_camera) {
  const double eta = bsdf.relative_index(to_material(surface, as_seen(surface, w_camera)));
  return 1 / (eta * eta);
}

/// Regularized scattering between two directions, the first of which the bsdf sees as `seen_light`.
std::optional<ConnectedScattering> raised_between(const Surface& surface, const Bsdf& bsdf,
                                                  const dvec3& w_light, const dvec3& seen_light,
                                                  const dvec3& w_camera, const BsdfSample* delta,
                                                  const Regularization& regularization) {
  if (!regularization.is_on) return std::nullopt;
  const std::optional<RaisedScattering> raised =
      raise(bsdf, to_material(surface, as_seen(surface, w_camera)), to_material(surface, seen_light), delta,
            regularization);
  if (!raised) return std::nullopt;
  return ConnectedScattering{raised->value * normal_correction(surface, w_light), raised->pdf_wo,
                             raised->pdf_wi, true, raised->ratio};
}

/// The same with the values of virtual merges, where facets are raised.
void measure_virtually(const Surface& surface, const Bsdf& bsdf, const dvec3& w_light,
                       const dvec3& seen_light, const dvec3& w_camera, const Regularization& regularization,
                       const VirtualTries& tries, ConnectedScattering& raised) {
  const dvec3 wo = to_material(surface, as_seen(surface, w_camera));
  const dvec3 wi = to_material(surface, seen_light);
  const SamplingFrame frame(surface, tries.is_from_light ? w_light : w_camera);
  const Bsdf local = frame.bsdf_of(surface, bsdf);
  const dvec3 local_light = frame.to_local(seen_light);
  const dvec3 local_camera = frame.to_local(as_seen(surface, w_camera));
  for (const bool is_coat : {false, true}) {
    if (!raises_facets(bsdf, wo, wi, is_coat, regularization)) continue;
    const std::vector<dvec3>& numbers = is_coat ? tries.of_coat : tries.of_base;
    const dvec3 facets = tries.is_from_light
                             ? virtual_merge(local, local_light, local_camera, is_coat,
                                             TransportMode::Importance, regularization, numbers)
                             : virtual_merge(local, local_camera, local_light, is_coat,
                                             TransportMode::Radiance, regularization, numbers);
    const Bsdf alone = raised_alone(bsdf, wo, wi, is_coat, regularization);
    const Bsdf smooth = alone.with_alpha(glm::dvec2(0)).with_coat_alpha(glm::dvec2(0));
    const dvec3 replaced =
        alone.value(wo, wi, TransportMode::Radiance) - smooth.value(wo, wi, TransportMode::Radiance);
    raised.value =
        glm::max(raised.value + (facets - replaced) * normal_correction(surface, w_light), dvec3(0));
  }
}

}  // namespace

SamplingFrame::SamplingFrame(const Surface& surface, const dvec3& w_back)
    : is_back_(dot(w_back, surface.geometric_normal) < 0),
      basis_(material_basis(surface, is_back_ ? -surface.shading_normal : surface.shading_normal)) {}

dvec3 SamplingFrame::to_local(const dvec3& w) const {
  const dvec3 local = basis_.to_local(w);
  return is_back_ ? dvec3(local.x, local.y, -local.z) : local;
}

dvec3 SamplingFrame::to_world(const dvec3& w) const {
  return basis_.to_world(is_back_ ? dvec3(w.x, w.y, -w.z) : w);
}

Bsdf SamplingFrame::bsdf_of(const Surface& surface, const Bsdf& bsdf) const {
  return bsdf.parameters().coat_normal ? bsdf.with_coat_normal(to_local(surface.coat_normal)) : bsdf;
}

double camera_bound(const Camera& camera, double longest_edge) {
  const double film = camera.pixel_area() * camera.width() * camera.height();
  return (camera.is_orthographic() ? longest_edge * longest_edge : 1.0) / film;
}

double geometry_term(const Path& path, size_t i) {
  const Edge& edge = path.edges[i];
  if (i == 0 && is_distant(path.light.kind)) return edge.cos_camera_end;
  return edge.cos_light_end * edge.cos_camera_end / (edge.distance * edge.distance);
}

double pdf_from_light(const Path& path, size_t i) {
  if (path.vertices[i].is_beyond) return 0;
  const Edge& edge = path.edges[i - 1];
  const RayDensity density = i == 1 ? path.light.density : RayDensity{path.vertices[i - 1].forward};
  return density.on_surface(edge.cos_camera_end, edge.distance);
}

double pdf_from_camera(const Path& path, size_t i) {
  const Edge& edge = path.edges[i];
  const RayDensity density = i + 1 == path.length() ? path.camera : RayDensity{path.vertices[i + 1].reverse};
  if (i == 0 && is_distant(path.light.kind)) return density.value;
  return density.on_surface(edge.cos_light_end, edge.distance);
}

ConnectedScattering connected_at(const Path& path, size_t i) {
  const VertexScattering& vertex = path.vertices[i];
  bool is_diffused = false;
  for (size_t j = i + 1; j < path.length(); ++j) is_diffused = is_diffused || path.vertices[j].diffuses;
  const bool has_extent = can_be_hit(path.light.kind);
  const bool is_raised = is_diffused || (vertex.is_always_raised && (has_extent || !vertex.has_bundle));
  if (is_raised && vertex.raised) return *vertex.raised;
  return {vertex.is_delta ? dvec3(0) : vertex.value, vertex.forward, vertex.reverse, !vertex.is_delta,
          vertex.is_delta ? 0.0 : 1.0};
}

WideColor measured_function(const Path& path, size_t first, size_t last) {
  const size_t end = path.length() - 1;
  WideColor f(path.light.emitted);
  for (size_t i = 0; i < end; ++i) {
    const bool is_connected = first <= i + 1 && i + 1 <= last;
    f *= static_cast<Wide>(geometry_term(path, i));
    f *= WideColor(is_connected ? connected_at(path, i + 1).value : path.vertices[i + 1].value);
  }
  for (const Edge& edge : path.edges) f *= WideColor(edge.transmittance);
  const auto is_dispersive = [](const VertexScattering& vertex) { return vertex.is_dispersive; };
  if (std::ranges::any_of(path.vertices, is_dispersive)) f *= WideColor(path.response);
  return f * static_cast<Wide>(pdf_from_camera(path, end));
}

Basis material_basis(const Surface& surface, const dvec3& normal) {
  return surface.tangent == dvec3(0) ? Basis(normal) : Basis(surface.tangent, normal);
}

dvec3 to_material(const Surface& surface, const dvec3& w) {
  return material_basis(surface, surface.shading_normal).to_local(w);
}

GuideCell cell_towards(const Surface& surface, const dvec3& w_camera) {
  if (surface.walk_guide == nullptr) return {};
  const bool is_back = dot(w_camera, surface.geometric_normal) < 0;
  return guide_cell(*surface.walk_guide, surface.position,
                    is_back ? -surface.geometric_normal : surface.geometric_normal);
}

bool sides_agree(const Surface& surface, const dvec3& w) {
  return dot(w, surface.geometric_normal) * dot(w, surface.shading_normal) > 0;
}

dvec3 as_seen(const Surface& surface, const dvec3& w) {
  if (sides_agree(surface, w)) return w;
  const dvec3 line = cross(surface.shading_normal, surface.geometric_normal);
  const double squared = dot(line, line);
  return squared > 0 ? 2 * dot(w, line) / squared * line - w : -w;
}

bool is_beyond_horizon(const Surface& surface, const dvec3& w_light, const dvec3& w_camera) {
  const double side = surface.bulge;
  return side * dot(w_camera, surface.geometric_normal) > 0 &&
         side * dot(w_light, surface.geometric_normal) < 0 && side * dot(w_light, surface.shading_normal) > 0;
}

Lit lit_from(const Surface& surface, const dvec3& w_light, const dvec3& w_camera) {
  if (sides_agree(surface, w_light)) return {.w = w_light};
  if (is_beyond_horizon(surface, w_light, w_camera)) return {.is_beyond = true, .w = w_light};
  if (surface.bulge * dot(w_camera, surface.geometric_normal) > 0) return {.is_dark = true};
  return {.is_turned = true, .is_in_relief_shadow = surface.has_relief, .w = as_seen(surface, w_light)};
}

uint32_t kind_of_light(const Path& path) {
  const size_t last = path.length() - 1;  // next to the lens; 0: the light itself
  size_t diffusing = 0;
  for (size_t i = 1; i <= last; ++i) diffusing += path.vertices[i].diffuses ? 1 : 0;
  if (diffusing == 0) return interface::LIGHT_EMISSION;
  if (diffusing > 1 || !path.vertices[last].diffuses) return interface::LIGHT_INDIRECT;
  return last == 1 ? interface::LIGHT_DIRECT : interface::LIGHT_CAUSTICS;
}

VertexScattering scattering_between(const Surface& surface, const Bsdf& material, const dvec3& w_light,
                                    const dvec3& w_camera, const Regularization& regularization,
                                    const VirtualTries& tries) {
  VertexScattering result;
  result.is_dispersive = material.parameters().is_dispersive;
  result.diffuses = diffuses(material);
  result.is_always_raised = !regularization.has_diffusion;
  result.has_bundle = regularization.has_bundle;
  const Lit lit = lit_from(surface, w_light, w_camera);
  if (lit.is_dark) return result;
  result.is_beyond = lit.is_beyond;
  const Bsdf bsdf = lit.is_in_relief_shadow ? material.in_relief_shadow() : material;
  const dvec3 local_light = to_material(surface, lit.w);
  const dvec3 local_camera = to_material(surface, as_seen(surface, w_camera));
  result.value =
      bsdf.value(local_camera, local_light, TransportMode::Radiance) * normal_correction(surface, w_light);
  result.forward = bsdf.pdf(local_light, local_camera);
  result.reverse = bsdf.pdf(local_camera, local_light);
  const GuideCell cell = cell_towards(surface, w_camera);
  if (cell.share > 0) {
    const Bsdf guided = bsdf.with_guide(cell.share, guided_pdf(*surface.walk_guide, cell, w_light));
    const double plain = result.reverse;
    result.reverse = guided.pdf(local_camera, local_light);
    if (plain > 0) result.guiding = result.reverse / plain;
    result.raised = raised_between(surface, guided, w_light, lit.w, w_camera, nullptr, regularization);
  } else {
    result.raised = raised_between(surface, bsdf, w_light, lit.w, w_camera, nullptr, regularization);
  }
  if (regularization.is_virtual && result.raised && !tries.of_base.empty())
    measure_virtually(surface, bsdf, w_light, lit.w, w_camera, regularization, tries, *result.raised);
  if (regularization.has_bounds)
    result.bound = estimator_bound(bsdf, local_camera, local_light, regularization);
  return result;
}

VertexScattering scattering_of_sample(const Surface& surface, const Bsdf& material, const dvec3& w_light,
                                      const dvec3& w_camera, const BsdfSample& sample,
                                      TransportMode transport, const Regularization& regularization) {
  if (!sample.is_delta) return scattering_between(surface, material, w_light, w_camera, regularization);
  const Lit lit = lit_from(surface, w_light, w_camera);
  const Bsdf bsdf = lit.is_in_relief_shadow ? material.in_relief_shadow() : material;
  const double cos_light = std::abs(dot(w_light, surface.shading_normal));
  const double cos_camera = std::abs(dot(w_camera, surface.shading_normal));
  const bool is_refracted = sample.is_transmitted && bsdf.parameters().is_volume;
  const double index_ratio = is_refracted ? squared_index_ratio(bsdf, surface, w_camera) : 1.0;
  const bool is_radiance = transport == TransportMode::Radiance;
  // value cos = factor of radiance, which is importance's times (n_camera / n_light)^2.
  const dvec3 factor = sample.weight * sample.pdf_forward * (is_radiance ? 1.0 : index_ratio);

  VertexScattering result;
  result.is_delta = true;
  result.is_dispersive = material.parameters().is_dispersive;
  result.is_beyond = lit.is_beyond;
  result.diffuses = diffuses(bsdf);
  result.is_always_raised = !regularization.has_diffusion;
  result.has_bundle = regularization.has_bundle;
  result.raised = raised_between(surface, bsdf, w_light, lit.w, w_camera, &sample, regularization);
  if (regularization.has_bounds)
    result.bound = estimator_bound(bsdf, to_material(surface, as_seen(surface, w_camera)),
                                   to_material(surface, lit.w), regularization);
  // A clearcoat with a normal of its own may see both directions at other cosines than the surface does.
  const double cos_sampled = is_radiance || is_refracted ? cos_light : cos_camera;
  result.value = factor / cos_sampled * normal_correction(surface, w_light);
  result.reverse = is_radiance ? sample.pdf_forward : sample.pdf_reverse;
  // delta(w_camera) = delta(w_light) d w_light / d w_camera, by Snell's law n_l^2 cos_l dw_l = n_c^2 cos_c
  // dw_c.
  const double bend = is_refracted ? index_ratio * cos_camera / cos_light : 1.0;
  result.forward = (is_radiance ? sample.pdf_reverse : sample.pdf_forward) * bend;
  return result;
}

LightEnd light_end(const World& world, const LightPoint& point, const dvec3& direction, const dvec3& at) {
  RayDensity density = emission_density(world, point, direction);
  if (world.light_guide())
    density.value *=
        guide_density(*world.light_guide(), point.light, start_numbers(world, point, direction, at));
  return {point.kind,
          emitted(world, point, direction),
          light_point_pdf(world, point),
          density,
          0,
          emission_bound(world, point),
          point.light};
}

}  // namespace regulus::reference
