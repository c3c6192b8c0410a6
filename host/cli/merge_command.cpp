// regulus merge: joins sample ranges and crops of one render, exactly.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>

#include "base/error.hpp"
#include "cli/commands.hpp"
#include "cli/join_windows.hpp"
#include "cli/output_guard.hpp"
#include "cli/output_writer.hpp"
#include "cli/part.hpp"
#include "cli/validators.hpp"
#include "image/atomic_file.hpp"
#include "image/formats.hpp"
#include "render/aov.hpp"
#include "render/film_file.hpp"

namespace regulus::cli {

namespace fs = std::filesystem;
using image::Format;

namespace {

struct MergeOptions {
  std::string output;
  std::vector<std::string> parts;
  bool is_forced = false;
};

// A part is hours of work, and `merge A B` most often lacks the name of the output.
void require_free_output(const MergeOptions& options) {
  OutputGuard guard;
  for (const std::string& part : options.parts) guard.add_input(part, "one of the parts");
  guard.add_output("OUTPUT", options.output);
  std::error_code ignored;
  if (!fs::exists(options.output, ignored) || image::is_device_or_pipe(options.output)) return;
  if (is_part(options.output))
    throw Error(ExitStatus::BadUsage,
                fmt::format("{}: is a part itself, which OUTPUT would replace; name another output first, or "
                            "remove it",
                            options.output));
  if (!options.is_forced)
    throw Error(ExitStatus::BadUsage,
                fmt::format("{}: exists; name another output, or replace it with --force", options.output));
}

void require_complete(const Part& part) {
  if (!part.is_complete())
    throw Error(
        ExitStatus::BadFile,
        fmt::format("{}: holds {} of its {} samples per pixel; finish it with --checkpoint {} --resume",
                    part.path.string(), part.film.paths / part.film.pixels(), part.samples(),
                    part.path.string()));
}

// The films must have the same sums: settings that agree make them so, unless a file was tampered with.
void require_same_sums(const Part& a, const Part& b) {
  const auto differ = [](const std::vector<uint32_t>& x, const std::vector<uint32_t>& y) {
    return x.empty() != y.empty();  // their lengths follow from the crop
  };
  if (differ(a.film.splat_words, b.film.splat_words) || differ(a.film.earlier_words, b.film.earlier_words) ||
      differ(a.film.square_words, b.film.square_words))
    throw Error(ExitStatus::BadFile,
                fmt::format("{} and {} hold different kinds of sums", a.path.string(), b.path.string()));
  if (a.film.exponents != b.film.exponents)
    throw Error(ExitStatus::BadFile,
                fmt::format("{} and {} hold sums in different units", a.path.string(), b.path.string()));
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
      throw Error(ExitStatus::BadFile, fmt::format("{} and {} both hold sample {}; give each sample once",
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
std::vector<Part> add_samples(const std::vector<std::string>& files) {
  std::map<std::array<uint32_t, 4>, Window> windows;
  Part first;
  for (const std::string& file : files) {
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

void merge(const MergeOptions& options) {
  require_free_output(options);
  const Format format =
      image::require_format("OUTPUT", options.output, {Format::Exr, Format::Png, Format::Jpeg, Format::Hdr});
  image::require_writable(options.output);
  Part sum = join_windows(add_samples(options.parts));

  for (const std::string& warning : saturation_warnings(sum.film))
    fmt::print(stderr, "regulus: warning: {}: {}\n", options.output, warning);

  image::ExrContents& contents = sum.contents;
  const std::string samples = std::to_string(sum.film.paths / sum.film.pixels());
  contents.attributes["regulus:first_sample"] = std::to_string(sum.ranges.front().first);
  contents.attributes["regulus:samples"] = contents.attributes["regulus:samples_done"] = samples;
  for (const char* color : {"R", "G", "B"}) contents.channels.erase(color);
  render::add_film_channels(sum.film, render::parse_aovs(contents.attributes["regulus:aov"]),
                            contents.channels);
  OutputWriter writer;
  writer.write(options.output, [&] {
    if (format == Format::Exr)
      return encode_part(options.output, sum.film, sum.ranges, contents.attributes, contents.channels,
                         contents.placement);
    return image::encode_picture(format, render::resolve(sum.film), 0, {}, {}, {}, options.output);
  });
  writer.throw_failures();
}

}  // namespace

void add_merge_command(CLI::App& app) {
  const auto options = std::make_shared<MergeOptions>();
  CLI::App* command = app.add_subcommand(
      "merge", "Join parts of a render (render --samples, --crop) into the image of all their samples");
  command
      ->add_option("OUTPUT", options->output,
                   "File to write: .exr, which is a part again, or a picture alone in .png, .jpg, .hdr")
      ->type_name("FILE")
      ->required();
  command->add_option("PART", options->parts, "Files written by render --samples or by merge")
      ->type_name("FILE")
      ->required();
  command->add_flag("--force", options->is_forced, "Replace OUTPUT if it exists, unless it is a part");
  command->callback([options] { merge(*options); });
}

}  // namespace regulus::cli
