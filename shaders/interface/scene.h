// The scene as kernels read it: geometry, materials, textures, lights, camera. The same arrays are the
// input of the scalar reference. World space, metres, linear Rec. 709.
#ifndef REGULUS_INTERFACE_SCENE_H
#define REGULUS_INTERFACE_SCENE_H

#include "types.h"

REGULUS_INTERFACE_BEGIN

// Vertex in world space, or in that of its mesh if the mesh has instances. `normal` is unit length; flat-shaded triangles
// own their vertices and carry the geometric normal in them.
struct Vertex {
  vec3 position;
  vec3 normal;
  vec2 uv;
};
REGULUS_LAYOUT(Vertex, 32);

// Shading data of one triangle. Its geometric normal is cross(p1 - p0, p2 - p0): the front face is the
// side from which the vertices run counter-clockwise (the loader swaps vertices of mirrored instances).
// Triangles are stored in the order of the acceleration structure's leaves: one index serves both.
struct Triangle {
  uint v0, v1, v2;
  uint material;
  uint light;  // index into the lights, or INVALID_INDEX if it does not emit
  uint instance;  // place of a mesh in the scene, counted from 0 in the order of its nodes
};
REGULUS_LAYOUT(Triangle, 24);

// A copy of a mesh that is stored once. A vertex v of the mesh stands at x_axis * v.x + y_axis * v.y + z_axis * v.z +
// translation, summed from the left in single precision, in traversal and shading alike: what rays meet is that triangle
// in world space, as if it were stored.
// Numbers of triangles: a stored triangle that stands for itself has its index. The copies' triangles follow behind all
// stored ones, each copy's in the order in which its mesh's are stored, from `first_number` on. Blocks of numbers belong
// to one copy each: Frame.instance_blocks.
struct Instance {
  vec3 x_axis, y_axis, z_axis, translation;
  vec3 inverse_x, inverse_y, inverse_z;  // rows of the inverse of the matrix of the axes
  vec3 reach;           // m: |x_axis| |v.x| + |y_axis| |v.y| + |z_axis| |v.z| + |translation| is less for all vertices
  uint root;            // node of the mesh's tree
  uint first_triangle;  // of the mesh
  uint first_number;    // of the copy's triangles
  uint place;           // Triangle.instance of its triangles
  uint is_mirrored;     // 1: corners 1 and 2 change places, which keeps the front in front
};
REGULUS_LAYOUT(Instance, 116);

// Material flags.
REGULUS_CONSTANT MATERIAL_DOUBLE_SIDED = 1u;  // emits from both faces; scattering never depends on it
REGULUS_CONSTANT MATERIAL_VOLUME = 2u;        // refracting boundary of a solid; clear: transmission is thin-walled
REGULUS_CONSTANT MATERIAL_EMISSIVE = 4u;
REGULUS_CONSTANT MATERIAL_UNLIT = 8u;           // its emission is its base colour: vertex colours scale it
REGULUS_CONSTANT MATERIAL_ALPHA_MASK = 16u;     // the surface is missing where alpha is below the cut-off
REGULUS_CONSTANT MATERIAL_ALPHA_BLEND = 32u;    // the surface is there with probability alpha
REGULUS_CONSTANT MATERIAL_COAT_NORMAL = 64u;    // the clearcoat's normal is not the base's

// Material classes: which lobes a material can have. Each class has a bounce queue of its own and a pipeline without the
// code of other lobes. The low 8 bits of a triangle's tag (see bvh.h).
REGULUS_CONSTANT MATERIAL_CLASS_DIFFUSE = 0u;       // Lambert only
REGULUS_CONSTANT MATERIAL_CLASS_OPAQUE = 1u;        // Lambert and microfacet reflection
REGULUS_CONSTANT MATERIAL_CLASS_TRANSMISSIVE = 2u;  // Lambert, microfacet reflection and transmission
REGULUS_CONSTANT MATERIAL_CLASS_COUNT = 3u;

