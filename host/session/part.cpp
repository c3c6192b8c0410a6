#include "session/part.hpp"

#include <fmt/format.h>

#include <bit>
#include <charconv>
#include <cmath>
#include <numeric>
#include <set>

#include "base/error.hpp"
#include "interface/wavefront.h"
#include "render/film_file.hpp"

namespace regulus::session {

namespace {

constexpr const char* RANGES = "regulus:sample_ranges";
constexpr const char* CHECKSUM = "regulus:checksum";
constexpr const char* CHECKSUM_VERSION = "1";

// What may differ between samples of one render: which they are, where they were rendered, and under which
// name the scene lay there (its hash counts).
const std::set<std::string> OF_THE_RUN = {"regulus:first_sample",
                                          "regulus:samples",
                                          "regulus:samples_done",
                                          "regulus:sample_ranges",
                                          "regulus:checksum",
                                          "regulus:paths",
                                          "regulus:light_paths_done",
                                          "regulus:light_paths_per_iteration",
                                          "regulus:film_exponent",
                                          "regulus:film_square_exponent",
                                          "regulus:device",
                                          "regulus:driver",
                                          "regulus:split",
                                          "regulus:render_seconds",
                                          "regulus:non_finite",
                                          "regulus:scene"};

/// What was asked for, and why something was done: parts go by what was done, however it came to that.
bool is_a_reason(const std::string& key) {
  return key.starts_with("regulus:asked_") || key.ends_with("_rule") || key == "regulus:dropped";
}

// "0:16,32:16"
std::vector<SampleRange> parse_ranges(const std::filesystem::path& path, const std::string& text) {
  std::vector<SampleRange> ranges;
  const char* at = text.data();
  const char* const end = at + text.size();
  uint64_t free = 0;  // the first sample that may come next
  const auto fail = [&] {
    throw Error(ErrorCode::BadFile,
                fmt::format("{}: {} \"{}\" is not a list of FIRST:COUNT; the file is corrupt", path.string(),
                            RANGES, text));
  };
  while (true) {
    SampleRange range;
    const auto [colon, first_error] = std::from_chars(at, end, range.first);
    if (first_error != std::errc{} || colon == end || *colon != ':') fail();
    const auto [after, count_error] = std::from_chars(colon + 1, end, range.count);
    constexpr uint64_t MOST = uint64_t{1} << 32;
    if (count_error != std::errc{} || range.first < free || range.first > MOST || range.count - 1 >= MOST)
      fail();
    free = range.first + range.count;
    ranges.push_back(range);
    if (after == end) return ranges;
    if (*after != ',') fail();
    at = after + 1;
  }
}

/// FNV-1a (64 bit) over whole words: two contents that differ in one of them never have the same hash, as the
/// steps can be undone.
class Checksum {
 public:
  void add(uint64_t word) { hash_ = (hash_ ^ word) * 0x100000001b3u; }
  void add(const std::string& text) {
    add(uint64_t{text.size()});
    for (const unsigned char letter : text) add(uint64_t{letter});
  }
  void add(const image::Channel& channel) {
    add(uint64_t{channel.index()});
    std::visit(
        [&](const auto& values) {
          for (const auto& value : values) add(uint64_t{std::bit_cast<uint32_t>(value)});
        },
        channel);
  }
  uint64_t value() const { return hash_; }

