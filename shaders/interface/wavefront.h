// What the stages hand to each other: path states, candidates, queues, and the frame that names the
// address of everything. Random numbers are a function of (seed, pixel, sample, dimension), never of a
// path's place in a queue.
#ifndef REGULUS_INTERFACE_WAVEFRONT_H
#define REGULUS_INTERFACE_WAVEFRONT_H

#include "bvh.h"
#include "scene.h"
#include "types.h"

REGULUS_INTERFACE_BEGIN

// Specialization constant ids, shared by all stages.
REGULUS_CONSTANT SPEC_NDF = 1u;             // NDF_*
REGULUS_CONSTANT SPEC_SHADOWING = 2u;       // SHADOWING_*
REGULUS_CONSTANT SPEC_MATERIAL_CLASS = 3u;  // MATERIAL_CLASS_* the pipeline serves
REGULUS_CONSTANT SPEC_FEATURES = 4u;        // FEATURE_* the scene has
REGULUS_CONSTANT SPEC_TECHNIQUES = 5u;      // TECHNIQUE_* that are enabled
REGULUS_CONSTANT SPEC_FILTER = 6u;          // FILTER_*
REGULUS_CONSTANT SPEC_SAMPLER = 7u;         // SAMPLER_*
REGULUS_CONSTANT SPEC_REGULARIZATION = 8u;  // REGULARIZATION_* bits
REGULUS_CONSTANT SPEC_BOUND = 9u;           // BOUND_*
REGULUS_CONSTANT SPEC_MIS = 10u;             // MIS_*
REGULUS_CONSTANT SPEC_WALK = 11u;            // WALK_*: whose paths the stage moves
REGULUS_CONSTANT SPEC_SAMPLER_QUALITY = 12u; // SAMPLER_QUALITY_*
REGULUS_CONSTANT SPEC_CLAMP = 13u;           // 1: no contribution exceeds Frame.largest_contribution
REGULUS_CONSTANT SPEC_CROP = 14u;            // 1: only the pixels of Frame.crop are rendered
REGULUS_CONSTANT SPEC_ENERGY_COMPENSATION = 15u;  // 1: microfacet lobes lose no light, see lib/energy.glsl
REGULUS_CONSTANT SPEC_LIGHT_SAMPLING = 16u;  // LIGHT_SAMPLING_*
REGULUS_CONSTANT SPEC_STRATEGIES = 17u;      // 1: each strategy has images of its own (lib/strategies.glsl)
REGULUS_CONSTANT SPEC_FILM_EXPONENT = 18u;    // of the unit of the film's sums, signed
REGULUS_CONSTANT SPEC_SQUARE_EXPONENT = 19u;  // of the unit of its sums of squares, signed
REGULUS_CONSTANT SPEC_RAYS = 20u;             // RAYS_*: who has traced the segments of candidates

// Who traces rays.
REGULUS_CONSTANT RAYS_SOFTWARE = 0u;  // kernels (lib/traversal.glsl)
REGULUS_CONSTANT RAYS_HOST = 1u;      // host code, in the memory of a software device; blocked segments get a negative t_max
REGULUS_CONSTANT RAYS_AUTO = 2u;      // decided before kernels are built: no kernel sees it

// How next-event estimation chooses a light. Light paths always start by power.
REGULUS_CONSTANT LIGHT_SAMPLING_POWER = 0u;
REGULUS_CONSTANT LIGHT_SAMPLING_BVH = 1u;      // by what each can send to the surface (lib/light_tree.glsl)
REGULUS_CONSTANT LIGHT_SAMPLING_UNIFORM = 2u;
REGULUS_CONSTANT LIGHT_SAMPLING_AUTO = 3u;     // chosen before kernels are built: no kernel sees it

REGULUS_CONSTANT WALK_CAMERA = 0u;
REGULUS_CONSTANT WALK_LIGHT = 1u;

REGULUS_CONSTANT NDF_GGX = 0u;
REGULUS_CONSTANT NDF_BECKMANN = 1u;
REGULUS_CONSTANT NDF_COSINE = 2u;
REGULUS_CONSTANT SHADOWING_SMITH = 0u;               // height-correlated
REGULUS_CONSTANT SHADOWING_SMITH_UNCORRELATED = 1u;  // G1(i) G1(o)
REGULUS_CONSTANT SHADOWING_V_CAVITY = 2u;

