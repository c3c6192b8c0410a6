// The frame that names the address of everything, and the arguments of stages.
#ifndef REGULUS_INTERFACE_FRAME_H
#define REGULUS_INTERFACE_FRAME_H

#include "scene.h"
#include "state.h"
#include "types.h"

REGULUS_INTERFACE_BEGIN

// Addresses and parameters of a render; 0 where it does not have something. Read through the push constant `frame`.
struct Frame {
  DeviceAddress bvh_nodes;       // with RAYS_HARDWARE the device's own structure in their place
  DeviceAddress bvh_triangles;
  DeviceAddress vertices;
  DeviceAddress vertex_colors;   // vec4 per vertex, linear RGBA; only with FEATURE_VERTEX_COLORS
  DeviceAddress vertex_uvs;      // vertex_uv_sets vec2 per vertex: further texture coordinates; only with FEATURE_UV_SETS
  DeviceAddress vertex_tangents; // vec4 per vertex: unit tangent, sign of the bitangent; only if a material needs them
  DeviceAddress triangles;
  DeviceAddress instances;        // only with FEATURE_INSTANCES
  DeviceAddress instance_blocks;  // with FEATURE_INSTANCES: the instance of each block of triangle numbers
  DeviceAddress materials;
  DeviceAddress textures;
  DeviceAddress lights;
  DeviceAddress light_aliases;
  LightTreeRoot light_tree;      // only with LIGHT_SAMPLING_BVH
  // Only with SPEC_LIGHT_GUIDE.
  DeviceAddress guided_lights;         // GuidedLight per light
  DeviceAddress guided_light_aliases;  // by which light paths choose one
  DeviceAddress guide_nodes;
  // Only with SPEC_WALK_GUIDE.
  DeviceAddress walk_guide_nodes;
  DeviceAddress environment_texels;  // vec3, row by row; only with a map
  DeviceAddress environment_cdf;     // see Environment; only with a map
  DeviceAddress energy_tables;  // see lib/energy.glsl
  DeviceAddress sheen_table;    // float, see interface/sheen.h; only with FEATURE_SHEEN
  DeviceAddress wavelengths;    // Wavelength; only with FEATURE_DISPERSION
  // Only with FEATURE_CONTACTS.
  DeviceAddress solids;               // Solid
  DeviceAddress media_sets;           // MediaSet; the first is empty: outside of all solids
  DeviceAddress light_media;          // per light: index of its MediaSet, or MEDIA_VARY
  // The wavefront's own arrays.
#define STATE(name, element, times, per, when) DeviceAddress name;
#include "state_table.h"
#undef STATE
  uint width, height;
  uvec4 crop;           // pixels that are rendered and that the films hold: x, y of the first, width, height
  uint light_count;
  uint seed;
  uint max_depth;       // path edges
  uint wave_capacity;   // path slots
  float filter_radius;  // pixels
  float filter_sigma;   // pixels, Gaussian only
  vec3 scene_center;
  float scene_radius;   // m, of the bounding sphere
  Camera camera;
  Environment environment;
  vec3 walk_guide_corner;      // only with SPEC_WALK_GUIDE: of the guide's bounds
  vec3 walk_guide_scale;       // 1/m: numbers of a place are (position - corner) scale
  uint light_path_count;       // per iteration: N
  uint light_head_modulus;     // pixel p connects to light path p modulo this; 0: to the one of its own slot
  uint light_vertex_capacity;
  uint pair_capacity;          // connection pairs per class
  uint cache_connections;      // light vertices each camera vertex connects to, drawn from all; 0: its own path's
  uint grid_cell_mask;         // number of cells - 1
  float cache_connect_count;   // connections of a cache of the expected size: M N / vertices. Walks need it in their MIS
                               // accumulators before the vertices are counted
  float tau;                   // bound on the density of a regularized lobe, 1/sr
  float largest_contribution;  // with SPEC_CLAMP: what one technique adds to one sample, at most, in any channel
  float shadow_roulette;       // with SPEC_SHADOW_ROULETTE: segments that carry less in every channel play roulette
  uint stored_triangles;       // numbers from here on are those of instances
  uint instance_block_shift;   // number (behind stored_triangles) >> this: the block
  uint vertex_uv_sets;
  uint layer_count;            // films in layer_film, without those of splats
  uvec4 kind_layers;           // the layer of each kind of light, LIGHT_*, or INVALID_INDEX
  uint first_group_layer;      // those of groups follow; INVALID_INDEX: there are none
  uint camera_media;           // with FEATURE_CONTACTS: index of the MediaSet where camera rays start, or MEDIA_VARY
  uint lens_medium;            // with FEATURE_CONTACTS: material of the medium from the lens to the near plane, or INVALID_INDEX
  // Only with RAYS_HARDWARE: which stored triangles the device's structure holds beside those of copies.
  DeviceAddress placed_triangles;    // with FEATURE_ALPHA: the index of each, first of those without holes
  uint whole_placed_triangles;       // with FEATURE_ALPHA: how many have none
  uint first_placed_triangle;        // without: the index of the first
};
REGULUS_LAYOUT(Frame, 912);

// Push constants of every stage.
struct StageArguments {
  DeviceAddress frame;
  uint bounce;
  uint wave_paths;     // paths of this wave
  uint first_pixel;    // film index (within the crop), or light path, of the wave's first path
  uint first_sample;   // and its sample index
  float merge_radius;  // m, of this iteration
  uint is_repeated;    // light walks: 1 if their splats are on the film already
  uint counted_pass;   // count_work: COUNTED_*
  uint surface_ray;    // surface_aovs: number of the ray of each pixel
  uint merge_turn;     // merge: which of its turns of MERGE_ROUND_LENGTH a vertex takes
  uint first_item;     // connect, trace_visibility: place in the queue of the first item of this dispatch
  uint merge_first;    // merge: the units [merge_first, merge_first + merge_units) of the bounce, or with no units every
  uint merge_units;    // vertex's first turn
};
REGULUS_LAYOUT(StageArguments, 56);

// Words summed by one invocation of a scan.
REGULUS_CONSTANT SCAN_FAN = 64u;

// Push constants of the scan stages: offsets and counts in words.
struct ScanArguments {
  DeviceAddress words;
  uint source;
  uint count;
  uint sums;  // INVALID_INDEX: the level is scanned by one invocation
};
REGULUS_LAYOUT(ScanArguments, 20);

REGULUS_INTERFACE_END

#endif
