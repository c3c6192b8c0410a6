// The environment light (interface/scene.h): its radiance in a direction, and directions in proportion to it.
#ifndef REGULUS_LIB_ENVIRONMENT_GLSL
#define REGULUS_LIB_ENVIRONMENT_GLSL

#include "lib/buffers.glsl"
#include "lib/sampling.glsl"
#include "lib/specialization.glsl"

// A direction of the environment.
struct EnvironmentSample {
  vec3 direction;  // unit, towards the environment
  vec3 radiance;
  float pdf;       // solid angle, once the light is chosen
};

// Sines below this would overflow the pdf at the poles.
const float MIN_ENVIRONMENT_SINE = 1e-7;

vec3 environment_texel(Frame frame, ivec2 texel) {
  ivec2 size = ivec2(frame.environment.width, frame.environment.height);
  int x = texel.x < 0 ? texel.x + size.x : texel.x >= size.x ? texel.x - size.x : texel.x;
  int y = clamp(texel.y, 0, size.y - 1);
  return LOAD(Vec3Buffer, frame.environment_texels, uint(y * size.x + x));
}

// Radiance at a point of the map, given as cell and place in it: a single float for both would be too coarse beside a bright
// texel.
vec3 environment_radiance(Frame frame, uvec2 cell, vec2 place) {
  bvec2 is_upper = greaterThanEqual(place, vec2(0.5));  // beyond the centre of the cell's texel
  ivec2 texel = ivec2(cell) - ivec2(1) + ivec2(is_upper);
  vec2 weight = place + mix(vec2(0.5), vec2(-0.5), is_upper);
  vec3 top = mix(environment_texel(frame, texel), environment_texel(frame, texel + ivec2(1, 0)), weight.x);
  vec3 bottom = mix(environment_texel(frame, texel + ivec2(0, 1)), environment_texel(frame, texel + ivec2(1, 1)), weight.x);
  return mix(top, bottom, weight.y);
}

float environment_cdf(Frame frame, uint index) { return uintBitsToFloat(LOAD(WordBuffer, frame.environment_cdf, index)); }

// First entry of a row's distribution over its columns.
uint environment_row(Frame frame, uint y) { return frame.environment.height + 1u + y * (frame.environment.width + 1u); }

// Solid-angle pdf of the directions of a cell. A step of the map is pi / height in theta and 2 pi sin(theta) / width
// across.
float environment_pdf(Frame frame, uvec2 cell, float sin_theta) {
  uint row = environment_row(frame, cell.y);
  float share = (environment_cdf(frame, cell.y + 1u) - environment_cdf(frame, cell.y)) *
                (environment_cdf(frame, row + cell.x + 1u) - environment_cdf(frame, row + cell.x));
  float cells = float(frame.environment.width) * float(frame.environment.height);
  return share * cells / (2.0 * PI * PI * max(sin_theta, MIN_ENVIRONMENT_SINE));
}

// Where a distribution of `count` cells from entry `first` on reaches the share u: the cell, never one without a share, and
// the place in it in [0, 1).
float invert_environment_cdf(Frame frame, uint first, uint count, float u, out uint cell) {
  uint low = 0u, high = count - 1u;
  for (uint i = 0u; i < 32u && low < high; ++i) {
    uint middle = (low + high + 1u) >> 1u;
    if (environment_cdf(frame, first + middle) <= u)
      low = middle;
    else
      high = middle - 1u;
  }
  cell = low;
  float below = environment_cdf(frame, first + low);
  return min((u - below) / (environment_cdf(frame, first + low + 1u) - below), ONE_MINUS_ULP);
}

EnvironmentSample uniform_environment(Frame frame, vec3 direction) {
  return EnvironmentSample(direction, frame.environment.radiance, 0.25 * INV_PI);
}

// The cell of the map in which a unit direction lies, and the place in it.
uvec2 environment_cell(Frame frame, vec3 direction, float sin_theta, out vec2 place) {
  vec2 size = vec2(frame.environment.width, frame.environment.height);
  vec2 turns = vec2(atan2_turns(direction.z, direction.x) + 0.5 + frame.environment.rotation,
                    2.0 * atan2_turns(sin_theta, direction.y));
  vec2 position = vec2(turns.x - floor(turns.x), turns.y) * size;
  uvec2 cell = min(uvec2(position), uvec2(size) - 1u);
  place = position - vec2(cell);
  return cell;
}

// What the environment shows in a unit direction, and the pdf of drawing it.
EnvironmentSample environment_at(Frame frame, vec3 direction) {
  if ((spec_features & FEATURE_ENVIRONMENT_MAP) == 0u) return uniform_environment(frame, direction);
  float sin_theta = length(direction.xz);
  vec2 place;
  uvec2 cell = environment_cell(frame, direction, sin_theta, place);
  vec3 radiance = environment_radiance(frame, cell, place);
  return EnvironmentSample(direction, radiance, environment_pdf(frame, cell, sin_theta));
}

// The number from which invert_environment_cdf finds the place in a cell.
float environment_number(Frame frame, uint first, uint cell, float place) {
  return min(mix(environment_cdf(frame, first + cell), environment_cdf(frame, first + cell + 1u), place), ONE_MINUS_ULP);
}

// The numbers from which sample_environment makes a unit direction of an environment map.
vec2 environment_map_numbers(Frame frame, vec3 direction) {
  vec2 place;
  uvec2 cell = environment_cell(frame, direction, length(direction.xz), place);
  return vec2(environment_number(frame, environment_row(frame, cell.y), cell.x, place.x),
              environment_number(frame, 0u, cell.y, place.y));
}

EnvironmentSample sample_environment(Frame frame, vec2 u) {
  if ((spec_features & FEATURE_ENVIRONMENT_MAP) == 0u) return uniform_environment(frame, sample_sphere(u));
  uvec2 cell;
  vec2 place;
  place.y = invert_environment_cdf(frame, 0u, frame.environment.height, u.y, cell.y);
  place.x = invert_environment_cdf(frame, environment_row(frame, cell.y), frame.environment.width, u.x, cell.x);
  vec2 position = vec2(cell) + place;
  vec2 polar = cos_sin_turns(0.5 * position.y / float(frame.environment.height));
  float turns = position.x / float(frame.environment.width) - 0.5 - frame.environment.rotation;
  vec2 around = cos_sin_turns(turns - floor(turns));
  vec3 direction = vec3(polar.y * around.x, polar.x, polar.y * around.y);
  return EnvironmentSample(direction, environment_radiance(frame, cell, place), environment_pdf(frame, cell, polar.y));
}

#endif