REGULUS_CONSTANT FILTER_BOX = 0u;
REGULUS_CONSTANT FILTER_GAUSSIAN = 1u;
REGULUS_CONSTANT FILTER_BLACKMAN_HARRIS = 2u;

REGULUS_CONSTANT SAMPLER_SOBOL = 0u;  // Owen-scrambled Sobol points
REGULUS_CONSTANT SAMPLER_HASH = 1u;   // independent numbers

// Regularization at connections and merges (lib/regularization.glsl).
REGULUS_CONSTANT REGULARIZATION_NONE = 0u;
REGULUS_CONSTANT REGULARIZATION_ROUGHNESS = 1u;   // bsdfs are evaluated with raised roughness
REGULUS_CONSTANT REGULARIZATION_CONSISTENT = 2u;  // which shrinks from iteration to iteration
REGULUS_CONSTANT REGULARIZATION_VIRTUAL_MERGE = 4u;  // with ROUGHNESS, whose lobes then serve the weights alone: the
                                                    // value is what the lobe sends into a cone around the direction
REGULUS_CONSTANT REGULARIZATION_BOTH = 8u;           // with ROUGHNESS: beside the unregularized techniques
REGULUS_CONSTANT REGULARIZATION_DIFFUSION = 16u;     // with ROUGHNESS: by path diffusion, what is seen sharply is left alone
REGULUS_CONSTANT SAMPLER_QUALITY_OFF = 0u;
REGULUS_CONSTANT SAMPLER_QUALITY_ON = 1u;      // paths that some technique samples well are not regularized
REGULUS_CONSTANT SAMPLER_QUALITY_SMOOTH = 2u;  // with a smooth transition
REGULUS_CONSTANT BOUND_PEAK = 0u;
REGULUS_CONSTANT BOUND_SMITH = 1u;
REGULUS_CONSTANT BOUND_DIRECTIONAL = 2u;
REGULUS_CONSTANT MIS_BLENDED = 0u;
REGULUS_CONSTANT MIS_CORRECTED = 1u;
REGULUS_CONSTANT MIS_UNMODIFIED = 2u;

// Scene features: a clear bit compiles the code it names away.
REGULUS_CONSTANT FEATURE_TEXTURES = 1u;            // any texture that shading reads
REGULUS_CONSTANT FEATURE_TRIANGLE_LIGHTS = 2u;
REGULUS_CONSTANT FEATURE_POINT_LIGHTS = 4u;        // point or spot
REGULUS_CONSTANT FEATURE_DIRECTIONAL_LIGHTS = 8u;
REGULUS_CONSTANT FEATURE_ROUGH_SPECULAR = 16u;     // some microfacet lobe has alpha > 0
REGULUS_CONSTANT FEATURE_DELTA_SPECULAR = 32u;     // some microfacet lobe has alpha == 0
REGULUS_CONSTANT FEATURE_ABSORPTION = 64u;         // some volume attenuates
REGULUS_CONSTANT FEATURE_MANY_LIGHTS = 128u;       // more than one light: the alias table is read
REGULUS_CONSTANT FEATURE_SMOOTH_NORMALS = 256u;    // some triangle's normals differ from its geometric normal
REGULUS_CONSTANT FEATURE_TWO_SIDED_LIGHTS = 512u;  // some emissive triangle emits from both faces
REGULUS_CONSTANT FEATURE_CLIPPING = 1u << 12;      // some camera has a clipping plane that hides something
REGULUS_CONSTANT FEATURE_LIGHT_RANGES = 1u << 13;  // some point or spot light ends at a distance; implies POINT_LIGHTS
REGULUS_CONSTANT FEATURE_SHEEN = 1u << 14;         // some material has sheen
REGULUS_CONSTANT FEATURE_VERTEX_COLORS = 1u << 16;  // some vertex has a colour
REGULUS_CONSTANT FEATURE_NORMAL_MAPS = 1u << 17;    // some material has a normal map; implies SMOOTH_NORMALS, TEXTURES
REGULUS_CONSTANT FEATURE_ENVIRONMENT = 1024u;      // light from all directions
REGULUS_CONSTANT FEATURE_ENVIRONMENT_MAP = 2048u;  // that differs between them
REGULUS_CONSTANT FEATURE_ALPHA = 1u << 18;          // some surface is masked or blended
REGULUS_CONSTANT FEATURE_CLEARCOAT = 1u << 19;      // some material has a clearcoat
REGULUS_CONSTANT FEATURE_ANISOTROPY = 1u << 20;     // some material is anisotropic
REGULUS_CONSTANT FEATURE_TEXTURE_MAPPINGS = 1u << 21;   // some texture is TEXTURE_MAPPED
REGULUS_CONSTANT FEATURE_UV_SETS = 1u << 22;            // some texture reads further coordinates of the vertices
REGULUS_CONSTANT FEATURE_SPECULAR_TEXTURES = 1u << 23;  // some material's specular reflection is textured
REGULUS_CONSTANT FEATURE_WIDE_TEXELS = 1u << 30;        // some texture is TEXTURE_UNORM16 or TEXTURE_HALF
REGULUS_CONSTANT FEATURE_INSTANCES = 1u << 24;          // some mesh is stored once for several copies
REGULUS_CONSTANT FEATURE_COAT_NORMALS = 1u << 25;       // some material has MATERIAL_COAT_NORMAL; implies CLEARCOAT
REGULUS_CONSTANT FEATURE_BULGES = 1u << 27;             // some triangle's vertex normals spread: it stands for a curved surface
REGULUS_CONSTANT FEATURE_ROUGH_BASE = 1u << 26;         // some diffuse base lies under a rough dielectric interface
REGULUS_CONSTANT FEATURE_CONTACTS = 1u << 28;           // solids nest, touch or hold a camera or a light; surfaces coincide