 private:
  uint64_t hash_ = 0xcbf29ce484222325u;
};

/// The version of what is summed up, and the sum.
std::string checksum_of(const image::Attributes& attributes, const image::Channels& channels, uint32_t width,
                        uint32_t height, const image::Placement& placement) {
  Checksum checksum;
  const uint32_t film_width = placement.film_width != 0 ? placement.film_width : width;
  const uint32_t film_height = placement.film_height != 0 ? placement.film_height : height;
  for (const uint32_t number : {width, height, placement.x, placement.y, film_width, film_height})
    checksum.add(uint64_t{number});
  for (const auto& [name, text] : attributes) {
    if (!name.starts_with("regulus:") || name == CHECKSUM) continue;
    checksum.add(name);
    checksum.add(text);
  }
  for (const auto& [name, channel] : channels) {
    if (name == "R" || name == "G" || name == "B") continue;
    checksum.add(name);
    checksum.add(channel);
  }
  return fmt::format("{}:{:016x}", CHECKSUM_VERSION, checksum.value());
}

void require_checksum(const std::filesystem::path& path, const image::ExrContents& contents) {
  const image::Attributes& attributes = contents.attributes;
  const auto found = attributes.find(CHECKSUM);
  const auto paths = attributes.find("regulus:paths");
  if (found == attributes.end() && paths == attributes.end()) return;  // a picture; others say that
  const auto version = attributes.find("regulus:version");
  const std::string writer = version == attributes.end() ? "an unknown version" : version->second;
  if (found == attributes.end())
    throw Error(
        ErrorCode::BadFile,
        fmt::format(
            "{}: has no checksum: it is damaged, or of an older version ({}), which can still read it",
            path.string(), writer));
  const std::string& text = found->second;
  if (text == checksum_of(attributes, contents.channels, contents.width, contents.height, contents.placement))
    return;
  const std::string version_of_sum = text.substr(0, text.find(':'));
  if (version_of_sum != CHECKSUM_VERSION && !version_of_sum.empty() &&
      version_of_sum.find_first_not_of("0123456789") == std::string::npos)
    throw Error(
        ErrorCode::BadFile,
        fmt::format("{}: has a checksum of version {}, not {}: it is damaged, or of another version ({}), "
                    "which can read it",
                    path.string(), version_of_sum, CHECKSUM_VERSION, writer));
  throw Error(
      ErrorCode::BadFile,
      fmt::format("{}: its checksum does not fit; the file is damaged, render it again", path.string()));
}

std::string format_ranges(const std::vector<SampleRange>& ranges) {
  std::string text;
  for (const SampleRange& range : ranges)
    text += fmt::format("{}{}:{}", text.empty() ? "" : ",", range.first, range.count);
  return text;
}

}  // namespace

uint64_t Part::samples() const {
  return std::accumulate(ranges.begin(), ranges.end(), uint64_t{0},
                         [](uint64_t sum, const SampleRange& range) { return sum + range.count; });
}

bool Part::is_complete() const {
  return film.paths == samples() * film.pixels();
}

bool is_part(const std::filesystem::path& path) {
  try {
    return image::read_exr_contents(path).attributes.contains("regulus:paths");
  } catch (const Error&) {
    return false;
  }
}

Part read_part(const std::filesystem::path& path) {
  Part part;
  part.path = path;
  part.contents = image::read_exr_contents(path);
  require_checksum(path, part.contents);
  part.film = render::take_film(path, part.contents);
  const auto ranges = part.contents.attributes.find(RANGES);
  part.ranges = parse_ranges(path, ranges == part.contents.attributes.end() ? std::string() : ranges->second);
  if (part.film.paths > part.samples() * part.film.pixels())
    throw Error(ErrorCode::BadFile,
                fmt::format("{}: holds more samples than it says; the file is corrupt", path.string()));
  return part;
}

std::string encode_part(const std::filesystem::path& path, const render::Film& film,
                        const std::vector<SampleRange>& ranges, image::Attributes attributes,
                        image::Channels channels, const image::Placement& placement) {
  render::add_film(film, channels, attributes);
  attributes[RANGES] = format_ranges(ranges);
  attributes[CHECKSUM] = checksum_of(attributes, channels, film.width, film.height, placement);
  return image::encode_exr(render::resolve(film), attributes, channels, placement, path.string());
}

std::vector<std::string> saturation_warnings(const render::Film& film) {
  std::vector<std::string> warnings;
  // What `earlier` and layers hold is in the sums themselves.
  for (const std::vector<uint32_t>* words : {&film.words, &film.splat_words, &film.square_words}) {
    const uint64_t count = render::count_saturated(*words);
    if (count == 0) continue;
    const bool is_squares = words == &film.square_words;
    const int exponent = is_squares ? film.exponents.squares : film.exponents.radiance;
    warnings.push_back(fmt::format("{} of the film's {} are beyond the {:.3g} that it holds: {}", count,
                                   is_squares             ? "sums of squares"
                                   : words == &film.words ? "sums"
                                                          : "sums of splats",
                                   std::ldexp(1.0, int{interface::FILM_RANGE_BITS} + exponent),
                                   is_squares ? "their variance is infinite" : "they show too little light"));
  }
  return warnings;
}

void require_same_render(const std::string& name, const image::Attributes& attributes,
                         const std::string& other_name, const image::Attributes& other) {
  const auto value_in = [](const image::Attributes& all, const std::string& key) {
    const auto found = all.find(key);
    return found == all.end() ? std::string("nothing") : found->second;
  };
  image::Attributes all = attributes;
  all.insert(other.begin(), other.end());
  for (const auto& entry : all) {
    const std::string& key = entry.first;
    if (!key.starts_with("regulus:") || OF_THE_RUN.contains(key) || is_a_reason(key)) continue;
    const std::string own = value_in(attributes, key), others = value_in(other, key);
    if (own != others)
      throw Error(ErrorCode::BadFile,
                  fmt::format("{} and {} are not samples of one render: {} is {} and {}", name, other_name,
                              key.substr(std::string("regulus:").size()), own, others));
  }
}

}  // namespace regulus::session
