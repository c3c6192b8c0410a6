// What the film holds: sums, what cameras see, and counters.
#ifndef REGULUS_INTERFACE_FILM_H
#define REGULUS_INTERFACE_FILM_H

#include "queues.h"
#include "types.h"

REGULUS_INTERFACE_BEGIN

// Film: per pixel three channels of three words, low first: a fixed-point sum in units of
// 2^(exponent - FILM_FRACTION_BITS), the exponent being the scene's (SPEC_FILM_EXPONENT; 0 for ordinary light). A sum
// with FILM_SATURATED in its highest word is too large to be held, 2^(exponent + FILM_RANGE_BITS) or more.
REGULUS_CONSTANT FILM_WORDS_PER_PIXEL = 9u;
REGULUS_CONSTANT FILM_FRACTION_BITS = 40u;
REGULUS_CONSTANT FILM_RANGE_BITS = 55u;
REGULUS_CONSTANT FILM_SATURATED = 1u << 31;

// What camera rays meet first. Albedo and normals are means over AOV_RAYS rays, those of the pixel's first samples, and
// black where they meet nothing; the rest belongs to the ray from the middle of the lens through the middle of the pixel.
// Normals are unit before the mean and on the side of the camera.
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

// Counters of a render: 64 bits each as (low, high) words. First come things that should not happen, then the number of
// items that went through each queue, in camera passes and in light passes.
REGULUS_CONSTANT COUNTER_NON_FINITE = 0u;         // samples dropped because NaN, infinite or negative
REGULUS_CONSTANT COUNTER_TRAVERSAL_OVERRUN = 1u;  // rays whose traversal hit its step bound
REGULUS_CONSTANT COUNTER_MEDIA_OVERFLOW = 2u;     // solids that paths have forgotten: more than MEDIA_SET_SIZE at once
REGULUS_CONSTANT COUNTER_QUEUE_ITEMS = 3u;        // + pass * QUEUES_PER_BOUNCE + QUEUE_*
REGULUS_CONSTANT COUNTER_COUNT = COUNTER_QUEUE_ITEMS + 2u * QUEUES_PER_BOUNCE;

// StageArguments.counted_pass.
REGULUS_CONSTANT COUNTED_CAMERA_PASS = 0u;
REGULUS_CONSTANT COUNTED_LIGHT_PASS = 1u;

REGULUS_INTERFACE_END

#endif
