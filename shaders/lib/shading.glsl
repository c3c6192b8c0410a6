// A camera path at a surface: the local frame, the material there, and the three things that can happen:
// the surface emits (`hit`), a light is sampled (`nee`), the walk goes on.
#ifndef REGULUS_LIB_SHADING_GLSL
#define REGULUS_LIB_SHADING_GLSL

#include "lib/bsdf.glsl"
#include "lib/dispersion.glsl"
#include "lib/light.glsl"
#include "lib/media.glsl"
#include "lib/normal_map.glsl"
#include "lib/stage.glsl"

// A path vertex. Local frame: z is the shading normal on the side that wo is on.
struct ShadingPoint {
  Surface surface;
  Material material;
  Bsdf bsdf;
  vec3 tangent, bitangent, normal;  // local axes in world space
  vec3 geometric_normal;            // on the side of wo
  vec3 wo;                          // local
  bool is_front;                    // wo is on the front side
  bool is_turned;                   // wo was half-turned; only with smooth normals
  float bulge;                      // as of the surface, 1: on the side of wo; only with FEATURE_BULGES
  bool is_curved;                   // the camera's side bulges, for camera walks; only with FEATURE_BULGES
  bool is_dispersive;               // the bsdf depends on the wavelength
  GuideCell cell;                   // only with has_walk_guide()
  // Only with FEATURE_CONTACTS:
  MediaSet around;  // the solids on the side of wo
  uint solid;       // the solid whose boundary the surface is, or INVALID_INDEX
  bool is_closed;   // that solid is closed
};

vec3 to_local(const ShadingPoint point, vec3 w) {
  return vec3(dot(w, point.tangent), dot(w, point.bitangent), dot(w, point.normal));
}
vec3 to_world(const ShadingPoint point, vec3 w) {
  return w.x * point.tangent + w.y * point.bitangent + w.z * point.normal;
}

// True if the geometric and the shading normal agree on which side of the surface w is (w_local: the same in the
// local frame).
bool sides_agree(const ShadingPoint point, vec3 w, vec3 w_local) {
  return dot(w, point.geometric_normal) * w_local.z > 0.0;
}

// Where the normals disagree about a direction w, towards the light or the camera, the bsdf sees w after a half-turn about the
// line in which the two tangent planes meet. That exchanges the directions between the planes, keeps solid angles and the
// absolute cosines with both normals, and is its own inverse: every direction on a side of the surface has a partner on the
// bsdf's side, nothing that a lobe scatters is lost, nothing is black because it is seen at a slant, and pdfs stay densities.
// Both directions are treated so, and hence a pair like its reverse. Two exceptions, functions of the path like the rule:
// - The diffuse lobe of a normal-mapped surface gets no light that way: the shadow of the relief.
// - Where the surface bulges towards the camera (Surface.bulge) the shading normal alone decides about light. Some comes from
//   beyond the facet's horizon: it arrives at the curved surface for which the facet stands, so rays in such directions start
//   there (Surface.rise). No light walk arrives at a facet like this: its probability there is 0. From behind the shading
//   normal there is no light.
vec3 half_turned(const ShadingPoint point, vec3 w_local) {
  vec2 axis = vec2(-dot(point.geometric_normal, point.bitangent), dot(point.geometric_normal, point.tangent));
  float squared = dot(axis, axis);
  axis = squared > 1e-12 ? axis * inversesqrt(squared) : vec2(1.0, 0.0);
  return vec3(2.0 * dot(w_local.xy, axis) * axis - w_local.xy, -w_local.z);
}

// A direction towards the camera, as the bsdf sees it.
vec3 to_local_seen(const ShadingPoint point, vec3 w) {
  vec3 local = to_local(point, w);
  if ((spec_features & FEATURE_SMOOTH_NORMALS) == 0u || sides_agree(point, w, local)) return local;
  return half_turned(point, local);
}

// The direction towards the camera that the bsdf sees as w_local.
vec3 to_world_seen(const ShadingPoint point, vec3 w_local) {
  vec3 w = to_world(point, w_local);
  if ((spec_features & FEATURE_SMOOTH_NORMALS) == 0u || sides_agree(point, w, w_local)) return w;
  return to_world(point, half_turned(point, w_local));
}

// True if the surface bulges on the side of w, a direction towards the camera.
bool bulges_towards(const ShadingPoint point, vec3 w) {
  return (spec_features & FEATURE_BULGES) != 0u && point.bulge * dot(w, point.geometric_normal) > 0.0;
}