// Techniques (docs/architecture.md).
REGULUS_CONSTANT TECHNIQUE_HIT = 1u;
REGULUS_CONSTANT TECHNIQUE_NEE = 2u;
REGULUS_CONSTANT TECHNIQUE_SPLAT = 4u;
REGULUS_CONSTANT TECHNIQUE_CONNECT = 8u;
REGULUS_CONSTANT TECHNIQUE_MERGE = 16u;

// Dimensions of the random sequence. One block is four numbers; a path uses block CAMERA once and the
// others once per bounce: block index = DIMENSION_BLOCKS_FIRST + bounce * DIMENSION_BLOCKS_PER_BOUNCE + k.
REGULUS_CONSTANT DIMENSION_BLOCK_CAMERA = 0u;         // film x, film y, lens u, lens v
REGULUS_CONSTANT DIMENSION_BLOCKS_FIRST = 1u;
// light, alias (light tree: more digits of the light), position u, position v (environment: direction)
REGULUS_CONSTANT DIMENSION_BLOCK_LIGHT = 0u;
REGULUS_CONSTANT DIMENSION_BLOCK_BSDF = 1u;           // lobe, direction u, direction v, roulette
REGULUS_CONSTANT DIMENSION_BLOCKS_PER_BOUNCE = 2u;
// Light path k of iteration i draws random_block(seed, k, i, block): blocks of its own, beyond every bounce's.
REGULUS_CONSTANT DIMENSION_BLOCK_EMISSION = 1u << 16;  // light, alias, position u, position v
// direction u, v (environment: place on the scene's disk), lens u, v
REGULUS_CONSTANT DIMENSION_BLOCK_EMISSION_DIRECTION = DIMENSION_BLOCK_EMISSION + 1u;
REGULUS_CONSTANT DIMENSION_BLOCK_LIGHT_BSDF = DIMENSION_BLOCK_EMISSION + 2u;  // + bounce: as DIMENSION_BLOCK_BSDF
REGULUS_CONSTANT DIMENSION_BLOCK_SPLAT = DIMENSION_BLOCK_EMISSION + 4096u;  // + edges: lens u, lens v, unused
// Connections to the cache draw one number each: block + bounce * 256 + k / 4.
REGULUS_CONSTANT DIMENSION_BLOCK_CACHE = 1u << 20;
// Virtual merges draw independent numbers, whatever the sampler (see virtual_merge_seed): block + VIRTUAL_MERGE_*.
REGULUS_CONSTANT DIMENSION_BLOCK_VIRTUAL_MERGE = 1u << 24;
REGULUS_CONSTANT VIRTUAL_MERGE_AT_CAMERA = 0u;  // the camera vertex of a connection or light sample
REGULUS_CONSTANT VIRTUAL_MERGE_AT_LIGHT = 1u;   // the light vertex of a connection or splat
REGULUS_CONSTANT VIRTUAL_MERGE_AT_MERGE = 2u;
REGULUS_CONSTANT VIRTUAL_MERGE_TRIES = 4u;      // stratified in the choice of the event

