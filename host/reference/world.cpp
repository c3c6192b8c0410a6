#include "reference/world.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "reference/path.hpp"
#include "scene/interfaces.hpp"
#include "scene/placement.hpp"
#include "scene/texture.hpp"
#include "scene/wavelengths.hpp"

namespace regulus::reference {

using glm::dvec2;
using glm::dvec3;
using namespace interface;

namespace {

// Alpha below which a lobe that is not a delta is evaluated as if it had this one: part of the model.
constexpr double MIN_ALPHA = 1e-7;
// A segment begins this far off its surface, relative to the coordinates: enough to pass over a second
// triangle in the same place, too little for anything else to fit in between.
constexpr double SEGMENT_START = 1e-10;

// Least roughness across the direction of an anisotropic material: part of the model.
constexpr double MIN_ANISOTROPIC_ALPHA = 1e-3;
// Least cosine of a mapped normal with the geometric one: part of the model.
constexpr double MIN_MAPPED_COS = 0.01;

}  // namespace

World::World(const PreparedScene& prepared, uint32_t ndf, uint32_t shadowing, uint32_t light_sampling,
             bool compensates_energy, std::shared_ptr<const scene::LightGuide> light_guide,
             std::shared_ptr<const scene::WalkGuide> walk_guide)
    : scene_(prepared.scene),
      traversal_(prepared.bvh, &prepared.scene),
      ndf_(ndf),
      shadowing_(shadowing),
      light_sampling_(scene::resolve_light_sampling(light_sampling, scene_.lights.size())),
      light_guide_(std::move(light_guide)),
      walk_guide_(std::move(walk_guide)),
      center_(0.5f * (scene_.bounds_min + scene_.bounds_max)),
      radius_(0.5 * glm::length(dvec3(scene_.bounds_max) - dvec3(scene_.bounds_min))),
      has_smooth_normals_((prepared.features.bits & FEATURE_SMOOTH_NORMALS) != 0),
      energy_(scene::interface_indices(scene_.materials, has_contacts()), ndf, shadowing) {
  std::map<float, double> average;
  for (const Material& material : scene_.materials) {
    const auto [entry, is_new] = average.try_emplace(material.ior);
    if (is_new) entry->second = fresnel_dielectric_average(material.ior);
    fresnel_average_.push_back(entry->second);
  }
  if (has_contacts())
    for (const auto& [behind, unused] : average)
      for (const auto& [in_front, also_unused] : average)
        relative_average_[{behind, in_front}] = fresnel_dielectric_average(double{behind} / in_front);
  if ((prepared.features.bits & FEATURE_SHEEN) != 0)
    sheen_ = std::make_unique<const SheenTable>(prepared.sheen_table);
  compensates_energy_ = compensates_energy;
  has_dispersion_ = (prepared.features.bits & FEATURE_DISPERSION) != 0;
  has_rough_bases_ = (prepared.features.bits & FEATURE_ROUGH_BASE) != 0;
}

Surface World::surface_at(uint32_t index, const dvec2& barycentrics) const {
  const scene::PlacedTriangle placed = scene::placed_triangle(scene_, index);
  const Triangle& triangle = placed.triangle;
  const Vertex v0 = placed_vertex(scene_, placed, triangle.v0);
  const Vertex v1 = placed_vertex(scene_, placed, triangle.v1);
  const Vertex v2 = placed_vertex(scene_, placed, triangle.v2);
  const dvec3 b(1 - barycentrics.x - barycentrics.y, barycentrics.x, barycentrics.y);
  const dvec3 p0(v0.position);
  const dvec3 p1(v1.position);
  const dvec3 p2(v2.position);
  const dvec3 cross = glm::cross(p1 - p0, p2 - p0);

  Surface surface;
  surface.position = b.x * p0 + b.y * p1 + b.z * p2;
  surface.geometric_normal = normalize(cross);
  surface.shading_normal = surface.geometric_normal;
  surface.area = 0.5 * length(cross);
  surface.uv = scene::texture_coordinates(scene_, triangle, b);
  if (!scene_.vertex_colors.empty())
    surface.color = b.x * glm::dvec4(scene_.vertex_colors[triangle.v0]) +
                    b.y * glm::dvec4(scene_.vertex_colors[triangle.v1]) +
                    b.z * glm::dvec4(scene_.vertex_colors[triangle.v2]);
  surface.coverage = coverage_at(scene_, index, barycentrics);
  surface.triangle = index;
  surface.material = triangle.material;
  surface.light = triangle.light;
  surface.walk_guide = walk_guide_.get();
  const dvec3 sum = b.x * dvec3(v0.normal) + b.y * dvec3(v1.normal) + b.z * dvec3(v2.normal);
  if (has_smooth_normals_ && dot(sum, sum) > 1e-12) {  // normals that cancel say nothing
    const double sign_of_normals = dot(sum, cross) < 0 ? -1 : 1;
    surface.shading_normal = normalize(sign_of_normals * sum);
    set_bulge(surface, placed, b, sign_of_normals);
  }
  const Material& material = scene_.materials[surface.material];
  if ((material.flags & MATERIAL_COAT_NORMAL) != 0)
    surface.coat_normal = material.clearcoat_normal_texture == INVALID_INDEX
                              ? surface.shading_normal
                              : mapped_normal(surface, placed, b, sum, material.clearcoat_normal_texture,
                                              material.clearcoat_normal_scale);
  surface.has_relief = material.normal_texture != INVALID_INDEX;
  if (surface.has_relief)
    surface.shading_normal =
        mapped_normal(surface, placed, b, sum, material.normal_texture, material.normal_scale);
  set_anisotropy(surface, placed, b);
  return surface;
}

void World::set_bulge(Surface& surface, const scene::PlacedTriangle& placed, const dvec3& b,
                      double sign_of_normals) const {
  constexpr double LEAST_BULGE = 1e-3;  // radians: part of the model
  std::array<dvec3, 3> p, n;
  for (size_t i = 0; i < 3; ++i) {
    const Vertex vertex = placed_vertex(scene_, placed, placed.corners()[i]);
    p[i] = dvec3(vertex.position);
    n[i] = sign_of_normals * dvec3(vertex.normal);
  }
  double spread = 0;
  double perimeter = 0;
  for (size_t i = 0; i < 3; ++i) {
    const dvec3 edge = p[(i + 1) % 3] - p[i];
    spread += dot(edge, n[(i + 1) % 3] - n[i]);
    perimeter += length(edge);
  }
  if (!(std::abs(spread) > LEAST_BULGE * perimeter)) return;
  surface.bulge = spread > 0 ? 1 : -1;
  // Hanika 2021: projected onto the tangent planes of the vertices that lie above, and interpolated.
  for (size_t i = 0; i < 3; ++i) {
    const dvec3 up = static_cast<double>(surface.bulge) * normalize(n[i]);
    surface.rise += b[static_cast<int>(i)] * std::max(dot(p[i] - surface.position, up), 0.0) * up;
  }
}

double World::mean_curvature(uint32_t index) const {
  if (!has_smooth_normals_) return 0;
  const scene::PlacedTriangle placed = scene::placed_triangle(scene_, index);
  std::array<dvec3, 3> p, n;
  for (size_t i = 0; i < 3; ++i) {
    const Vertex vertex = placed_vertex(scene_, placed, placed.corners()[i]);
    p[i] = dvec3(vertex.position);
    n[i] = dvec3(vertex.normal);
  }
  const dvec3 doubled = cross(p[1] - p[0], p[2] - p[0]);
  const double longest = std::max({length(p[1] - p[0]), length(p[2] - p[1]), length(p[0] - p[2])});
  if (!(length(doubled) > 1e-6 * longest * longest)) return 0;
  // The gradient of vertex i's barycentric coordinate is N x (opposite edge) / (2 area).
  double divergence = 0;
  for (size_t i = 0; i < 3; ++i)
    divergence += dot(n[i], cross(doubled, p[(i + 2) % 3] - p[(i + 1) % 3])) / dot(doubled, doubled);
  const double side = dot(n[0] + n[1] + n[2], doubled) < 0 ? -1 : 1;
  return std::clamp(side * divergence / 2, -1 / longest, 1 / longest);
}

glm::dvec4 World::tangent_at(const scene::PlacedTriangle& placed, const dvec3& b) const {
  glm::dvec4 sum(0);
  for (size_t i = 0; i < 3; ++i)
    sum += b[static_cast<int>(i)] * glm::dvec4(placed_tangent(scene_, placed, placed.corners()[i]));
  sum.w = placed_tangent(scene_, placed, placed.triangle.v0).w;
  return sum;
}

void World::set_anisotropy(Surface& surface, const scene::PlacedTriangle& placed, const dvec3& b) const {
  const Material& material = scene_.materials[surface.material];
  if (!(material.anisotropy > 0)) return;
  surface.anisotropy = material.anisotropy;
  dvec2 direction(material.anisotropy_direction);
  if (material.anisotropy_texture != INVALID_INDEX) {
    const glm::dvec4 texel = texture_at(material.anisotropy_texture, surface.uv);
    const dvec2 turned = 2.0 * dvec2(texel) - 1.0;
    direction = {direction.x * turned.x - direction.y * turned.y,
                 direction.x * turned.y + direction.y * turned.x};
    surface.anisotropy *= texel.z;
  }
  const glm::dvec4 tangent = tangent_at(placed, b);
  const dvec3 bitangent = tangent.w * cross(surface.shading_normal, dvec3(tangent));
  dvec3 along = direction.x * dvec3(tangent) + direction.y * bitangent;
  along -= dot(along, surface.shading_normal) * surface.shading_normal;
  if (dot(along, along) > 1e-12) surface.tangent = normalize(along);
}

dvec3 World::mapped_normal(const Surface& surface, const scene::PlacedTriangle& placed, const dvec3& b,
                           const dvec3& normal, uint32_t texture, double normal_scale) const {
  const glm::dvec4 tangent = tangent_at(placed, b);
  const dvec3 bitangent = tangent.w * cross(normal, dvec3(tangent));
  const dvec3 texel(texture_at(texture, surface.uv));
  const dvec3 scale(normal_scale, normal_scale, 1);
  const dvec3 map = (2.0 * texel - 1.0) * scale;
  dvec3 mapped = map.x * dvec3(tangent) + map.y * bitangent + map.z * normal;
  if (dot(normal, surface.geometric_normal) < 0) mapped = -mapped;
  if (!(dot(mapped, mapped) > 1e-12)) return surface.shading_normal;
  mapped = normalize(mapped);
  const double missing = MIN_MAPPED_COS - dot(mapped, surface.geometric_normal);
  return missing > 0 ? normalize(mapped + missing * surface.geometric_normal) : mapped;
}

glm::dvec4 World::texture_at(uint32_t index, const scene::TextureCoordinates& uv) const {
  if (index == INVALID_INDEX) return glm::dvec4(1);
  return scene::sample_texture(scene_, scene_.textures[index], uv);
}

void World::set_index(const Material& material, uint32_t in_front, const Wavelength& wavelength,
                      double smooth_average, BsdfParameters& p) const {
  const Material* other = in_front == INVALID_INDEX ? nullptr : &scene_.materials[in_front];
  p.ior = index_at(material, wavelength) / (other == nullptr ? 1 : index_at(*other, wavelength));
  p.is_dispersive = scene::is_dispersive(material) || (other != nullptr && scene::is_dispersive(*other));
  if (!p.is_dispersive)
    p.fresnel_average = other == nullptr ? smooth_average : relative_average_.at({material.ior, other->ior});
  else  // for a diffuse base alone, which glass hardly ever has
    p.fresnel_average =
        (1 - p.transmission) * (1 - p.metallic) > 0 ? fresnel_dielectric_average(p.ior) : smooth_average;
}

Bsdf World::bsdf_at(const Surface& surface, const Media& around, const Wavelength& wavelength) const {
  const Material& material = scene_.materials[surface.material];
  const glm::dvec4 metallic_roughness = texture_at(material.metallic_roughness_texture, surface.uv);
  const double roughness = material.roughness * metallic_roughness.g;
  BsdfParameters p;
  p.base_color = dvec3(material.base_color) * dvec3(surface.color) *
                 dvec3(texture_at(material.base_color_texture, surface.uv));
  p.metallic = material.metallic * metallic_roughness.b;
  p.alpha = dvec2(roughness > 0 ? std::max(roughness * roughness, MIN_ALPHA) : 0.0);
  if (surface.anisotropy > 0) {
    const double alpha = roughness * roughness;
    const double strength = surface.anisotropy * surface.anisotropy;
    p.alpha = max(dvec2(alpha + (1 - alpha) * strength, alpha), MIN_ANISOTROPIC_ALPHA);
  }
  const double coat_roughness =
      material.clearcoat_roughness * texture_at(material.clearcoat_roughness_texture, surface.uv).g;
  p.clearcoat = material.clearcoat * texture_at(material.clearcoat_texture, surface.uv).r;
  p.coat_alpha = dvec2(coat_roughness > 0 ? std::max(coat_roughness * coat_roughness, MIN_ALPHA) : 0.0);
  if (surface.coat_normal != dvec3(0)) p.coat_normal = to_material(surface, surface.coat_normal);
  if (material.sheen_color != glm::vec3(0)) {
    p.sheen = sheen_.get();
    p.sheen_color = dvec3(material.sheen_color) * dvec3(texture_at(material.sheen_color_texture, surface.uv));
    p.sheen_roughness = sheen_roughness(material.sheen_roughness *
                                        texture_at(material.sheen_roughness_texture, surface.uv).a);
  }
  if (material.iridescence > 0) {
    const double share = texture_at(material.iridescence_thickness_texture, surface.uv).g;
    const glm::dvec2 range(material.iridescence_thickness);
    p.film_strength = material.iridescence * texture_at(material.iridescence_texture, surface.uv).r;
    p.film = {material.iridescence_ior, range.x + share * (range.y - range.x)};
  }
  p.transmission = material.transmission * texture_at(material.transmission_texture, surface.uv).r;
  p.specular = material.specular * texture_at(material.specular_texture, surface.uv).a;
  p.specular_color =
      dvec3(material.specular_color) * dvec3(texture_at(material.specular_color_texture, surface.uv));
  p.is_volume = (material.flags & MATERIAL_VOLUME) != 0;
  p.ndf = ndf_;
  p.shadowing = shadowing_;
  const uint32_t solid = has_contacts() ? solid_of(surface.triangle) : INVALID_INDEX;
  const uint32_t in_front = solid == INVALID_INDEX ? INVALID_INDEX : medium_of(around.without(solid));
  set_index(material, in_front, wavelength, fresnel_average_[surface.material], p);
  // Without a specular lobe there is no interface to compensate for.
  if (material.material_class != MATERIAL_CLASS_DIFFUSE) {
    if (compensates_energy_) p.energy = &energy_;
    if (!compensates_energy_ && has_rough_bases_) p.cover = &energy_;
    p.raised_light = &energy_;
  }
  p.cover_error = surface.cover_error;
  *p.fresnel_average += surface.fresnel_error;
  return Bsdf(p);
}

dvec3 World::emission_at(const Surface& surface) const {
  const Material& material = scene_.materials[surface.material];
  const bool is_unlit = (material.flags & MATERIAL_UNLIT) != 0;
  return dvec3(material.emission) * dvec3(texture_at(material.emissive_texture, surface.uv)) *
         (is_unlit ? dvec3(surface.color) : dvec3(1));
}

bool World::emits_from_both_sides(const Surface& surface) const {
  return (scene_.materials[surface.material].flags & MATERIAL_DOUBLE_SIDED) != 0;
}

dvec3 World::transmittance(uint32_t medium, double distance) const {
  if (medium == INVALID_INDEX) return dvec3(1);
  return exp(-distance * dvec3(scene_.materials[medium].absorption));
}

uint32_t World::solid_of(uint32_t triangle) const {
  const std::vector<uint32_t>& of_triangle = scene_.solids.of_triangle;
  return triangle < of_triangle.size() ? of_triangle[triangle] : INVALID_INDEX;
}

bool World::bounds_closed_solid(uint32_t triangle) const {
  const uint32_t solid = solid_of(triangle);
  return solid != INVALID_INDEX && scene_.solids.ranked[solid].is_closed;
}

uint32_t World::medium_of(const Media& around) const {
  return around.first() == INVALID_INDEX ? INVALID_INDEX : scene_.solids.records[around.first()].material;
}

Place World::place_towards(const Surface& surface, const Media& around, const dvec3& from, const dvec3& w,
                           bool is_beyond) const {
  // The facet itself may then be in the way.
  if (is_beyond) return {around};
  Place place{around, surface.triangle};
  const bool came_from_front = dot(from, surface.geometric_normal) > 0;
  const bool leaves_to_front = dot(w, surface.geometric_normal) > 0;
  const uint32_t solid = has_contacts() ? solid_of(surface.triangle) : INVALID_INDEX;
  if (solid == INVALID_INDEX || came_from_front == leaves_to_front) return place;
  came_from_front ? place.around.enter(solid) : place.around.leave(solid);
  return place;
}

uint32_t World::medium_towards(const Surface& surface, uint32_t medium, const Media& around,
                               const dvec3& from, const dvec3& w, bool is_beyond) const {
  const Material& material = scene_.materials[surface.material];
  const bool has_inside =
      material.material_class == MATERIAL_CLASS_TRANSMISSIVE && (material.flags & MATERIAL_VOLUME) != 0;
  const bool came_from_front = dot(from, surface.geometric_normal) > 0;
  const bool leaves_to_front = dot(w, surface.geometric_normal) > 0;
  if (!has_inside || is_beyond || came_from_front == leaves_to_front) return medium;
  if (has_contacts() && solid_of(surface.triangle) != INVALID_INDEX)
    return medium_of(place_towards(surface, around, from, w).around);
  return came_from_front ? surface.material : INVALID_INDEX;
}

bool World::is_passed(const Media& around, uint32_t solid) const {
  const uint32_t other = around.without(solid).first();
  const std::vector<Solid>& records = scene_.solids.records;
  return other != INVALID_INDEX && (other < solid || records[other].substance == records[solid].substance);
}

namespace {

// A ray passes at most this many interfaces that are none, as in shaders/lib/contacts.glsl.
constexpr int MAX_PASSED = 64;

void cross_boundary(Media& media, uint32_t solid, bool is_front) {
  is_front ? media.enter(solid) : media.leave(solid);
}

}  // namespace

std::optional<Intersection> World::meet(const Ray& ray, Place& place) const {
  if (!has_contacts()) return traversal_.closest(ray);
  // From where it starts to see.
  Contact contact{place.around};
  contact.end = ray.t_max - ray.t_min;
  contact.left = place.triangle == INVALID_INDEX ? INVALID_INDEX : solid_of(place.triangle);
  contact.triangle = place.triangle;
  Ray own = ray;
  own.origin += ray.t_min * ray.direction;
  own.contact = &contact;
  own.skip_first = INVALID_INDEX;
  std::optional<Intersection> hit;
  for (int passed = 0; passed < MAX_PASSED; ++passed) {
    hit = traversal_.closest(own);
    const uint32_t solid = hit ? solid_of(hit->triangle) : INVALID_INDEX;
    if (solid == INVALID_INDEX || !is_passed(contact.around, solid)) break;
    cross_boundary(contact.around, solid, hit->is_front);
    contact.from = hit->t;
    contact.crossed = solid;
  }
  place.around = contact.around;
  if (hit) hit->t = std::max(hit->t, 0.0) + ray.t_min;
  return hit;
}

Media World::media_at(const dvec3& point) const {
  Contact contact;
  contact.is_blind = true;
  const Ray ray{.origin = point, .direction = normalize(dvec3(0.5377, 0.7339, 0.4151)), .contact = &contact};
  for (int crossed = 0; crossed < MAX_PASSED; ++crossed) {
    const auto hit = traversal_.closest(ray);
    if (!hit) break;
    const uint32_t solid = solid_of(hit->triangle);
    if (!hit->is_front && !contact.around.contain(solid))
      contact.holding.enter(solid);
    else
      cross_boundary(contact.around, solid, hit->is_front);
    contact.from = hit->t;
    contact.crossed = solid;
  }
  return contact.holding;
}

Media World::media_of_set(uint32_t set, const dvec3& origin) const {
  return set == MEDIA_VARY ? media_at(origin) : Media(scene_.solids.media_sets[set]);
}

Media World::media_of_camera(uint32_t camera, const dvec3& origin) const {
  return has_contacts() ? media_of_set(scene_.solids.of_camera.at(camera), origin) : Media();
}

Media World::media_of_light(uint32_t light, const dvec3& origin) const {
  return has_contacts() ? media_of_set(scene_.solids.of_light.at(light), origin) : Media();
}

Ray World::ray_from(const Surface& surface, const dvec3& direction, bool is_beyond) const {
  // The facet itself may then be in the way.
  if (is_beyond) return {surface.position + surface.rise, direction};
  const dvec3 size = glm::abs(surface.position);
  const double largest = std::max({size.x, size.y, size.z});
  Ray ray{surface.position, direction};
  if (has_contacts()) {
    // Off whatever else lies in the same plane, like the device's clearance; boundaries of closed solids need
    // none.
    const double side = dot(direction, surface.geometric_normal) < 0 ? -1 : 1;
    if (!bounds_closed_solid(surface.triangle))
      ray.origin += side * CONTACT_CLEARANCE * 0x1p-24 * largest * surface.geometric_normal;
    return ray;
  }
  ray.t_min = SEGMENT_START * std::max(largest, std::sqrt(surface.area));
  ray.skip_first = surface.triangle;
  return ray;
}

bool World::is_visible(const Surface& from, const Place& place, const dvec3& to, uint32_t target,
                       bool is_beyond) const {
  const dvec3 segment = to - (is_beyond ? from.position + from.rise : from.position);
  const double distance = length(segment);
  Ray ray = ray_from(from, segment / distance, is_beyond);
  ray.t_max = distance - ray.t_min;
  ray.skip_last = target;
  if (!has_contacts()) return !traversal_.is_occluded(ray);
  // The end is as far off its surface as the start.
  const dvec3 size = glm::abs(to);
  ray.t_max -= 2 * CONTACT_CLEARANCE * 0x1p-24 * std::max({size.x, size.y, size.z});
  Place there = place;
  return !meet(ray, there);
}

bool World::is_open(const Surface& from, const Place& place, const dvec3& direction, bool is_beyond) const {
  const Ray ray = ray_from(from, direction, is_beyond);
  if (!has_contacts()) return !traversal_.is_occluded(ray);
  Place there = place;
  return !meet(ray, there);
}

}  // namespace regulus::reference