// In a triangle's tag, beside the material class: the surface may have holes, so rays have to ask.
REGULUS_CONSTANT TRIANGLE_TAG_ALPHA = 256u;
REGULUS_CONSTANT TRIANGLE_TAG_EMITS = 512u;        // from its front
REGULUS_CONSTANT TRIANGLE_TAG_EMITS_BACK = 1024u;  // and from its back
REGULUS_CONSTANT TRIANGLE_TAG_CLOSED = 2048u;      // bounds a solid that is closed
REGULUS_CONSTANT TRIANGLE_TAG_SOLID_SHIFT = 12u;   // from here on: 1 + the Solid whose boundary it is; 0: none
REGULUS_CONSTANT TRIANGLE_TAG_SOLID_MASK = 0x7FFFFu;
REGULUS_CONSTANT TRIANGLE_TAG_FRONT = 1u << 31;    // in the tag of a hit, only with FEATURE_CONTACTS: the front was met

// What a refracting material with a volume bounds. Solids are numbered by rank: where several overlap, the medium is that of
// the least number (host/scene/solids.hpp says how they are ranked).
struct Solid {
  uint material;
  uint substance;  // solids of the same substance have no interface between them
};
REGULUS_LAYOUT(Solid, 8);

// The solids that hold a point, in no order; INVALID_INDEX: none. Of more than eight those of least number.
struct MediaSet {
  uvec4 a, b;
};
REGULUS_LAYOUT(MediaSet, 32);
REGULUS_CONSTANT MEDIA_SET_SIZE = 8u;
// In place of the index of a MediaSet, and in Path.medium: it varies and has to be found for each point.
REGULUS_CONSTANT MEDIA_VARY = 0xFFFFFFFEu;

// Where surfaces come closer than this along their normals, in roundings (2^-24) of the ray's largest coordinate and of the
// distance, rules decide their order: see lib/contacts.glsl.
REGULUS_CONSTANT CONTACT_ROUNDINGS = 16u;
// Rays that leave a surface which bounds no closed solid start this many roundings of its coordinates away from it, and so
// beyond whatever else lies in the same plane.
REGULUS_CONSTANT CONTACT_CLEARANCE = 8u;

// glTF metallic-roughness with the extensions we read. The model it parametrizes is in
// shaders/lib/bsdf.glsl. Texture indices are INVALID_INDEX where absent.
struct Material {
  vec3 base_color;         // linear factor
  float metallic;          // [0, 1]
  float roughness;         // perceptual, [0, 1]; alpha = roughness^2
  float ior;               // n_d, of the d line, 587.56 nm; >= 1 (KHR_materials_ior; 0 of the extension means infinite and is stored as 1e6)
  float transmission;      // [0, 1]
  float specular;          // KHR_materials_specular factor, [0, 1]
  vec3 specular_color;     // KHR_materials_specular colour factor, >= 0
  uint flags;              // MATERIAL_*
  vec3 emission;           // radiance: emissiveFactor * emissiveStrength
  uint material_class;     // MATERIAL_CLASS_*
  vec3 absorption;         // sigma_a, 1/m: -ln(attenuationColor) / attenuationDistance
  uint base_color_texture;
  uint metallic_roughness_texture;  // G: roughness, B: metallic
  uint specular_texture;            // A
  uint specular_color_texture;      // RGB
  uint emissive_texture;
  uint transmission_texture;        // R
  uint normal_texture;              // RGB: 2 texel - 1 along tangent, bitangent and normal
  float normal_scale;               // of the first two
  float alpha;                      // factor
  float alpha_cutoff;
  uint alpha_texture;               // A
  float clearcoat;                  // [0, 1]
  float clearcoat_roughness;        // perceptual
  uint clearcoat_texture;           // R
  uint clearcoat_roughness_texture; // G
  uint clearcoat_normal_texture;    // as normal_texture; absent: the vertices' normal. Only with MATERIAL_COAT_NORMAL
  float clearcoat_normal_scale;
  float anisotropy;                 // strength, [0, 1]: alpha along the direction is mix(alpha, 1, strength^2)
  vec2 anisotropy_direction;        // unit, in the tangent frame: where the roughness is stretched to
  uint anisotropy_texture;          // RG: 2 texel - 1, a direction turned with anisotropy_direction; B: strength
  vec3 sheen_color;                 // linear factor, [0, 1]; black: no sheen
  float sheen_roughness;            // perceptual
  uint sheen_color_texture;         // RGB
  uint sheen_roughness_texture;     // A
  float iridescence;                // strength of a thin film, [0, 1]; 0: there is none
  float iridescence_ior;            // of the film, >= 1
  vec2 iridescence_thickness;       // nm, where the texture is 0 and where it is 1
  uint iridescence_texture;         // R
  uint iridescence_thickness_texture;  // G
  float dispersion;                 // 20 / Abbe number (KHR_materials_dispersion); 0 unless light refracts into solids
};
REGULUS_LAYOUT(Material, 212);