// State of a path between stages: the ray to trace next and what it carries. Camera and light paths alike.
struct Path {
  vec3 origin;
  float mis_a;       // see lib/mis.glsl: what MIS keeps of the walk, before the distance of the ray is known
  vec3 direction;    // unit
  uint pixel;        // camera path: y * width + x on the whole film, and PATH_DIFFUSED; light path: its index in the iteration
  vec3 throughput;
  uint sample_index; // of the pixel; light path: the iteration, which is the same number
  float eta_scale;   // camera path: product of (eta_i / eta_t)^2 so far, undone in Russian roulette
                     // light path: 1 if it starts at an infinitely distant light, otherwise 0
  uint bounce;       // path edges before this ray
  uint medium;       // material whose absorption the ray passes through, or INVALID_INDEX
  float mis_b;
};
REGULUS_LAYOUT(Path, 64);

// Set once a camera path has scattered at a surface that is not sharp (lib/regularization.glsl).
REGULUS_CONSTANT PATH_DIFFUSED = 1u << 31;
REGULUS_CONSTANT PATH_PIXEL = PATH_DIFFUSED - 1u;

// A vertex of a subpath as connections and merges need it: where it is, where the walk came from, what it
// carries on arrival (the bsdf here not included), and the accumulators of MIS (lib/mis.glsl).
struct PathVertex {
  vec3 position;
  uint link;          // light vertex: the one before it on its path, or INVALID_INDEX; camera vertex: medium of
                      // the edge that arrives
  vec3 direction;     // unit, towards the previous vertex of the walk
  uint triangle;
  vec3 throughput;
  float mis_a;
  vec2 barycentrics;
  float mis_b;
  uint edges;         // PATH_VERTEX_EDGES: path edges from the walk's start to here; above them MATERIAL_CLASS_*, and
                      // of a light vertex the last bits of its light path's index
};
REGULUS_LAYOUT(PathVertex, 64);
REGULUS_CONSTANT PATH_VERTEX_EDGES = 0xFFFFu;
REGULUS_CONSTANT PATH_VERTEX_CLASS_SHIFT = 16u;
REGULUS_CONSTANT PATH_VERTEX_CLASS_MASK = 3u;
REGULUS_CONSTANT PATH_VERTEX_STREAM_SHIFT = 18u;
REGULUS_CONSTANT PATH_VERTEX_STREAM_MASK = 0xFFFu;
REGULUS_CONSTANT PATH_VERTEX_DIFFUSED = 1u << 30;  // camera vertex: PATH_DIFFUSED on arrival

// Where the ray of a path or a segment starts, only with FEATURE_CONTACTS: the solids around it, and the surface point that it
// leaves.
struct PathMedia {
  MediaSet around;
  vec2 barycentrics;
  uint triangle;  // its number; INVALID_INDEX: it leaves no surface
  uint solid;     // whose boundary that is, or INVALID_INDEX
};
REGULUS_LAYOUT(PathMedia, 48);

// The vertices of one light path: the last one stored, from which the others follow by `link`.
struct LightPathHead {
  uint last;
  uint count;
};
REGULUS_LAYOUT(LightPathHead, 8);

// A vertex of the merge grid: light vertices in the order of their cells.
struct GridEntry {
  vec3 position;
  uint vertex;
};
REGULUS_LAYOUT(GridEntry, 16);

// What sampler quality and `both` know of a subpath beside Path or PathVertex (lib/history.glsl). In a path
// between stages `plain` and `pending` do not know the length of the ray yet.
struct PathHistory {
  vec2 plain;         // accumulators (A, B) of the unregularized weights
  float worst;        // least bound of a finished technique's estimator, times the squared length of the path, 1/m^2
  float pending;      // rho-bar of the last vertex over the squared length of the edge that leads on
  float distance;     // m, along the subpath
  float ratio;        // rho^W / rho of the last vertex
  float sharp_ratio;  // the same for a camera that has not diffused
};
REGULUS_LAYOUT(PathHistory, 28);

