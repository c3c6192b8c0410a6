// accumulate: adds what each finished path carried to the film. A sample that is not finite is dropped and
// counted: it is a bug, and one must not spoil the image.
// reads  paths, radiance          writes  film
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/film.glsl"
#include "lib/stage.glsl"

void main() {
  uint slot = item_index();
  if (slot >= stage.wave_paths) return;
  vec3 radiance = LOAD(Vec3Buffer, FRAME.radiance, slot);
  if (!is_valid_sample(radiance)) {
    count_events(COUNTER_NON_FINITE, 1u);
    return;
  }
  uint pixels = FRAME.crop.z * FRAME.crop.w;
  film_add(FRAME.film, (stage.first_pixel + slot) % pixels, radiance);
}
