// regulus merge: joins sample ranges of one render, exactly.

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "base/error.hpp"
#include "cli/commands.hpp"
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
  if (a.film.words.size() != b.film.words.size() || a.film.splat_words.size() != b.film.splat_words.size() ||
      a.film.earlier_words.size() != b.film.earlier_words.size() ||
      a.film.square_words.size() != b.film.square_words.size())
    throw Error(ExitStatus::BadFile,
                fmt::format("{} and {} hold different kinds of sums", a.path.string(), b.path.string()));
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

void merge(const MergeOptions& options) {
  require_free_output(options);
  const Format format =
      image::require_format("OUTPUT", options.output, {Format::Exr, Format::Png, Format::Jpeg, Format::Hdr});
  image::require_writable(options.output);
  Part sum = read_part(options.parts.front());
  require_complete(sum);
  std::vector<FiledRange> ranges;
  const auto file = [&](const Part& part) {
    for (const SampleRange& range : part.ranges) ranges.push_back({range, part.path.string()});
  };
  file(sum);
  for (size_t i = 1; i < options.parts.size(); ++i) {
    const Part part = read_part(options.parts[i]);
    require_complete(part);
    require_same_render(sum.path.string(), sum.contents.attributes, part.path.string(),
                        part.contents.attributes);
    require_same_sums(sum, part);
    render::add(sum.film, part.film);
    file(part);
  }
  const std::vector<SampleRange> joined = join(std::move(ranges));

  image::ExrContents& contents = sum.contents;
  const std::string samples = std::to_string(sum.film.paths / sum.film.pixels());
  contents.attributes["regulus:first_sample"] = std::to_string(joined.front().first);
  contents.attributes["regulus:samples"] = contents.attributes["regulus:samples_done"] = samples;
  for (const char* color : {"R", "G", "B"}) contents.channels.erase(color);
  render::add_film_channels(sum.film, render::parse_aovs(contents.attributes["regulus:aov"]),
                            contents.channels);
  OutputWriter writer;
  writer.write(options.output, [&] {
    if (format == Format::Exr)
      return encode_part(options.output, sum.film, joined, contents.attributes, contents.channels,
                         contents.placement);
    return image::encode_picture(format, render::resolve(sum.film), 0, {}, {}, {}, options.output);
  });
  writer.throw_failures();
}

}  // namespace

void add_merge_command(CLI::App& app) {
  const auto options = std::make_shared<MergeOptions>();
  CLI::App* command = app.add_subcommand(
      "merge", "Join parts of a render (render --samples) into the image of all their samples");
  command
      ->add_option("OUTPUT", options->output,
                   "File to write: .exr, which is a part again, or a picture alone in .png, .jpg, .hdr")
      ->required();
  command->add_option("PART", options->parts, "Files written by render --samples or by merge")->required();
  command->add_flag("--force", options->is_forced, "Replace OUTPUT if it exists, unless it is a part");
  command->callback([options] { merge(*options); });
}

}  // namespace regulus::cli