// At a point of a light walk: true if light from wo does not go towards w. See half_turned.
bool is_dark_towards(const ShadingPoint point, vec3 w) {
  return (spec_features & FEATURE_BULGES) != 0u && point.is_turned && bulges_towards(point, w);
}

// At a point of a camera walk: true if w, towards the light, lies beyond the facet's horizon and counts.
bool is_beyond_horizon(const ShadingPoint point, vec3 w) {
  return (spec_features & FEATURE_BULGES) != 0u && point.is_curved && dot(w, point.normal) > 0.0 &&
         dot(w, point.geometric_normal) < 0.0;
}

// The absolute cosine with which a light walk arrives from w, 0 if none can.
float arrival_cosine(const ShadingPoint point, vec3 w) {
  return is_beyond_horizon(point, w) ? 0.0 : abs(dot(w, point.geometric_normal));
}

// At a point of a camera walk: a direction towards the light, as the bsdf sees it. False if no light comes from there.
bool to_local_lit(const ShadingPoint point, vec3 w, out vec3 local) {
  local = to_local(point, w);
  if (sides_agree(point, w, local)) return true;
  if ((spec_features & FEATURE_SMOOTH_NORMALS) == 0u) return false;
  if ((spec_features & FEATURE_BULGES) != 0u && point.is_curved) return local.z > 0.0;
  local = half_turned(point, local);
  return local.z != 0.0;
}

// The direction towards the light that the bsdf sees as w_local.
bool to_world_lit(const ShadingPoint point, vec3 w_local, out vec3 w) {
  w = to_world(point, w_local);
  if (sides_agree(point, w, w_local)) return true;
  if ((spec_features & FEATURE_SMOOTH_NORMALS) == 0u) return false;
  if ((spec_features & FEATURE_BULGES) != 0u && point.is_curved) return w_local.z > 0.0;
  w = to_world(point, half_turned(point, w_local));
  return w_local.z != 0.0;
}

// Where a ray leaves the point towards `direction`.
vec3 ray_origin(const ShadingPoint point, vec3 direction) {
  vec3 position = point.surface.position;
  if (is_beyond_horizon(point, direction)) {
    position += point.surface.rise;
    direction = point.geometric_normal;
  } else if (has_contacts() && point.is_closed) {
    return position;
  }
  return offset_origin(position, point.surface.clearance, point.geometric_normal, direction);
}

// Turns the local axes so that the tangent runs along the direction in which the material's roughness is stretched.
// Applies the anisotropy texture.
void align_with_anisotropy(Frame frame, uint triangle_number, vec2 barycentrics, inout ShadingPoint point) {
  vec2 direction = point.material.anisotropy_direction;
  if ((spec_features & FEATURE_TEXTURES) != 0u && point.material.anisotropy_texture != INVALID_INDEX) {
    vec3 texel = sample_texture(frame, point.material.anisotropy_texture, point.surface.uv).xyz;
    vec2 turned = 2.0 * texel.xy - 1.0;
    direction = vec2(direction.x * turned.x - direction.y * turned.y, direction.x * turned.y + direction.y * turned.x);
    point.material.anisotropy *= texel.z;
  }
  vec4 tangent = vertex_tangent(frame, placed_triangle(frame, triangle_number), barycentrics);
  vec3 bitangent = tangent.w * cross(point.surface.shading_normal, tangent.xyz);
  vec3 along = direction.x * tangent.xyz + direction.y * bitangent;
  along -= dot(along, point.normal) * point.normal;
  float squared = dot(along, along);
  if (!(squared > 1e-12)) return;
  point.tangent = along * inversesqrt(squared);
  point.bitangent = cross(point.normal, point.tangent);
}

// Unit normal of the clearcoat on the front side; `surface` has the vertices' normal.
vec3 coat_normal(Frame frame, uint triangle, vec2 barycentrics, const Surface surface, Material material) {
  if ((spec_features & FEATURE_TEXTURES) == 0u || material.clearcoat_normal_texture == INVALID_INDEX)
    return surface.shading_normal;
  return mapped_normal(frame, triangle, barycentrics, surface, material.clearcoat_normal_texture,
                       material.clearcoat_normal_scale);
}

// Gives the material its index of refraction at the wavelength of this bend.
void disperse(float bend, inout ShadingPoint point) {
  point.is_dispersive = point.material.dispersion > 0.0;
  if (point.is_dispersive) point.material.ior = dispersed_ior(point.material.ior, point.material.dispersion, bend);
}

