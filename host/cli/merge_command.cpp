// regulus merge: joins sample ranges and crops of one render, exactly.

#include <fmt/format.h>

#include <memory>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "cli/commands.hpp"
#include "cli/output_guard.hpp"
#include "cli/output_writer.hpp"
#include "cli/validators.hpp"
#include "image/formats.hpp"
#include "session/merge.hpp"

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
  if (!fs::exists(options.output, ignored) || is_device_or_pipe(options.output)) return;
  if (session::is_part(options.output))
    throw Error(ErrorCode::BadUsage,
                fmt::format("{}: is a part itself, which OUTPUT would replace; name another output first, or "
                            "remove it",
                            options.output));
  if (!options.is_forced)
    throw Error(ErrorCode::BadUsage,
                fmt::format("{}: exists; name another output, or replace it with --force", options.output));
}

void merge(const MergeOptions& options) {
  require_free_output(options);
  const Format format =
      image::require_format("OUTPUT", options.output, {Format::Exr, Format::Png, Format::Jpeg, Format::Hdr});
  require_writable(options.output);
  const session::Part sum = session::merge_parts({options.parts.begin(), options.parts.end()});
  for (const std::string& warning : session::saturation_warnings(sum.film))
    fmt::print(stderr, "regulus: warning: {}: {}\n", options.output, warning);
  OutputWriter writer;
  writer.write(options.output, [&] { return encode(sum, format, options.output); });
  writer.throw_failures();
}

}  // namespace

void add_merge_command(CLI::App& app) {
  const auto options = std::make_shared<MergeOptions>();
  CLI::App* command = app.add_subcommand(
      "merge", "Join parts of a render (render --samples, --crop) into the image of all their samples");
  command
      ->add_option("OUTPUT", options->output,
                   "File to write: .exr, which is a part again, or only the picture as .png, .jpg or .hdr")
      ->type_name("FILE")
      ->required();
  command->add_option("PART", options->parts, "Files written by render --samples or by merge")
      ->type_name("FILE")
      ->required();
  command->add_flag("--force", options->is_forced, "Replace OUTPUT if it exists, unless it is a part");
  command->callback([options] { merge(*options); });
}

}  // namespace regulus::cli
