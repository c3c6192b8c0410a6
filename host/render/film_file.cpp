#include "render/film_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>
#include <utility>

#include "base/error.hpp"
#include "interface/wavefront.h"

namespace regulus::render {

namespace {

using interface::FILM_SATURATED;
using interface::FILM_WORDS_PER_PIXEL;

constexpr int MOST_EXPONENT = 200;
constexpr const char* PATHS = "regulus:paths";
constexpr const char* LIGHT_PATHS = "regulus:light_paths_done";
constexpr const char* LIGHT_PATHS_PER_ITERATION = "regulus:light_paths_per_iteration";
constexpr const char* EXPONENT = "regulus:film_exponent";
constexpr const char* SQUARE_EXPONENT = "regulus:film_square_exponent";

constexpr const char* PREFIX = "film.";

std::string channel_name(const std::string& sums, uint32_t word) {
  return fmt::format("{}{}.{}{}", PREFIX, sums, "RGB"[word / 3], word % 3);
}

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& reason) {
  throw Error(ErrorCode::BadFile, fmt::format("{}: {}; render it as a range of samples or with a checkpoint",
                                              path.string(), reason));
}

template <typename Integer>
Integer parse(const std::filesystem::path& path, const char* name, const std::string& text) {
  Integer value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size())
    fail(path, fmt::format("its {} is not a number", name));
  return value;
}

uint64_t number(const std::filesystem::path& path, const image::Attributes& attributes, const char* name) {
  const auto found = attributes.find(name);
  if (found == attributes.end()) fail(path, "holds no sums of samples");
  return parse<uint64_t>(path, name, found->second);
}

int exponent(const std::filesystem::path& path, const image::Attributes& attributes, const char* name) {
  const auto found = attributes.find(name);
  const int value = found == attributes.end() ? 0 : parse<int>(path, name, found->second);
  if (value < -MOST_EXPONENT || value > MOST_EXPONENT) fail(path, fmt::format("its {} is {}", name, value));
  return value;
}

/// Words of the sums of this name; empty if the file has none of their channels.
std::vector<uint32_t> take_sums(const std::filesystem::path& path, const std::string& name, uint64_t pixels,
                                image::Channels& channels) {
  std::vector<uint32_t> words;
  for (uint32_t word = 0; word < FILM_WORDS_PER_PIXEL; ++word) {
    const auto node = channels.extract(channel_name(name, word));
    if (node.empty() && words.empty()) continue;
    const auto* values = node.empty() ? nullptr : std::get_if<std::vector<uint32_t>>(&node.mapped());
    if (values == nullptr || (words.empty() && word != 0)) fail(path, "misses some of the sums of samples");
    words.resize(pixels * FILM_WORDS_PER_PIXEL);
    for (uint64_t pixel = 0; pixel < pixels; ++pixel)
      words[pixel * FILM_WORDS_PER_PIXEL + word] = (*values)[pixel];
  }
  return words;
}

/// The layers of which the file has sums, by name as films have them.
std::vector<LightLayer> find_layers(const image::Channels& channels) {
  constexpr std::string_view OF_LAYER = ".sum.R0";
  std::vector<LightLayer> layers;
  for (const auto& [name, channel] : channels)
    if (name.starts_with(PREFIX) && name.ends_with(OF_LAYER) && name != channel_name("sum", 0)) {
      const size_t begin = std::string_view(PREFIX).size();
      layers.push_back({name.substr(begin, name.size() - begin - OF_LAYER.size())});
    }
  std::ranges::sort(layers, {}, &LightLayer::name);
  return layers;
}

}  // namespace