// Sets the index of refraction behind the surface relative to that in front of it. Where solids overlap, neither need be the
// surface's own index or 1.
void set_media(Frame frame, MediaSet around, uint triangle, float bend, inout ShadingPoint point) {
  uint tag = triangle_tag(frame, triangle);
  point.around = around;
  point.solid = solid_of_tag(tag);
  point.is_closed = (tag & TRIANGLE_TAG_CLOSED) != 0u;
  if (spec_material_class != MATERIAL_CLASS_TRANSMISSIVE || point.solid == INVALID_INDEX) return;
  uint in_front = medium_of(frame, media_without(around, point.solid));
  if (in_front == INVALID_INDEX) return;
  float ior = LOAD(MaterialBuffer, frame.materials, in_front).ior;
  if (has_dispersion()) {
    float dispersion = LOAD(MaterialBuffer, frame.materials, in_front).dispersion;
    if (dispersion > 0.0) ior = dispersed_ior(ior, dispersion, bend);
    point.is_dispersive = point.is_dispersive || dispersion > 0.0;
  }
  point.material.ior /= ior;
}

// wo: unit, towards the previous vertex of the walk, which is on the side of the camera for TRANSPORT_RADIANCE; around: the
// solids on its side; bend: of the path's wavelength.
ShadingPoint shading_point(Frame frame, uint triangle, vec2 barycentrics, vec3 wo, uint transport, MediaSet around, float bend) {
  ShadingPoint point;
  point.surface = surface_at(frame, triangle, barycentrics);
  point.is_front = dot(wo, point.surface.geometric_normal) > 0.0;
  float side = point.is_front ? 1.0 : -1.0;
  point.geometric_normal = side * point.surface.geometric_normal;
  point.material = LOAD(MaterialBuffer, frame.materials, point.surface.material);
  vec3 of_coat = vec3(0.0);
  if (bsdf_has_coat_normal() && (point.material.flags & MATERIAL_COAT_NORMAL) != 0u)
    of_coat = side * coat_normal(frame, triangle, barycentrics, point.surface, point.material);
  if ((spec_features & FEATURE_NORMAL_MAPS) != 0u && point.material.normal_texture != INVALID_INDEX)
    point.surface.shading_normal = mapped_normal(frame, triangle, barycentrics, point.surface, point.material.normal_texture,
                                                 point.material.normal_scale);
  point.normal = side * point.surface.shading_normal;
  orthonormal_basis(point.normal, point.tangent, point.bitangent);
  if ((spec_features & FEATURE_ANISOTROPY) != 0u && point.material.anisotropy > 0.0)
    align_with_anisotropy(frame, triangle, barycentrics, point);
  point.wo = to_local_seen(point, wo);
  point.is_turned = (spec_features & FEATURE_SMOOTH_NORMALS) != 0u && !sides_agree(point, wo, to_local(point, wo));
  point.bulge = side * point.surface.bulge;
  point.is_curved = transport == TRANSPORT_RADIANCE && point.bulge > 0.0;
  apply_textures(frame, point.surface.uv, point.surface.color, point.material);
  point.is_dispersive = false;
  if (has_dispersion()) disperse(bend, point);
  if (has_contacts()) set_media(frame, around, triangle, bend, point);
  if (has_walk_guide()) point.cell = guide_cell(frame, point.surface.position, point.geometric_normal);
  point.bsdf = make_bsdf(point.material, point.is_front);
  bool is_curved = (spec_features & FEATURE_BULGES) != 0u && point.is_curved;
  if (bsdf_has_relief() && point.material.normal_texture != INVALID_INDEX && !is_curved)
    point.bsdf.geometric_normal = to_local(point, point.geometric_normal);
  if (bsdf_has_coat_normal() && point.bsdf.coat.is_turned) point.bsdf.coat.normal = to_local(point, of_coat);
  complete_bsdf(frame, point.material, point.is_front, point.bsdf);
  return point;
}

// With a guide: prepares the bsdf for a pair of directions of which w (unit, world space) is the one towards the light.
void look_towards(Frame frame, vec3 w, inout ShadingPoint point) {
  if (!has_walk_guide()) return;
  if (point.cell.share > 0.0) point.bsdf.guide = vec2(point.cell.share, guided_pdf(frame, point.cell, w));
}

// With a guide: has a camera walk that chose the diffuse lobe go the guide's way, by the cell's share, and prepares the bsdf for
// what was chosen. u: the numbers of the direction.
void guide_choice(Frame frame, vec2 u, inout ShadingPoint point, inout BsdfChoice choice) {
  if (!(point.cell.share > 0.0)) return;
  vec3 w;
  if (choice.is_diffuse && choice.u_diffuse < point.cell.share) {
    GuidedDirection guided = guided_direction(frame, point.cell, u);
    bool is_lit = to_local_lit(point, guided.w, choice.wi);
    choice.facet = reflection_encounter(point.wo, vec3(choice.wi.xy, abs(choice.wi.z)));
    choice.facet.is_valid = is_lit && choice.wi.z > 0.0;
    point.bsdf.guide = vec2(point.cell.share, guided.pdf);
  } else if (to_world_lit(point, choice.wi, w)) {
    look_towards(frame, w, point);
  }
}

