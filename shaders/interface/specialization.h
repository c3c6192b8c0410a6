// What kernels are specialized for: the ids of specialization constants and the values that they take.
#ifndef REGULUS_INTERFACE_SPECIALIZATION_H
#define REGULUS_INTERFACE_SPECIALIZATION_H

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
REGULUS_CONSTANT SPEC_WALK = 11u;            // WALK_*: whether the stage walks camera paths or light paths
REGULUS_CONSTANT SPEC_SAMPLER_QUALITY = 12u; // SAMPLER_QUALITY_*
REGULUS_CONSTANT SPEC_CLAMP = 13u;           // 1: no contribution exceeds Frame.largest_contribution
REGULUS_CONSTANT SPEC_CROP = 14u;            // 1: only the pixels of Frame.crop are rendered
REGULUS_CONSTANT SPEC_ENERGY_COMPENSATION = 15u;  // 1: microfacet lobes lose no light, see lib/energy.glsl
REGULUS_CONSTANT SPEC_LIGHT_SAMPLING = 16u;  // LIGHT_SAMPLING_*
REGULUS_CONSTANT SPEC_STATE = 17u;           // STATE_*: what paths and vertices carry
REGULUS_CONSTANT SPEC_FILM_EXPONENT = 18u;    // of the unit of the film's sums, signed
REGULUS_CONSTANT SPEC_SQUARE_EXPONENT = 19u;  // of the unit of its sums of squares, signed
REGULUS_CONSTANT SPEC_RAYS = 20u;             // RAYS_*: who has traced the segments of candidates
REGULUS_CONSTANT SPEC_LIGHT_GUIDE = 21u;      // 1: light paths start as a guide says (lib/light_guide.glsl)
REGULUS_CONSTANT SPEC_SHADOW_ROULETTE = 22u;  // 1: not every segment is traced (lib/shadow_roulette.glsl)
REGULUS_CONSTANT SPEC_WALK_GUIDE = 23u;       // 1: camera walks look where light comes from (lib/walk_guide.glsl)

// Who traces rays.
REGULUS_CONSTANT RAYS_SOFTWARE = 0u;  // kernels (lib/traversal.glsl)
REGULUS_CONSTANT RAYS_HOST = 1u;      // host code, in the memory of a software device; blocked segments get a negative t_max
REGULUS_CONSTANT RAYS_AUTO = 2u;      // decided before kernels are built: no kernel sees it
REGULUS_CONSTANT RAYS_HARDWARE = 3u;  // the device's own queries (lib/hardware_query.glsl), in kernels of their own

// How next-event estimation chooses a light. Light paths start by power, or as a guide says.
REGULUS_CONSTANT LIGHT_SAMPLING_POWER = 0u;
REGULUS_CONSTANT LIGHT_SAMPLING_BVH = 1u;      // by what each can send to the surface (lib/light_tree.glsl)
REGULUS_CONSTANT LIGHT_SAMPLING_UNIFORM = 2u;
REGULUS_CONSTANT LIGHT_SAMPLING_AUTO = 3u;     // chosen before kernels are built: no kernel sees it

// Whether light paths, or camera walks, are guided: what is asked for.
REGULUS_CONSTANT LIGHT_GUIDE_OFF = 0u;
REGULUS_CONSTANT LIGHT_GUIDE_ON = 1u;
REGULUS_CONSTANT LIGHT_GUIDE_AUTO = 2u;  // where it pays

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
REGULUS_CONSTANT REGULARIZATION_CONSISTENT = 2u;  // the raised roughness shrinks from iteration to iteration
REGULUS_CONSTANT REGULARIZATION_VIRTUAL_MERGE = 4u;  // with ROUGHNESS, whose lobes then serve the weights alone: the
                                                    // value is what the lobe sends into a cone around the direction
REGULUS_CONSTANT REGULARIZATION_BOTH = 8u;           // with ROUGHNESS: regularized and unregularized techniques side by side
REGULUS_CONSTANT REGULARIZATION_DIFFUSION = 16u;     // with ROUGHNESS: path diffusion leaves alone what is seen sharply
REGULUS_CONSTANT SAMPLER_QUALITY_OFF = 0u;
REGULUS_CONSTANT SAMPLER_QUALITY_ON = 1u;      // paths that some technique samples well are not regularized
REGULUS_CONSTANT SAMPLER_QUALITY_SMOOTH = 2u;  // with a smooth transition
REGULUS_CONSTANT BOUND_PEAK = 0u;
REGULUS_CONSTANT BOUND_SMITH = 1u;
REGULUS_CONSTANT BOUND_DIRECTIONAL = 2u;
REGULUS_CONSTANT MIS_BLENDED = 0u;
REGULUS_CONSTANT MIS_CORRECTED = 1u;
REGULUS_CONSTANT MIS_UNMODIFIED = 2u;

// Techniques (docs/architecture.md).
REGULUS_CONSTANT TECHNIQUE_HIT = 1u;
REGULUS_CONSTANT TECHNIQUE_NEE = 2u;
REGULUS_CONSTANT TECHNIQUE_SPLAT = 4u;
REGULUS_CONSTANT TECHNIQUE_CONNECT = 8u;
REGULUS_CONSTANT TECHNIQUE_MERGE = 16u;

REGULUS_INTERFACE_END

#endif