// A contribution that counts if its segment is unoccluded.
struct VisibilityCandidate {
  vec3 origin;
  float t_max;
  vec3 direction;  // unit
  uint path;       // slot whose radiance receives it; with connections the index in the film
  vec3 contribution;
};
REGULUS_LAYOUT(VisibilityCandidate, 44);

// A light vertex that the lens may see.
struct SplatCandidate {
  VisibilityCandidate segment;  // `path` is not used
  vec2 film;                    // pixels, see Camera
};
REGULUS_LAYOUT(SplatCandidate, 52);

// Of a visibility or splat candidate: whose it is, and its contribution without the weight.
struct StrategyCandidate {
  vec3 unweighted;
  uint layer;  // of the strategy's images, or INVALID_INDEX
};
REGULUS_LAYOUT(StrategyCandidate, 16);

// A camera vertex and a light vertex to connect.
struct ConnectionPair {
  uint slot;    // of the camera path
  uint vertex;  // light vertex
};
REGULUS_LAYOUT(ConnectionPair, 8);

// Head of a queue: an indirect dispatch command followed by the number of items. Producers raise `groups_x`
// with every WORKGROUP_SIZE-th item, so the queue can be dispatched without a stage in between.
struct QueueHead {
  uint groups_x, groups_y, groups_z;
  uint count;
};
REGULUS_LAYOUT(QueueHead, 16);

REGULUS_CONSTANT WORKGROUP_SIZE = 64u;

// Path edges before Russian roulette starts: the first indirect bounces carry most of the light.
REGULUS_CONSTANT ROULETTE_FIRST_BOUNCE = 2u;

// Queues of one bounce; head index = bounce * QUEUES_PER_BOUNCE + QUEUE_*.
REGULUS_CONSTANT QUEUE_RAYS = 0u;        // path slots to trace
REGULUS_CONSTANT QUEUE_VISIBILITY = 1u;  // candidates
REGULUS_CONSTANT QUEUE_BOUNCE = 2u;      // + material class: path slots that hit it
REGULUS_CONSTANT QUEUE_PAIRS = 5u;       // + the more general of the two vertices' classes: connection pairs
REGULUS_CONSTANT QUEUE_SPLATS = 8u;      // splat candidates
REGULUS_CONSTANT QUEUE_ESCAPED = 9u;     // path slots whose ray hit nothing
REGULUS_CONSTANT QUEUES_PER_BOUNCE = 10u;

// Film: per pixel three channels of three words, low first: a fixed-point sum in units of
// 2^(exponent - FILM_FRACTION_BITS), the exponent being the scene's (SPEC_FILM_EXPONENT; 0 for ordinary light). A sum
// with FILM_SATURATED in its highest word is too large to be held, 2^(exponent + FILM_RANGE_BITS) or more.
REGULUS_CONSTANT FILM_WORDS_PER_PIXEL = 9u;
REGULUS_CONSTANT FILM_FRACTION_BITS = 40u;
REGULUS_CONSTANT FILM_RANGE_BITS = 55u;
REGULUS_CONSTANT FILM_SATURATED = 1u << 31;

// What camera rays meet first. Albedo and normals are means over AOV_RAYS rays as the
// first samples of the pixel send them, black where they meet nothing; the rest is what the ray from the middle of the
// lens through the middle of the pixel meets. Normals are unit before the mean and on the side of the camera.
struct AovPixel {
  vec3 albedo;
  float depth;    // m along the camera's axis; infinite if the ray meets nothing
  vec3 shading_normal;
  uint material;  // index, or INVALID_INDEX
  vec3 geometric_normal;
  uint instance;  // Triangle.instance, or INVALID_INDEX
  vec3 position;  // world space; 0 if the ray meets nothing
  uint reserved;
};
REGULUS_LAYOUT(AovPixel, 64);
REGULUS_CONSTANT AOV_RAYS = 16u;