// Shadow segments end this much before their target: the traversal's t of the light's own triangle errs by a
// few roundings of the distance.
const float SEGMENT_SCALE = 1.0 - 16.0 * FLOAT_EPSILON;

// The solids on the side of the surface that w leaves to.
MediaSet media_towards(const ShadingPoint point, float w_local_z) {
  if (spec_material_class != MATERIAL_CLASS_TRANSMISSIVE || w_local_z > 0.0 || point.solid == INVALID_INDEX) return point.around;
  return media_behind(point.around, point.solid, point.is_front);
}

// Medium on the side of the surface that w leaves to, for a path that arrived through `medium`.
uint medium_towards(Frame frame, const ShadingPoint point, uint medium, float w_local_z) {
  if ((spec_features & FEATURE_ABSORPTION) == 0u || spec_material_class != MATERIAL_CLASS_TRANSMISSIVE) return medium;
  if (w_local_z > 0.0 || (point.material.flags & MATERIAL_VOLUME) == 0u) return medium;
  if (has_contacts() && point.solid != INVALID_INDEX) return medium_of(frame, media_towards(point, w_local_z));
  return point.is_front ? point.surface.material : INVALID_INDEX;
}

// Where a ray that leaves the surface towards w starts. triangle, barycentrics: of the surface. A ray towards what lies beyond
// the facet's horizon stays on the side of wo and leaves no surface: the facet itself may be in its way.
PathMedia ray_media(const ShadingPoint point, vec3 w, float w_local_z, uint triangle, vec2 barycentrics) {
  if (is_beyond_horizon(point, w)) return start_media(point.around);
  return PathMedia(media_towards(point, w_local_z), barycentrics, triangle, point.solid);
}

// Transmittance of `distance` metres of a medium (Beer and Lambert).
vec3 transmittance(Frame frame, uint medium, float distance) {
  if ((spec_features & FEATURE_ABSORPTION) == 0u || medium == INVALID_INDEX) return vec3(1.0);
  vec3 absorption = LOAD(MaterialBuffer, frame.materials, medium).absorption;
  return exp_accurate(-absorption * distance);
}

// Transmittance of what lies between the lens and the near plane, which is only the medium of the lens. (Without contacts, no
// solid holds the lens.)
vec3 transmittance_before_plane(Frame frame, float distance) {
  if ((spec_features & FEATURE_CLIPPING) == 0u || !has_contacts()) return vec3(1.0);
  return transmittance(frame, frame.lens_medium, distance);
}

// Factor from a light walk's |cos| of the shading normal to the path's own measure: |w.n_s| / |w.n_g| with w towards
// the light (Veach 1997, section 5.3). 1 without smooth normals.
float shading_correction(const ShadingPoint point, vec3 towards_light, float cos_shading) {
  if ((spec_features & FEATURE_SMOOTH_NORMALS) == 0u) return 1.0;
  return abs(cos_shading) / max(abs(dot(towards_light, point.geometric_normal)), 1e-7);
}

// True if the surface has a lobe that connections and merges can use.
bool is_connectible(const ShadingPoint point) {
  if (spec_regularization != REGULARIZATION_NONE) return true;
  return has_finite_lobe(point.bsdf);
}

// The point as the choice of a light sees it. Where a surface only reflects, the light that counts comes from the side of wo,
// whichever way the path is walked: by the geometric normal, or where the surface bulges, by the shading normal.
LightReceiver light_receiver(const ShadingPoint point) {
  vec3 normal = (spec_features & FEATURE_BULGES) != 0u && point.bulge > 0.0 ? point.normal : point.geometric_normal;
  return LightReceiver(point.surface.position, spec_material_class == MATERIAL_CLASS_TRANSMISSIVE ? vec3(0.0) : normal);
}

// The segment from a surface point to `target` (already off its own surface), as a candidate without contribution.
VisibilityCandidate visibility_segment(const ShadingPoint point, vec3 towards, vec3 target) {
  VisibilityCandidate candidate;
  candidate.origin = ray_origin(point, towards);
  vec3 segment = target - candidate.origin;
  float distance = length(segment);
  candidate.direction = segment / distance;
  candidate.t_max = distance * SEGMENT_SCALE;
  return candidate;
}

#endif
