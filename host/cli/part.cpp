#include "cli/part.hpp"

#include <fmt/format.h>

#include <charconv>
#include <numeric>
#include <set>

#include "base/error.hpp"
#include "render/film_file.hpp"

namespace regulus::cli {

namespace {

constexpr const char* RANGES = "regulus:sample_ranges";

// What may differ between samples of one render: which they are, where they were rendered, and under which
// name the scene lay there (its hash counts).
const std::set<std::string> OF_THE_RUN = {"regulus:first_sample",
                                          "regulus:samples",
                                          "regulus:samples_done",
                                          "regulus:sample_ranges",
                                          "regulus:paths",
                                          "regulus:light_paths_done",
                                          "regulus:light_paths_per_iteration",
                                          "regulus:device",
                                          "regulus:driver",
                                          "regulus:render_seconds",
                                          "regulus:non_finite",
                                          "regulus:scene"};

// "0:16,32:16"
std::vector<SampleRange> parse_ranges(const std::filesystem::path& path, const std::string& text) {
  std::vector<SampleRange> ranges;
  const char* at = text.data();
  const char* const end = at + text.size();
  uint64_t free = 0;  // the first sample that may come next
  const auto fail = [&] {
    throw Error(ExitStatus::BadFile,
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

Part read_part(const std::filesystem::path& path) {
  Part part;
  part.path = path;
  part.contents = image::read_exr_contents(path);
  part.film = render::take_film(path, part.contents);
  const auto ranges = part.contents.attributes.find(RANGES);
  part.ranges = parse_ranges(path, ranges == part.contents.attributes.end() ? std::string() : ranges->second);
  if (part.film.paths > part.samples() * part.film.pixels())
    throw Error(ExitStatus::BadFile,
                fmt::format("{}: holds more samples than it says; the file is corrupt", path.string()));
  return part;
}

void write_part(const std::filesystem::path& path, const render::Film& film,
                const std::vector<SampleRange>& ranges, image::Attributes attributes,
                image::Channels channels, const image::Placement& placement) {
  render::add_film(film, channels, attributes);
  attributes[RANGES] = format_ranges(ranges);
  image::write_exr(path, render::resolve(film), attributes, channels, placement);
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
    if (!key.starts_with("regulus:") || OF_THE_RUN.contains(key)) continue;
    const std::string own = value_in(attributes, key), others = value_in(other, key);
    if (own != others)
      throw Error(ExitStatus::BadFile,
                  fmt::format("{} and {} are not samples of one render: {} is {} and {}", name, other_name,
                              key.substr(std::string("regulus:").size()), own, others));
  }
}

}  // namespace regulus::cli
