// What a render keeps in device memory: what arrays have an element for (PER_*), and which of them a plan needs (STATE_*).
// The arrays themselves stand in state_table.h.
#ifndef REGULUS_INTERFACE_STATE_H
#define REGULUS_INTERFACE_STATE_H

#include "types.h"

REGULUS_INTERFACE_BEGIN

// What a plan keeps (host/render/plan.cpp decides; kernels ask spec_state, with has_state()). Bits that kernels ask for:
REGULUS_CONSTANT STATE_ALWAYS = 0u;
REGULUS_CONSTANT STATE_VERTICES = 1u << 0;    // light and camera vertices, for connections and merges
REGULUS_CONSTANT STATE_ESCAPES = 1u << 1;     // camera rays that meet nothing but the environment
REGULUS_CONSTANT STATE_RECEIVERS = 1u << 2;   // `hit` weighs against lights that `nee` chooses by the tree
REGULUS_CONSTANT STATE_HISTORIES = 1u << 3;   // sampler quality or `both`: a PathHistory beside each path and vertex
REGULUS_CONSTANT STATE_FOOTPRINTS = 1u << 4;  // path diffusion without light subpaths: camera paths carry their footprint
REGULUS_CONSTANT STATE_SHARP = 1u << 5;       // path diffusion with light subpaths: their accumulators for both of its levels
REGULUS_CONSTANT STATE_STRATEGIES = 1u << 6;  // images of single strategies
REGULUS_CONSTANT STATE_LAYERS = 1u << 7;      // light of single kinds and lamps (lib/layers.glsl)
REGULUS_CONSTANT STATE_IDS = 1u << 17;        // of AOVs: what each ray meets, for cryptomattes
REGULUS_CONSTANT STATE_OF_KERNELS = 0xFFu | STATE_IDS;
// Bits that the host alone asks for:
REGULUS_CONSTANT STATE_CANDIDATES = 1u << 8;        // segments of `nee` and `connect`
REGULUS_CONSTANT STATE_SPLATS = 1u << 9;            // a film of `splat`
REGULUS_CONSTANT STATE_CACHE = 1u << 10;            // light vertices are counted, so that any can be drawn
REGULUS_CONSTANT STATE_MERGES = 1u << 11;           // the merge grid
REGULUS_CONSTANT STATE_MEDIA = 1u << 12;            // FEATURE_CONTACTS: the solids around each path and vertex
REGULUS_CONSTANT STATE_VARYING_STARTS = 1u << 13;   // the solids around a start are found path by path
REGULUS_CONSTANT STATE_SQUARES = 1u << 14;          // the variance of pixels
REGULUS_CONSTANT STATE_SURFACES = 1u << 15;         // AOVs of what cameras see
REGULUS_CONSTANT STATE_SIGMA = 1u << 16;            // the AOV of footprints

// What an array has an element for.
REGULUS_CONSTANT PER_RENDER = 0u;
REGULUS_CONSTANT PER_PATH = 1u;            // slot of a wave
REGULUS_CONSTANT PER_CAMERA_VERTEX = 2u;   // slot, with STATE_VERTICES
REGULUS_CONSTANT PER_CANDIDATE = 3u;       // light sample or connection of a bounce
REGULUS_CONSTANT PER_PAIR = 4u;            // connection of a bounce
REGULUS_CONSTANT PER_SPLAT = 5u;           // of a bounce
REGULUS_CONSTANT PER_BOUNCE = 6u;          // and one after the last
REGULUS_CONSTANT PER_LIGHT_PATH = 7u;      // of the wave or iteration, with STATE_VERTICES
REGULUS_CONSTANT PER_LIGHT_PATH_SUM = 8u;  // light path, and behind them the sums that a scan needs
REGULUS_CONSTANT PER_LIGHT_VERTEX = 9u;    // that there is room for
REGULUS_CONSTANT PER_CELL_SUM = 10u;       // cell of the grid and one more, and the sums of a scan
REGULUS_CONSTANT PER_PIXEL = 11u;          // that is rendered
REGULUS_CONSTANT PER_STRATEGY_PIXEL = 12u; // pixel of each strategy's two images
REGULUS_CONSTANT PER_STRATEGY_PLACE = 13u; // see strategy_layers()
REGULUS_CONSTANT PER_LAYER_PIXEL = 14u;    // pixel of each layer, and once more for splats
REGULUS_CONSTANT PER_LIGHT = 15u;          // of the scene

REGULUS_INTERFACE_END

#endif
