// regulus farm: a render in parts, as a job of Slurm, GNU parallel or a shell. Nothing of ours schedules.

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <set>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/shell_words.hpp"
#include "base/standard_streams.hpp"
#include "cli/commands.hpp"
#include "cli/farm_script.hpp"
#include "cli/frames.hpp"
#include "cli/output_guard.hpp"
#include "cli/render_options.hpp"
#include "cli/validators.hpp"
#include "image/formats.hpp"
#include "scene/scene.hpp"
#include "session/request.hpp"

namespace regulus::cli {

namespace {

namespace fs = std::filesystem;

constexpr uint64_t MOST_PARTS = 100'000;

struct FarmOptions : RenderOptions {
  uint64_t parts = 0;
  std::string scheduler, script;
  std::set<std::string> refused;  // options of `render` that one process alone can take
};

// What the script itself says to every task.
const std::set<std::string> OWN = {"output", "spp", "frames", "parts", "for", "script"};

// Outputs make sense for each task, or for the merged picture alone, if they carry no file's name.
const std::set<std::string> OUTPUTS_OF_EACH = {"output", "aov", "quiet", "verbose"};
const std::set<std::string> OF_ONE_PROCESS = {"samples", "checkpoint", "resume", "time", "noise"};

// Takes what makes no sense for tasks out of the help, and notes it.
void refuse_options_of_one_process(CLI::App& command, FarmOptions& options) {
  for (CLI::Option* option : command.get_options([](const CLI::Option*) { return true; })) {
    if (option->get_lnames().empty()) continue;
    const std::string& name = option->get_lnames().front();
    if (OF_ONE_PROCESS.contains(name) ||
        (option->get_group() == "Output" && !OUTPUTS_OF_EACH.contains(name))) {
      options.refused.insert(name);
      option->group("");
    }
  }
}

// The options that the command line gives, as words for `render`.
std::vector<std::string> words_for_render(const CLI::App& command, const FarmOptions& options) {
  std::vector<std::string> words;
  for (const CLI::Option* option : command.get_options()) {
    if (option->count() == 0 || option->get_lnames().empty()) continue;
    const std::string& name = option->get_lnames().front();
    if (options.refused.contains(name))
      throw Error(ErrorCode::BadUsage,
                  fmt::format("--{}: is not for a farm, whose parts are ranges of samples or frames", name));
    if (OWN.contains(name)) continue;
    if (option->get_items_expected_max() == 0)
      words.push_back("--" + name);
    else
      for (const std::string& value : option->results()) words.push_back(fmt::format("--{}={}", name, value));
  }
  return words;
}

// What there is to divide, once the scene's settings are known.
void take_range(const FarmOptions& options, FarmJob& job) {
  const std::vector<Frame> frames = parse_frames(options);
  job.has_frames = !frames.empty();
  job.first = job.has_frames ? frames.front().number : 0;
  job.count = job.has_frames ? frames.size() : options.settings.samples;
  job.parts = options.parts;
  if (job.parts > job.count)
    throw Error(ErrorCode::BadUsage,
                fmt::format("--parts {}: there are {} {}; ask for at most as many parts", job.parts,
                            job.count, job.has_frames ? "frames" : "samples"));
}

void require_parts(const FarmOptions& options) {
  if (options.backend == "reference")
    throw Error(ErrorCode::BadUsage, "--backend reference: writes no parts and no checkpoints");
  if (options.time_limit || options.noise_target)
    throw Error(
        ErrorCode::BadUsage,
        fmt::format("{}: asks for a time or a noise, but parts are ranges of samples; give -s and remove "
                    "that from its extras.regulus",
                    options.scene_file));
}

void write_job(CLI::App& command, FarmOptions& options) {
  FarmJob job{.scheduler = options.scheduler,
              .program = fs::read_symlink("/proc/self/exe").string(),
              .folder = fs::current_path().string(),
              .scene = options.scene_file,
              .output = options.output,
              .options = words_for_render(command, options)};
  const fs::path script = options.script.empty() ? fs::path(options.output).replace_extension(".farm.sh")
                                                 : fs::path(options.script);
  image::require_format("--output", options.output, {image::Format::Exr});
  const scene::Scene scene = scene::load(options.scene_file, load_options(options));
  apply_scene_settings(command, scene);
  require_parts(options);
  resolve_settings(options, scene);  // what is wrong with them is better known now
  take_range(options, job);
  OutputGuard guard;
  guard.add_scene(options.scene_file);
  if (!options.environment.empty()) guard.add_input(options.environment, "the environment");
  guard.add_output("--output", options.output);
  guard.add_output("--script", script);
  guard.require_places();
  write_file_atomically(script, farm_script(job));
  say("{}: {} {} in {} parts; begin with: sh {}\n", script.string(), job.count,
      job.has_frames ? "frames" : "samples", job.parts, shell_word(not_an_option(script.string())));
}

}  // namespace

void add_farm_command(CLI::App& app) {
  const auto options = std::make_shared<FarmOptions>();
  CLI::App* command = app.add_subcommand(
      "farm", "Write a script that renders a scene in parts, on many machines, and joins them");
  declare_render_options(*command, *options);
  refuse_options_of_one_process(*command, *options);
  command->get_option("--output")
      ->description("Picture that the parts are joined to (.exr); of frames, as render names them")
      ->required();
  command
      ->add_option("--parts", options->parts,
                   "Number of tasks: ranges of samples, or with --frames of frames")
      ->type_name("N")
      ->required()
      ->check(whole_number_in(1, MOST_PARTS));
  command
      ->add_option("--for", options->scheduler, "What runs the tasks: Slurm, GNU parallel, or just a shell")
      ->type_name("slurm|parallel|shell")
      ->required()
      ->check(one_of({"slurm", "parallel", "shell"}));
  command
      ->add_option("--script", options->script,
                   "The script to write (default: the output's name with .farm.sh)")
      ->type_name("FILE");
  command->callback([command, options] { write_job(*command, *options); });
}

}  // namespace regulus::cli
