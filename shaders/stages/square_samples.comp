// square_samples: after a sample of every pixel, adds its square to the sums from which the variance follows. A sample is
// all that techniques have added to the pixel since the last one, splats included.
// reads  film, splat film          writes  film_earlier, film_squares
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/film.glsl"
#include "lib/stage.glsl"

uvec3 load_sum(DeviceAddress film, uint base) {
  return uvec3(LOAD(WordBuffer, film, base), LOAD(WordBuffer, film, base + 1u), LOAD(WordBuffer, film, base + 2u));
}

void store_sum(DeviceAddress film, uint base, uvec3 words) {
  STORE(WordBuffer, film, base, words.x);
  STORE(WordBuffer, film, base + 1u, words.y);
  STORE(WordBuffer, film, base + 2u, words.z);
}

void main() {
  Frame frame = FRAME;
  uint pixel = stage.first_pixel + item_index();
  if (pixel >= frame.crop.z * frame.crop.w) return;
  for (uint channel = 0u; channel < 3u; ++channel) {
    uint base = pixel * FILM_WORDS_PER_PIXEL + 3u * channel;
    uvec3 sum = load_sum(frame.film, base);
    if ((spec_techniques & TECHNIQUE_SPLAT) != 0u) sum = fixed_add(sum, load_sum(frame.splat_film, base));
    float value = fixed_value(fixed_subtract(sum, load_sum(frame.film_earlier, base)));
    uvec3 square = fixed_words(value * value * power_of_two(2 * spec_film_exponent - spec_square_exponent));
    if (is_saturated(sum)) square = uvec3(0u, 0u, FILM_SATURATED);
    store_sum(frame.film_squares, base, fixed_add(load_sum(frame.film_squares, base), square));
    store_sum(frame.film_earlier, base, sum);
  }
}
