// A path between stages, and the vertices that it leaves behind.
#ifndef REGULUS_INTERFACE_PATH_H
#define REGULUS_INTERFACE_PATH_H

#include "scene.h"
#include "types.h"

REGULUS_INTERFACE_BEGIN

// State of a path between stages: the ray to trace next and what it carries. Camera and light paths alike.
struct Path {
  vec3 origin;
  float mis_a;       // accumulators of MIS (lib/mis.glsl), still without the distance of the ray
  vec3 direction;    // unit
  uint number;       // PATH_NUMBER: of the pixel on the whole film (y * width + x), or of the light path in its iteration;
                     // above it PATH_DIFFUSED or PATH_PARALLEL, and PATH_DISPERSED
  vec3 throughput;
  uint sample_index; // of the pixel; light path: the iteration, which is the same number
  float eta_scale;   // camera path: product of (eta_i / eta_t)^2 so far, undone in Russian roulette; so is what a guide does
  uint bounce;       // path edges before this ray
  uint medium;       // material whose absorption the ray passes through, or INVALID_INDEX
  float mis_b;
};
REGULUS_LAYOUT(Path, 64);

// Of a camera path: set once it has scattered at a surface that is not sharp (lib/regularization.glsl).
REGULUS_CONSTANT PATH_DIFFUSED = 1u << 31;
// Of a light path: its first ray is one of parallel ones, from an infinitely distant light.
REGULUS_CONSTANT PATH_PARALLEL = 1u << 31;
// Set once the path has scattered at an interface whose index depends on the wavelength (lib/dispersion.glsl).
REGULUS_CONSTANT PATH_DISPERSED = 1u << 30;
REGULUS_CONSTANT PATH_NUMBER = (1u << 30) - 1u;

// A vertex of a subpath as connections and merges need it: where it is, where the walk came from, what it
// carries on arrival (the bsdf here not included), and the accumulators of MIS (lib/mis.glsl).
struct CameraVertex {
  vec3 position;
  uint medium;        // of the edge that arrives: a material, or INVALID_INDEX
  vec3 direction;     // unit, towards the previous vertex of the walk
  uint triangle;
  vec3 throughput;
  float mis_a;
  vec2 barycentrics;
  float mis_b;
  uint edges;         // PATH_VERTEX_EDGES: path edges from the camera to here, or 0 if there is no vertex; PATH_VERTEX_DIFFUSED,
                      // PATH_VERTEX_DISPERSED
};
REGULUS_LAYOUT(CameraVertex, 64);

struct LightVertex {
  vec3 position;
  uint previous;      // number of the vertex before it on its path, or INVALID_INDEX
  vec3 direction;
  uint triangle;
  vec3 throughput;
  float mis_a;
  vec2 barycentrics;
  float mis_b;
  uint edges;         // PATH_VERTEX_EDGES: path edges from the light to here; above them the MATERIAL_CLASS_* of the
                      // surface, the last bits of the light path's number, and PATH_VERTEX_DISPERSED
};
REGULUS_LAYOUT(LightVertex, 64);
REGULUS_CONSTANT PATH_VERTEX_EDGES = 0xFFFFu;
REGULUS_CONSTANT PATH_VERTEX_DIFFUSED = 1u << 30;  // camera vertex: PATH_DIFFUSED on arrival
REGULUS_CONSTANT PATH_VERTEX_DISPERSED = 1u << 31;  // PATH_DISPERSED on arrival
REGULUS_CONSTANT LIGHT_VERTEX_CLASS_SHIFT = 16u;
REGULUS_CONSTANT LIGHT_VERTEX_CLASS_MASK = 3u;
REGULUS_CONSTANT LIGHT_VERTEX_STREAM_SHIFT = 18u;
REGULUS_CONSTANT LIGHT_VERTEX_STREAM_MASK = 0xFFFu;

// Where the ray of a path or a segment starts, only with FEATURE_CONTACTS: the solids around it, and the surface point that it
// leaves.
struct PathMedia {
  MediaSet around;
  vec2 barycentrics;
  uint triangle;  // the surface's number; INVALID_INDEX: the ray leaves no surface
  uint solid;     // whose boundary that is, or INVALID_INDEX
};
REGULUS_LAYOUT(PathMedia, 48);

// What a path, or a subpath so far, has scattered at: a surface diffuses or is sharp (lib/regularization.glsl).
REGULUS_CONSTANT TRAIL_DIFFUSED_FIRST = 1u;   // the vertex next to the lens diffuses
REGULUS_CONSTANT TRAIL_DIFFUSED_BEYOND = 2u;  // another one does
REGULUS_CONSTANT TRAIL_SHARP = 4u;            // a vertex is sharp
REGULUS_CONSTANT TRAIL_BITS = 7u;
REGULUS_CONSTANT TRAIL_GROUP_SHIFT = 3u;      // above them the group of the light, of paths that have one

// Kinds of light by what it has scattered at on its way to the lens; every path has one. (L: light, E: eye, D: a vertex that
// diffuses, S: one that is sharp, *: any number, +: one at least.)
REGULUS_CONSTANT LIGHT_EMISSION = 0u;  // L S* E
REGULUS_CONSTANT LIGHT_DIRECT = 1u;    // L D E
REGULUS_CONSTANT LIGHT_CAUSTICS = 2u;  // L S+ D E
REGULUS_CONSTANT LIGHT_INDIRECT = 3u;  // the rest
REGULUS_CONSTANT LIGHT_KINDS = 4u;

// The vertices of one light path: the last one stored, from which the others follow by `previous`.
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

// What sampler quality and `both` need to know of a subpath besides Path or its vertices (lib/history.glsl). Between
// stages, `plain` and `pending` do not include the length of the ray yet.
struct PathHistory {
  vec2 plain;         // accumulators (A, B) of the unregularized weights
  float worst;        // least bound of a finished technique's estimator, times the squared length of the path, 1/m^2
  float pending;      // rho-bar of the last vertex over the squared length of the edge that leads on
  float distance;     // m, along the subpath
  float ratio;        // rho^W / rho of the last vertex
  float sharp_ratio;  // the same as seen by a camera path that has not diffused
};
REGULUS_LAYOUT(PathHistory, 28);

// Path edges before Russian roulette starts: the first indirect bounces carry most of the light.
REGULUS_CONSTANT ROULETTE_FIRST_BOUNCE = 2u;

REGULUS_INTERFACE_END

#endif
