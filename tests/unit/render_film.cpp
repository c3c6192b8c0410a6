// The film on the host: fixed-point sums and counts of paths into means.
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.hpp"
#include "interface/wavefront.h"
#include "render/film.hpp"
#include "render/film_file.hpp"

namespace regulus::render {
namespace {

constexpr int WORDS = interface::FILM_WORDS_PER_PIXEL;
constexpr int FRACTION = interface::FILM_FRACTION_BITS;

Film empty_film(uint32_t width, uint32_t height, uint64_t paths) {
  Film film;
  film.width = width;
  film.height = height;
  film.words.resize(size_t{width} * height * WORDS);
  film.paths = paths;
  return film;
}

/// Sets bit `bit` of the 96-bit sum of a channel: the value 2^(bit - FRACTION).
void set_bit(Film& film, size_t pixel, size_t channel, int bit) {
  film.words[pixel * WORDS + 3 * channel + bit / 32] |= 1u << bit % 32;
}

TEST(Film, CountsWholeSamplesPixelByPixel) {
  const Film film = empty_film(3, 2, 6 * 4 + 2);  // two pixels are one sample ahead
  for (uint64_t pixel = 0; pixel < 6; ++pixel) EXPECT_EQ(film.samples(pixel), pixel < 2 ? 5u : 4u) << pixel;
  EXPECT_EQ(empty_film(3, 2, 0).samples(0), 0u);
}

TEST(Film, ResolvesEveryBitOfEverySum) {
  for (int bit = 0; bit < 96; ++bit)
    for (size_t channel = 0; channel < 3; ++channel) {
      Film film = empty_film(2, 1, 2 * 8);
      set_bit(film, 1, channel, bit);
      const image::Image image = resolve(film);
      for (size_t i = 0; i < 6; ++i)
        EXPECT_EQ(image.rgb[i], i == 3 + channel ? std::ldexp(1.0f, bit - FRACTION - 3) : 0.0f) << bit;
    }
}

TEST(Film, DividesByThePixelsOwnSamples) {
  Film film = empty_film(2, 2, 4 * 2 + 1);
  for (size_t pixel = 0; pixel < 4; ++pixel)
    for (const int bit : {FRACTION, FRACTION + 1, FRACTION + 33}) set_bit(film, pixel, 1, bit);
  const double sum = 1 + 2 + 0x1p33;
  const image::Image image = resolve(film);
  EXPECT_EQ(image.width, 2u);
  EXPECT_EQ(image.height, 2u);
  EXPECT_EQ(image.rgb[3 * 0 + 1], static_cast<float>(sum / 3));
  for (size_t pixel = 1; pixel < 4; ++pixel) EXPECT_EQ(image.rgb[3 * pixel + 1], static_cast<float>(sum / 2));
}

TEST(Film, DividesSplatsByTheIterations) {
  Film film = empty_film(2, 1, 2 * 3);
  film.splat_words.resize(film.words.size());
  film.splat_words[FRACTION / 32] = 1u << FRACTION % 32;
  film.light_paths_per_iteration = 4;
  film.light_paths = 4 * 2;
  EXPECT_EQ(resolve(film).rgb, (std::vector<float>{0.5F, 0, 0, 0, 0, 0}));
}

TEST(Film, PixelsWithoutASampleAreBlack) {
  Film film = empty_film(2, 1, 1);
  set_bit(film, 0, 0, FRACTION);
  EXPECT_EQ(resolve(film).rgb, (std::vector<float>{1, 0, 0, 0, 0, 0}));
}

// Samples 1, 2 and 6 of one value: mean 3, variance of a sample 7, of the mean 7 / 3.
TEST(Film, VarianceIsThatOfTheMean) {
  Film film = empty_film(1, 1, 3);
  film.earlier_words = film.square_words = film.words;
  for (const int bit : {3, 0}) film.earlier_words[(FRACTION + bit) / 32] |= 1u << (FRACTION + bit) % 32;
  for (const int bit : {5, 3, 0}) film.square_words[(FRACTION + bit) / 32] |= 1u << (FRACTION + bit) % 32;
  EXPECT_FLOAT_EQ(resolve_variance(film).rgb[0], 7.0f / 3);
  EXPECT_EQ(resolve_variance(film).rgb[1], 0.0f);
  film.paths = 1;
  EXPECT_TRUE(std::isinf(resolve_variance(film).rgb[0]));
}

TEST(Film, SumsAreInUnitsOfTheExponent) {
  Film film = empty_film(1, 1, 1);
  set_bit(film, 0, 0, FRACTION);
  film.earlier_words = film.square_words = film.words;
  set_bit(film, 0, 0, FRACTION + 54);
  for (const int exponent : {-100, -44, 23, 60}) {
    film.exponents = {exponent, exponent / 2};
    EXPECT_EQ(resolve(film).rgb[0], std::ldexp(1 + 0x1p54f, exponent));
    // Two samples whose values sum to 2^e and squares to 2^(e / 2): (2^(e / 2) - 2^(2 e) / 2) / 2.
    film.paths = 2;
    const double spread = std::max(std::ldexp(1.0, exponent / 2) - std::ldexp(0.5, 2 * exponent), 0.0);
    EXPECT_FLOAT_EQ(resolve_variance(film).rgb[0], static_cast<float>(spread / 2));
    film.paths = 1;
  }
}

// However much more came: it shows the least that cannot be held, and one way to write it.
TEST(Film, SaturatedSumsAreCountedAndShowTheirBound) {
  Film film = empty_film(2, 1, 2);
  film.words[WORDS + 2] = 0x80000123;
  film.words[WORDS + 3] = 7;
  film.words[WORDS + 8] = 0xFFFFFFFF;
  film.earlier_words = film.square_words = film.words;
  EXPECT_EQ(count_saturated(film.words), 2u);
  EXPECT_EQ(resolve(film).rgb[3], 0x1p55f);
  EXPECT_EQ(resolve(film).rgb[5], 0x1p55f);
  EXPECT_TRUE(std::isinf(resolve_variance(film).rgb[3]));
  settle_saturated(film.words);
  EXPECT_EQ(std::vector<uint32_t>(film.words.begin() + WORDS, film.words.end()),
            (std::vector<uint32_t>{0, 0, 0x80000000, 7, 0, 0, 0, 0, 0x80000000}));
}

TEST(Film, SumsOfPartsSaturate) {
  constexpr uint32_t SATURATED = interface::FILM_SATURATED;
  Film a = empty_film(2, 1, 2), b = empty_film(2, 1, 2);
  a.words = {5, 0, SATURATED,  5, 0, SATURATED,  0xFFFFFFFF, 0xFFFFFFFF, 0x7FFFFFFF,
             5, 0, 0x7FFFFFFF, 0, 0, 0x40000000, 0,          0,          0xFFFFFFFF};
  b.words = {9, 0, SATURATED, 9, 1, 0, 1, 0, 0, 9, 0, 0, 0, 0, 0x40000000, 0, 0, 0xFFFFFFFF};
  add(a, b);
  EXPECT_EQ(a.words, (std::vector<uint32_t>{0, 0, SATURATED, 0, 0, SATURATED, 0, 0, SATURATED, 14, 0,
                                            0x7FFFFFFF, 0, 0, SATURATED, 0, 0, SATURATED}));
}

TEST(Film, FilesKeepTheExponents) {
  Film film = empty_film(1, 1, 1);
  film.exponents = {-44, 31};
  image::ExrContents contents;
  contents.width = contents.height = 1;
  add_film(film, contents.channels, contents.attributes);
  EXPECT_EQ(take_film("a.exr", contents).exponents, film.exponents);
  add_film(film, contents.channels, contents.attributes);
  contents.attributes["regulus:film_exponent"] = "-4000000";
  EXPECT_THROW(take_film("a.exr", contents), Error);
}

TEST(Film, SumsOfPartsCarryFromWordToWord) {
  Film a = empty_film(1, 2, 2), b = empty_film(1, 2, 4);
  a.words = {0xFFFFFFFF, 0xFFFFFFFF, 1, 5, 6, 7, 0, 0xFFFFFFFF, 0xFFFFFF, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  b.words = {1, 0, 2, 1, 1, 1, 0, 1, 0, 9, 0, 0, 0, 0, 0, 0, 0, 3};
  add(a, b);
  EXPECT_EQ(a.words, (std::vector<uint32_t>{0, 0, 4, 6, 7, 8, 0, 0, 0x1000000, 9, 0, 0, 0, 0, 0, 0, 0, 3}));
  EXPECT_EQ(a.paths, 6u);
}

/// A film of two layers, one of them with a name that others begin with, and splats.
Film layered(uint32_t first) {
  Film film = empty_film(2, 1, 2);
  film.layers = {{"light_a"}, {"light_a-b"}};
  film.light_paths = 2;
  film.light_paths_per_iteration = 2;
  for (const auto& [name, words] : sums_of(film)) {
    if (name == "earlier" || name == "squares") continue;
    words->assign(film.pixels() * WORDS, 0);
    for (size_t i = 0; i < words->size(); i += 3) (*words)[i] = first++;
  }
  return film;
}

void expect_same_sums(const Film& a, const Film& b) {
  ASSERT_TRUE(have_same_sums(a, b));
  const auto of_a = sums_of(a), of_b = sums_of(b);
  for (size_t i = 0; i < of_a.size(); ++i) EXPECT_EQ(*of_a[i].words, *of_b[i].words) << of_a[i].name;
}

TEST(FilmFile, KeepsLayersInTheirOrder) {
  const Film film = layered(1);
  image::ExrContents contents;
  contents.width = 2;
  contents.height = 1;
  add_film(film, contents.channels, contents.attributes);
  const Film read = take_film("part.exr", contents);
  EXPECT_TRUE(contents.channels.empty());
  ASSERT_EQ(read.layers.size(), 2u);
  EXPECT_EQ(read.layers[0].name, "light_a");
  expect_same_sums(read, film);
}

TEST(FilmFile, AddsAndPlacesLayers) {
  Film sum = layered(1);
  add(sum, layered(1000));
  const Film first = layered(1), second = layered(1000);
  const auto of_sum = sums_of(sum);
  for (size_t k = 0; k < of_sum.size(); ++k)
    for (size_t i = 0; i < of_sum[k].words->size(); ++i)
      EXPECT_EQ((*of_sum[k].words)[i], (*sums_of(first)[k].words)[i] + (*sums_of(second)[k].words)[i]);
  Film whole = empty_like(first, 2, 2);
  place(first, 0, 0, whole);
  place(second, 0, 1, whole);
  for (size_t i = 0; i < 2 * WORDS; ++i) {
    EXPECT_EQ(whole.layers[1].splat_words[i], first.layers[1].splat_words[i]);
    EXPECT_EQ(whole.layers[1].splat_words[2 * WORDS + i], second.layers[1].splat_words[i]);
  }
  Film other = layered(1);
  other.layers[1].name = "light_c";
  EXPECT_FALSE(have_same_sums(first, other));
  // Layers share the sums of the film among them.
  EXPECT_EQ(resolve(film_of_layer(first, first.layers[0])).rgb[0],
            static_cast<float>(std::ldexp(
                double(first.layers[0].words[0]) + double(first.layers[0].splat_words[0]), -FRACTION)));
}

}  // namespace
}  // namespace regulus::render