// Addresses and parameters of a render. Read through the push constant `frame`.
struct Frame {
  DeviceAddress bvh_nodes;
  DeviceAddress bvh_triangles;
  DeviceAddress vertices;
  DeviceAddress vertex_colors;   // vec4 per vertex, linear RGBA; only with FEATURE_VERTEX_COLORS
  DeviceAddress vertex_uvs;      // vertex_uv_sets vec2 per vertex: further texture coordinates; only with FEATURE_UV_SETS
  DeviceAddress vertex_tangents; // vec4 per vertex: unit tangent, sign of the bitangent; only if a material needs them
  DeviceAddress triangles;
  DeviceAddress instances;        // only with FEATURE_INSTANCES
  DeviceAddress instance_blocks;  // with it: the instance of each block of numbers of triangles
  DeviceAddress materials;
  DeviceAddress textures;
  DeviceAddress lights;
  DeviceAddress light_aliases;
  LightTreeRoot light_tree;      // only with LIGHT_SAMPLING_BVH
  DeviceAddress light_receivers; // with it, hit and nee: LightReceiver per path slot, the vertex before the ray
  DeviceAddress paths;
  DeviceAddress hits;
  DeviceAddress radiance;        // vec3 per path slot
  DeviceAddress ray_queues;      // two lists of path slots, used in turns by bounce parity
  DeviceAddress bounce_queues;   // one list per material class
  DeviceAddress candidates;
  DeviceAddress queue_heads;
  DeviceAddress film;
  DeviceAddress counters;
  // Only with light subpaths; 0 otherwise.
  DeviceAddress splat_film;          // as `film`, sums of technique `splat`
  DeviceAddress splats;              // splat candidates
  DeviceAddress light_vertices;      // of the light paths at hand
  DeviceAddress light_heads;         // LightPathHead per light path
  DeviceAddress light_vertex_count;  // LIGHT_COUNT_* words; may exceed light_vertex_capacity, what does not fit is not stored
  DeviceAddress camera_vertices;     // PathVertex per path slot
  DeviceAddress pairs;               // one list per material class
  DeviceAddress light_path_ends;     // connections to the cache: exclusive scan of LightPathHead.count
  DeviceAddress grid_cells;          // first entry of each cell, and one past the last cell
  DeviceAddress grid_ranks;          // place of each light vertex in its cell
  DeviceAddress grid_entries;
  DeviceAddress merge_starts;        // per path slot: the first of its merge's units, where a bounce's merges are counted
  // Only with regularization: accumulators (A, B) for a camera that sees the vertex sharply (lib/mis.glsl).
  DeviceAddress light_path_sharp;    // vec2 per path slot
  DeviceAddress light_vertex_sharp;  // vec2 per light vertex
  // Only with an environment light.
  DeviceAddress escaped;             // path slots
  DeviceAddress environment_texels;  // vec3, row by row; only with a map
  DeviceAddress environment_cdf;     // see Environment; only with a map
  // Only with sampler quality or `both`: PathHistory
  DeviceAddress path_histories;          // per path slot
  DeviceAddress camera_vertex_histories;  // per path slot
  DeviceAddress light_vertex_histories;  // per light vertex
  DeviceAddress path_footprints;         // vec3 per path slot (lib/footprint.glsl); only with path diffusion, without
                                         // light subpaths
  // Only if they are asked for.
  DeviceAddress aovs;           // AovPixel per pixel
  DeviceAddress film_earlier;   // `film` and `splat_film` together, as they were after the last whole sample
  DeviceAddress film_squares;   // as `film`, sums of the squares of whole samples
  DeviceAddress energy_tables;  // see lib/energy.glsl
  DeviceAddress sheen_table;    // float, see interface/sheen.h; only with FEATURE_SHEEN
  // Only with images of strategies (lib/strategies.glsl).
  DeviceAddress strategy_film;         // per strategy two films as `film`, weighted and not
  DeviceAddress strategy_layers;       // per edges of a path, s, and whether it is a merge: the number of the strategy
  DeviceAddress candidate_strategies;  // StrategyCandidate per visibility candidate
  DeviceAddress splat_strategies;      // and per splat candidate
  // Only with FEATURE_CONTACTS.
  DeviceAddress solids;               // Solid
  DeviceAddress media_sets;           // MediaSet: the first is that outside of all solids
  DeviceAddress light_media;          // per light: index of its MediaSet, or MEDIA_VARY
  DeviceAddress path_media;           // PathMedia per path slot
  DeviceAddress camera_vertex_media;  // MediaSet per path slot: on the side that the path arrived from
  DeviceAddress light_vertex_media;   // and per light vertex
  DeviceAddress candidate_media;      // PathMedia per visibility candidate
  DeviceAddress splat_media;          // and per splat candidate
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
  uint light_path_count;       // per iteration: N
  uint light_head_modulus;     // pixel p connects to light path p modulo this; 0: to the one of its own slot
  uint light_vertex_capacity;
  uint pair_capacity;          // connection pairs per class
  uint cache_connections;      // light vertices each camera vertex connects to, drawn from all; 0: its own path's
  uint grid_cell_mask;         // number of cells - 1
  float cache_connect_count;   // of a cache whose size is the expected one: M N / vertices. Walks need it in their MIS
                               // accumulators before the vertices are counted
  float tau;                   // bound on the density of a regularized lobe, 1/sr
  float largest_contribution;  // with SPEC_CLAMP: what one technique adds to one sample, at most, in any channel
  uint stored_triangles;       // numbers from here on are those of instances
  uint instance_block_shift;   // number (behind stored_triangles) >> this: the block
  uint vertex_uv_sets;
  uint camera_media;           // with FEATURE_CONTACTS: index of the MediaSet where camera rays start, or MEDIA_VARY
  uint lens_medium;            // with FEATURE_CONTACTS: material of the medium from the lens to the near plane, or INVALID_INDEX
};
REGULUS_LAYOUT(Frame, 740);

