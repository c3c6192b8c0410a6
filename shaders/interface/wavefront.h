// What the stages hand to each other: path states, candidates, queues, and the frame that names the
// address of everything. Random numbers are a function of (seed, pixel, sample, dimension), never of a
// path's place in a queue (design.md section 5).
#ifndef REGULUS_INTERFACE_WAVEFRONT_H
#define REGULUS_INTERFACE_WAVEFRONT_H

#include "bvh.h"
#include "scene.h"
#include "types.h"

REGULUS_INTERFACE_BEGIN

// Specialization constant ids, shared by all stages.
REGULUS_CONSTANT SPEC_WORKGROUP_SIZE = 0u;
REGULUS_CONSTANT SPEC_NDF = 1u;             // NDF_*
REGULUS_CONSTANT SPEC_SHADOWING = 2u;       // SHADOWING_*
REGULUS_CONSTANT SPEC_MATERIAL_CLASS = 3u;  // MATERIAL_CLASS_* the pipeline serves
REGULUS_CONSTANT SPEC_FEATURES = 4u;        // FEATURE_* the scene has
REGULUS_CONSTANT SPEC_TECHNIQUES = 5u;      // TECHNIQUE_* that are enabled
REGULUS_CONSTANT SPEC_FILTER = 6u;          // FILTER_*
REGULUS_CONSTANT SPEC_SAMPLER = 7u;         // SAMPLER_*

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

// Techniques (design.md section 1).
REGULUS_CONSTANT TECHNIQUE_HIT = 1u;
REGULUS_CONSTANT TECHNIQUE_NEE = 2u;
REGULUS_CONSTANT TECHNIQUE_SPLAT = 4u;
REGULUS_CONSTANT TECHNIQUE_CONNECT = 8u;
REGULUS_CONSTANT TECHNIQUE_MERGE = 16u;

// Dimensions of the random sequence. One block is four numbers; a path uses block CAMERA once and the
// others once per bounce: block index = DIMENSION_BLOCKS_FIRST + bounce * DIMENSION_BLOCKS_PER_BOUNCE + k.
REGULUS_CONSTANT DIMENSION_BLOCK_CAMERA = 0u;         // film x, film y, lens u, lens v
REGULUS_CONSTANT DIMENSION_BLOCKS_FIRST = 1u;
REGULUS_CONSTANT DIMENSION_BLOCK_LIGHT = 0u;          // light, alias, position u, position v
REGULUS_CONSTANT DIMENSION_BLOCK_BSDF = 1u;           // lobe, direction u, direction v, roulette
REGULUS_CONSTANT DIMENSION_BLOCKS_PER_BOUNCE = 2u;
// Light path k of iteration i draws random_block(seed, k, i, block): blocks of its own, beyond every bounce's.
REGULUS_CONSTANT DIMENSION_BLOCK_EMISSION = 1u << 16;  // light, alias, position u, position v
REGULUS_CONSTANT DIMENSION_BLOCK_EMISSION_DIRECTION = DIMENSION_BLOCK_EMISSION + 1u;  // direction u, v, unused
REGULUS_CONSTANT DIMENSION_BLOCK_LIGHT_BSDF = DIMENSION_BLOCK_EMISSION + 2u;  // + bounce: as DIMENSION_BLOCK_BSDF

// State of a camera path between stages: the ray to trace next and what it carries.
struct Path {
  vec3 origin;
  float pdf;         // solid-angle pdf of `direction` (the bsdf's); 0: delta event or camera ray
  vec3 direction;    // unit
  uint pixel;        // film index, y * width + x
  vec3 throughput;
  uint sample_index;
  float eta_scale;   // product of (eta_i / eta_t)^2 so far, undone in Russian roulette
  uint bounce;       // path edges before this ray
  uint medium;       // material whose absorption the ray passes through, or INVALID_INDEX
  uint reserved;
};
REGULUS_LAYOUT(Path, 64);

// A contribution that counts if its segment is unoccluded.
struct VisibilityCandidate {
  vec3 origin;
  float t_max;
  vec3 direction;  // unit
  uint path;       // slot whose radiance receives it
  vec3 contribution;
};
REGULUS_LAYOUT(VisibilityCandidate, 44);

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
REGULUS_CONSTANT QUEUES_PER_BOUNCE = 5u;

// Film: per pixel three channels of three words, a fixed-point sum in units of 2^-FILM_FRACTION_BITS.
REGULUS_CONSTANT FILM_WORDS_PER_PIXEL = 9u;
REGULUS_CONSTANT FILM_FRACTION_BITS = 40u;

// Addresses and parameters of a render. Read through the push constant `frame`.
struct Frame {
  DeviceAddress bvh_nodes;
  DeviceAddress bvh_triangles;
  DeviceAddress vertices;
  DeviceAddress triangles;
  DeviceAddress materials;
  DeviceAddress textures;
  DeviceAddress texels;
  DeviceAddress lights;
  DeviceAddress light_aliases;
  DeviceAddress paths;
  DeviceAddress hits;
  DeviceAddress radiance;        // vec3 per path slot
  DeviceAddress ray_queues;      // two lists of path slots, used in turns by bounce parity
  DeviceAddress bounce_queues;   // one list per material class
  DeviceAddress candidates;
  DeviceAddress queue_heads;
  DeviceAddress film;
  DeviceAddress counters;
  uint width, height;
  uint light_count;
  uint seed;
  uint max_depth;       // path edges
  uint wave_capacity;   // path slots
  float filter_radius;  // pixels
  float filter_sigma;   // pixels, Gaussian only
  vec3 scene_center;
  float scene_radius;   // m, of the bounding sphere
  Camera camera;
};
REGULUS_LAYOUT(Frame, 256);

// Push constants of every stage.
struct StageArguments {
  DeviceAddress frame;
  uint bounce;
  uint wave_paths;     // paths of this wave
  uint first_pixel;    // film index of the wave's first path
  uint first_sample;   // and its sample index
};
REGULUS_LAYOUT(StageArguments, 24);

// Counters of a render: 64 bits each as (low, high) words. First things that should not happen, then the
// items that went through each queue.
REGULUS_CONSTANT COUNTER_NON_FINITE = 0u;         // samples dropped because NaN, infinite or negative
REGULUS_CONSTANT COUNTER_TRAVERSAL_OVERRUN = 1u;  // rays whose traversal hit its step bound
REGULUS_CONSTANT COUNTER_QUEUE_ITEMS = 2u;        // + QUEUE_*
REGULUS_CONSTANT COUNTER_COUNT = 7u;              // COUNTER_QUEUE_ITEMS + QUEUES_PER_BOUNCE

REGULUS_INTERFACE_END

#endif