// Wrap modes (glTF sampler), filters and coordinates, in Texture.flags: bits 0-1 wrap s, 2-3 wrap t, 4 nearest filter.
REGULUS_CONSTANT TEXTURE_WRAP_REPEAT = 0u;
REGULUS_CONSTANT TEXTURE_WRAP_CLAMP = 1u;
REGULUS_CONSTANT TEXTURE_WRAP_MIRROR = 2u;
REGULUS_CONSTANT TEXTURE_WRAP_T_SHIFT = 2u;
REGULUS_CONSTANT TEXTURE_NEAREST = 16u;
REGULUS_CONSTANT TEXTURE_MAPPED = 32u;      // map_u and map_v are not the identity
REGULUS_CONSTANT TEXTURE_UNORM16 = 128u;    // texels are fractions of 65535
REGULUS_CONSTANT TEXTURE_HALF = 256u;       // texels are half floats
REGULUS_CONSTANT TEXTURE_SRGB = 512u;       // RGB are sRGB codes of 8 bits: what holds colours, if it is not 16 bits wide

// From this bit on, the set of coordinates: 0 is the vertices' own, n the n-th of Frame.vertex_uvs.
REGULUS_CONSTANT TEXTURE_SET_SHIFT = 10u;
REGULUS_CONSTANT TEXTURE_SET_MASK = 15u;

// An image as plain memory (dynamic indexing of image arrays does not exist on stock lavapipe): row-major from the top
// row, RGBA texels. Most have one word of 8-bit codes, red lowest (interface/srgb.h); with TEXTURE_UNORM16 or
// TEXTURE_HALF two words of 16-bit codes or half floats (red, green; blue, alpha; lower half first).
struct Texture {
  DeviceAddress texels;  // filled when the scene goes to a device
  uint image;            // on the host: index into Scene::images
  uint width, height;
  uint flags;
  vec3 map_u, map_v;  // the image is looked up at (dot(map_u, (u, v, 1)), dot(map_v, (u, v, 1)))
};
REGULUS_LAYOUT(Texture, 48);

// Light kinds.
REGULUS_CONSTANT LIGHT_TRIANGLE = 0u;
REGULUS_CONSTANT LIGHT_POINT = 1u;
REGULUS_CONSTANT LIGHT_SPOT = 2u;
REGULUS_CONSTANT LIGHT_DIRECTIONAL = 3u;
REGULUS_CONSTANT LIGHT_ENVIRONMENT = 4u;  // the scene's Environment; one at most