// Push constants of every stage.
struct StageArguments {
  DeviceAddress frame;
  uint bounce;
  uint wave_paths;     // paths of this wave
  uint first_pixel;    // film index (within the crop), or light path, of the wave's first path
  uint first_sample;   // and its sample index
  float merge_radius;  // m, of this iteration
  uint round;          // merge: which of its turns of MERGE_ROUND_LENGTH a vertex takes; light walks: 1 if they are
                       // repeated and their splats are on the film already; count_work: the pass; surface_aovs: the ray
  uint first_item;     // connect, trace_visibility: place in the queue of the first item of this dispatch
  uint merge_first;    // merge: the units [merge_first, merge_first + merge_units) of the bounce, or with no units every
  uint merge_units;    // vertex's first turn
};
REGULUS_LAYOUT(StageArguments, 44);

// Light vertices that one merge invocation looks at: an invocation may not loop longer than 65,535 times on
// stock lavapipe.
REGULUS_CONSTANT MERGE_ROUND_LENGTH = 32768u;
// Where the merges of a bounce are counted, that many light vertices to look at count as one. Each vertex's begin with a
// unit of their own.
REGULUS_CONSTANT MERGE_UNIT = 64u;

// Words of Frame.light_vertex_count.
REGULUS_CONSTANT LIGHT_COUNT_VERTICES = 0u;  // of the light paths at hand
REGULUS_CONSTANT LIGHT_COUNT_CROWD = 1u;     // light vertices in the most crowded cell of the grid, if that is crowded
REGULUS_CONSTANT LIGHT_COUNT_UNITS = 2u;     // of the bounce's merges, where they are counted
REGULUS_CONSTANT LIGHT_COUNT_WORDS = 3u;
// A cell with as many light vertices is crowded.
REGULUS_CONSTANT CROWDED_CELL = 16u;
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

// Counters of a render: 64 bits each as (low, high) words. First things that should not happen, then the
// items that went through each queue, of camera passes and of light passes.
REGULUS_CONSTANT COUNTER_NON_FINITE = 0u;         // samples dropped because NaN, infinite or negative
REGULUS_CONSTANT COUNTER_TRAVERSAL_OVERRUN = 1u;  // rays whose traversal hit its step bound
REGULUS_CONSTANT COUNTER_MEDIA_OVERFLOW = 2u;     // solids that paths have forgotten: more than MEDIA_SET_SIZE at once
REGULUS_CONSTANT COUNTER_QUEUE_ITEMS = 3u;        // + pass * QUEUES_PER_BOUNCE + QUEUE_*
REGULUS_CONSTANT COUNTER_COUNT = COUNTER_QUEUE_ITEMS + 2u * QUEUES_PER_BOUNCE;

// StageArguments.round of count_work: which pass it counts.
REGULUS_CONSTANT COUNTED_CAMERA_PASS = 0u;
REGULUS_CONSTANT COUNTED_LIGHT_PASS = 1u;

REGULUS_INTERFACE_END

#endif
