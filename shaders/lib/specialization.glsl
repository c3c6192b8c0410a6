// The specialization constants of every stage (ids in interface/specialization.h). By default a kernel computes everything it
// can, so that one that sets no constants is complete, but it keeps no state beside paths.
#ifndef REGULUS_LIB_SPECIALIZATION_GLSL
#define REGULUS_LIB_SPECIALIZATION_GLSL

#include "interface/wavefront.h"

layout(constant_id = SPEC_NDF) const uint spec_ndf = NDF_GGX;
layout(constant_id = SPEC_SHADOWING) const uint spec_shadowing = SHADOWING_SMITH;
layout(constant_id = SPEC_MATERIAL_CLASS) const uint spec_material_class = MATERIAL_CLASS_TRANSMISSIVE;
layout(constant_id = SPEC_FEATURES) const uint spec_features = 0xFFFFFFFFu;
layout(constant_id = SPEC_TECHNIQUES) const uint spec_techniques = TECHNIQUE_HIT | TECHNIQUE_NEE;
layout(constant_id = SPEC_FILTER) const uint spec_filter = FILTER_BLACKMAN_HARRIS;
layout(constant_id = SPEC_SAMPLER) const uint spec_sampler = SAMPLER_SOBOL;
layout(constant_id = SPEC_REGULARIZATION) const uint spec_regularization = REGULARIZATION_NONE;
layout(constant_id = SPEC_BOUND) const uint spec_bound = BOUND_PEAK;
layout(constant_id = SPEC_MIS) const uint spec_mis = MIS_BLENDED;
layout(constant_id = SPEC_WALK) const uint spec_walk = WALK_CAMERA;
layout(constant_id = SPEC_SAMPLER_QUALITY) const uint spec_sampler_quality = SAMPLER_QUALITY_OFF;
layout(constant_id = SPEC_CLAMP) const uint spec_clamp = 0u;
layout(constant_id = SPEC_CROP) const uint spec_crop = 0u;
layout(constant_id = SPEC_ENERGY_COMPENSATION) const uint spec_energy_compensation = 0u;
layout(constant_id = SPEC_LIGHT_SAMPLING) const uint spec_light_sampling = LIGHT_SAMPLING_POWER;
layout(constant_id = SPEC_STATE) const uint spec_state = STATE_ALWAYS;
layout(constant_id = SPEC_FILM_EXPONENT) const int spec_film_exponent = 0;
layout(constant_id = SPEC_SQUARE_EXPONENT) const int spec_square_exponent = 0;
layout(constant_id = SPEC_RAYS) const uint spec_rays = RAYS_SOFTWARE;
layout(constant_id = SPEC_LIGHT_GUIDE) const uint spec_light_guide = 0u;
layout(constant_id = SPEC_SHADOW_ROULETTE) const uint spec_shadow_roulette = 0u;
layout(constant_id = SPEC_WALK_GUIDE) const uint spec_walk_guide = 0u;

// True if one of these STATE_* is kept. A macro, for the reasons in lib/bsdf_parameters.glsl.
#define has_state(bits) ((spec_state & (bits)) != 0u)

// Without `hit` an emitter that the camera sees directly is found by connecting it to the lens. A macro
// likewise.
#define connects_emitters() ((spec_techniques & (TECHNIQUE_SPLAT | TECHNIQUE_HIT)) == TECHNIQUE_SPLAT)

#endif