void add_film(const Film& film, image::Channels& channels, image::Attributes& attributes) {
  for (const auto& [name, words] : sums_of(film)) {
    if (words->empty()) continue;
    for (uint32_t word = 0; word < FILM_WORDS_PER_PIXEL; ++word) {
      std::vector<uint32_t> values(film.pixels());
      for (uint64_t pixel = 0; pixel < values.size(); ++pixel)
        values[pixel] = (*words)[pixel * FILM_WORDS_PER_PIXEL + word];
      channels[channel_name(name, word)] = std::move(values);
    }
  }
  attributes[PATHS] = std::to_string(film.paths);
  attributes[LIGHT_PATHS] = std::to_string(film.light_paths);
  attributes[LIGHT_PATHS_PER_ITERATION] = std::to_string(film.light_paths_per_iteration);
  attributes[EXPONENT] = std::to_string(film.exponents.radiance);
  attributes[SQUARE_EXPONENT] = std::to_string(film.exponents.squares);
}

Film take_film(const std::filesystem::path& path, image::ExrContents& contents) {
  Film film;
  film.width = contents.width;
  film.height = contents.height;
  film.paths = number(path, contents.attributes, PATHS);
  film.light_paths = number(path, contents.attributes, LIGHT_PATHS);
  film.light_paths_per_iteration = number(path, contents.attributes, LIGHT_PATHS_PER_ITERATION);
  film.exponents.radiance = exponent(path, contents.attributes, EXPONENT);
  film.exponents.squares = exponent(path, contents.attributes, SQUARE_EXPONENT);
  film.layers = find_layers(contents.channels);
  for (const auto& [name, words] : sums_of(film))
    *words = take_sums(path, name, film.pixels(), contents.channels);
  if (film.words.empty()) fail(path, "holds no sums of samples");
  if (film.light_paths_per_iteration == 0) fail(path, "has iterations without light paths");
  return film;
}

void add(Film& film, const Film& other) {
  const auto all = sums_of(film);
  const auto all_more = sums_of(other);
  for (size_t i = 0; i < all.size(); ++i) {
    std::vector<uint32_t>& sums = *all[i].words;
    const std::vector<uint32_t>& more = *all_more[i].words;
    uint64_t carry = 0;
    for (size_t word = 0; word < sums.size(); ++word) {
      if (word % 3 == 0) carry = 0;  // the next sum of three words
      carry += uint64_t{sums[word]} + more[word];
      // The saturation bits of two sums would carry each other out of the word.
      if (word % 3 == 2) carry = std::min(carry, uint64_t{FILM_SATURATED});
      sums[word] = static_cast<uint32_t>(carry);
      carry >>= 32;
    }
    settle_saturated(sums);
  }
  film.paths += other.paths;
  film.light_paths += other.light_paths;
}

Film empty_like(const Film& film, uint32_t width, uint32_t height) {
  Film empty;
  empty.width = width;
  empty.height = height;
  empty.light_paths = film.light_paths;
  empty.light_paths_per_iteration = film.light_paths_per_iteration;
  empty.exponents = film.exponents;
  for (const LightLayer& layer : film.layers) empty.layers.push_back({layer.name});
  const auto from = sums_of(film);
  const auto to = sums_of(empty);
  for (size_t i = 0; i < to.size(); ++i)
    if (!from[i].words->empty()) to[i].words->resize(empty.pixels() * FILM_WORDS_PER_PIXEL);
  return empty;
}

void place(const Film& part, uint32_t x, uint32_t y, Film& whole) {
  const uint64_t words_per_row = uint64_t{part.width} * FILM_WORDS_PER_PIXEL;
  const auto from = sums_of(part);
  const auto to = sums_of(whole);
  for (size_t i = 0; i < from.size(); ++i) {
    const std::vector<uint32_t>& words = *from[i].words;
    for (uint64_t row = 0; !words.empty() && row < part.height; ++row)
      std::copy_n(&words[row * words_per_row], words_per_row,
                  &(*to[i].words)[((y + row) * whole.width + x) * FILM_WORDS_PER_PIXEL]);
  }
  whole.paths += part.paths;
}

}  // namespace regulus::render