// One entry of the light list.
struct Light {
  uint kind;                // LIGHT_*
  uint triangle;            // LIGHT_TRIANGLE: index of the triangle
  float selection_pdf;      // probability that selection by power returns this light
  float inner_height;       // LIGHT_SPOT: 1 - cos of the inner cone angle, which keeps its digits however narrow the cone
  vec3 position;            // point, spot
  float outer_height;       // LIGHT_SPOT: 1 - cos of the outer cone angle, > inner_height
  vec3 direction;           // spot, directional: unit, the way the light travels
  uint material;            // LIGHT_TRIANGLE: for textured emission
  vec3 intensity;           // triangle: radiance factor; point, spot: W/sr (cd); directional: W/m^2 (lx)
  float area;               // LIGHT_TRIANGLE: m^2; point, spot: the distance at which its light ends, m; 0: nowhere
};
REGULUS_LAYOUT(Light, 64);

// Light from infinitely far away in all directions: the same radiance everywhere, or a latitude-longitude map. The
// map's column x and row y, continuous, in texels, stand for the direction (sin(theta) cos(phi), cos(theta),
// sin(theta) sin(phi)) with theta = pi y / height and phi / 2 pi = x / width - 1/2 - rotation: the top row is +y, the
// middle column +x, and to its right lies +z (as three.js, and Blender's worlds after its glTF export). Texels are
// radiance, bilinearly interpolated between their centres, around in x and up to the last row in y.
// A direction is drawn by cells of one texel each: the row by a cumulative distribution of height + 1 entries, then the
// column by that row's, one of width + 1 entries; all rows' follow each other behind the first. Within a cell x and y are
// uniform.
struct Environment {
  vec3 radiance;        // the same in all directions, if there is no map
  float selection_pdf;  // of its light, by power
  uint width, height;   // of the map; 0: there is none
  float rotation;       // turns about +y, counterclockwise seen from above, [0, 1)
  uint light;           // index of its light
};
REGULUS_LAYOUT(Environment, 32);

// One bucket of the alias table over lights (Walker, Vose): bucket i is drawn uniformly, then light i with
// probability `threshold`, else light `alias`.
struct LightAlias {
  float threshold;
  uint alias;
};
REGULUS_LAYOUT(LightAlias, 8);

// Guided emission: how light paths start that go where the camera looks (docs/mathematics.md 16). A start is a light and four
// numbers of the unit cube: where on it, which way. What today's density makes of numbers that are uniform is moved by a
// binary tree of the cube: a node halves its box along one axis, and gives the first half a share of what it has itself. The
// density of a start is that of starts by power times the product of 2 share along its way.
// A light's own entry: its probability, and where its tree starts.
struct GuidedLight {
  float selection_pdf;  // probability that a light path starts at this light
  uint root;            // node
};
REGULUS_LAYOUT(GuidedLight, 8);
struct GuideNode {
  float first_share;  // of the lower half, in (0, 1)
  uint next;          // node of the lower half << GUIDE_AXIS_BITS | axis; the upper half's follows. GUIDE_LEAF: not halved
};
REGULUS_LAYOUT(GuideNode, 8);
REGULUS_CONSTANT GUIDE_LEAF = 0xFFFFFFFFu;
REGULUS_CONSTANT GUIDE_AXIS_BITS = 2u;
REGULUS_CONSTANT GUIDE_AXIS_MASK = 3u;
REGULUS_CONSTANT GUIDE_HALVINGS = 10u;                    // of one axis at most
REGULUS_CONSTANT GUIDE_DEPTH = 4u * GUIDE_HALVINGS + 1u;  // nodes on the way to a leaf, at most

