#include "session/merge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

#include "base/error.hpp"
#include "render/aov.hpp"
#include "render/film_file.hpp"
#include "session/join_windows.hpp"

namespace regulus::session {

namespace {

void require_complete(const Part& part) {
  if (!part.is_complete())
    throw Error(
        ErrorCode::BadFile,
        fmt::format("{}: holds {} of its {} samples per pixel; resume it as a checkpoint to finish it",
                    part.path.string(), part.film.paths / part.film.pixels(), part.samples()));
}

// The films must have the same sums: settings that agree make them so, unless a file was tampered with.
void require_same_sums(const Part& a, const Part& b) {
  if (!render::have_same_sums(a.film, b.film))
    throw Error(ErrorCode::BadFile,
                fmt::format("{} and {} hold different kinds of sums, or in different units", a.path.string(),
                            b.path.string()));
}

/// A range and the file that holds it.
struct FiledRange {
  SampleRange range;
  std::string path;
};

// All ranges in ascending order, those that touch as one.
std::vector<SampleRange> join(std::vector<FiledRange> all) {
  std::ranges::sort(all, {}, [](const FiledRange& filed) { return filed.range.first; });
  std::vector<SampleRange> joined;
  for (size_t i = 0; i < all.size(); ++i) {
    const SampleRange& range = all[i].range;
    const uint64_t end = joined.empty() ? 0 : joined.back().first + joined.back().count;
    if (i > 0 && range.first < end)
      throw Error(ErrorCode::BadFile, fmt::format("{} and {} both hold sample {}; give each sample once",
                                                  all[i - 1].path, all[i].path, range.first));
    if (i > 0 && range.first == end)
      joined.back().count += range.count;
    else
      joined.push_back(range);
  }
  return joined;
}

/// Parts of one crop: their sums, and what each of them holds.
struct Window {
  Part sum;
  std::vector<FiledRange> ranges;
};

image::Attributes without_crop(image::Attributes attributes) {
  attributes.erase("regulus:crop");
  return attributes;
}

void add(const Part& part, Window& window) {
  if (window.sum.film.words.empty())
    window.sum = part;
  else
    render::add(window.sum.film, part.film);
  for (const SampleRange& range : part.ranges) window.ranges.push_back({range, part.path.string()});
}

// The samples of each crop, added up.
std::vector<Part> add_samples(const std::vector<std::filesystem::path>& files) {
  std::map<std::array<uint32_t, 4>, Window> windows;
  Part first;
  for (const std::filesystem::path& file : files) {
    Part part = read_part(file);
    require_complete(part);
    if (first.path.empty())
      first = part;
    else
      require_same_render(first.path.string(), without_crop(first.contents.attributes), part.path.string(),
                          without_crop(part.contents.attributes));
    require_same_sums(first, part);
    const image::Placement& place = part.contents.placement;
    add(part, windows[{place.y, place.x, part.film.width, part.film.height}]);
  }
  std::vector<Part> parts;
  for (auto& [place, window] : windows) {
    window.sum.ranges = join(std::move(window.ranges));
    parts.push_back(std::move(window.sum));
  }
  return parts;
}

}  // namespace

Part merge_parts(const std::vector<std::filesystem::path>& files) {
  Part sum = join_windows(add_samples(files));
  image::ExrContents& contents = sum.contents;
  const std::string samples = std::to_string(sum.film.paths / sum.film.pixels());
  contents.attributes["regulus:first_sample"] = std::to_string(sum.ranges.front().first);
  contents.attributes["regulus:samples"] = contents.attributes["regulus:samples_done"] = samples;
  for (const char* color : {"R", "G", "B"}) contents.channels.erase(color);
  render::add_film_channels(sum.film, render::parse_aovs(contents.attributes["regulus:aov"]),
                            contents.channels);
  return sum;
}

std::string encode(const Part& part, image::Format format, const std::filesystem::path& path) {
  if (format == image::Format::Exr)
    return encode_part(path, part.film, part.ranges, part.contents.attributes, part.contents.channels,
                       part.contents.placement);
  return image::encode_picture(format, render::resolve(part.film), 0, {}, {}, {}, path.string());
}

}  // namespace regulus::session