// The guided camera walk: from where light comes (docs/mathematics.md 18). Its nodes, too, are GuideNodes, node 0 is the root.
// From there a vertex finds its cell: a node tells its halves apart by one of the three numbers of the place within the guide's
// bounds, or by whether a component of the unit normal is less than WALK_GUIDE_SIDE, or less than minus that. A cell has the share
// of the diffuse lobe's samples that go by the guide, and the root of a tree as above, over the two numbers of sample_sphere.
REGULUS_CONSTANT WALK_GUIDE_AXIS_BITS = 4u;
REGULUS_CONSTANT WALK_GUIDE_AXIS_MASK = 15u;
REGULUS_CONSTANT WALK_GUIDE_NORMALS = 3u;   // axes from here on: of the normal, less than WALK_GUIDE_SIDE
REGULUS_CONSTANT WALK_GUIDE_REVERSES = 6u;  // likewise, less than minus that
REGULUS_CONSTANT WALK_GUIDE_CELL = 15u;     // in an axis' place: a cell; next >> WALK_GUIDE_AXIS_BITS is its tree's root
REGULUS_CONSTANT WALK_GUIDE_DEPTH = 3u * GUIDE_HALVINGS + 7u;  // nodes on the way to a cell, at most
REGULUS_CONSTANT WALK_GUIDE_SIDE = 30u;     // percent: surfaces along axes are far from it

// The light tree: binary; the two nodes of a pair are siblings, pair 0 holds the root's children, and a leaf is a light. A
// light's trail tells its leaf: bit k is 1 where the way from the root takes the second node of its pair at depth k.
// Of each node:
// - place: bytes x, y, z, r from the lowest. The lights below it lie in a sphere whose centre is that of the parent's
//   sphere plus (x - 128, y - 128, z - 128) / 127 of the parent's radius, and whose radius is r / 255 of it.
// - normals: bytes x, y, z, s. Their normals end in a ball of radius 2 s / 255 around (x - 128, y - 128, z - 128) / 127.
struct LightPair {
  uint places[2];
  uint normals[2];
  uint children[2];   // pair of the node's children; LIGHT_PAIR_LEAF: the light
  float first_share;  // of the first node in the two's intensities (sum of the largest radiant intensities of lights)
  uint flags;         // LIGHT_PAIR_*
};
REGULUS_LAYOUT(LightPair, 32);
REGULUS_CONSTANT LIGHT_PAIR_LEAF = 1u << 31;     // of a child
REGULUS_CONSTANT LIGHT_PAIR_TWO_SIDED = 1u;      // << node: lights emit from both sides
REGULUS_CONSTANT LIGHT_PAIR_FIXED = 4u;          // the first node is chosen with probability first_share wherever from, for
                                                 // what is infinitely far away; the children's sphere is the parent's
REGULUS_CONSTANT MAX_LIGHT_TREE_DEPTH = 32u;     // pairs on the way to a leaf: the bits of a trail

// Where walks down the tree start: the sphere of the root.
struct LightTreeRoot {
  DeviceAddress pairs;
  DeviceAddress trails;  // word per light
  vec3 center;
  float radius;          // m
};
REGULUS_LAYOUT(LightTreeRoot, 32);

// A surface point as the choice of a light knows it.
struct LightReceiver {
  vec3 position;
  vec3 normal;  // geometric, on the lit side; zero if light may come from both sides
};
REGULUS_LAYOUT(LightReceiver, 24);

REGULUS_CONSTANT CAMERA_PERSPECTIVE = 0u;
REGULUS_CONSTANT CAMERA_ORTHOGRAPHIC = 1u;

// A camera for a given film size. Film coordinates: pixels, x right, y down, (0, 0) the top left corner of
// the top left pixel. Perspective: the ray direction through film point p is
// normalize(forward + (2 p.x / width - 1) * right + (1 - 2 p.y / height) * up), with `right` and `up`
// scaled by the tangents of the half field of view. Orthographic: the same vectors shift the origin.
struct Camera {
  vec3 position;
  uint kind;
  vec3 forward;  // unit
  float lens_radius;  // m; 0: pinhole
  vec3 right;
  float focus_distance;  // m, along forward
  vec3 up;
  float z_near, z_far;  // m along forward: nothing before or behind is seen. Only with FEATURE_CLIPPING
};
REGULUS_LAYOUT(Camera, 68);

REGULUS_INTERFACE_END

#endif
