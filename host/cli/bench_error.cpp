#include "cli/bench_error.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <memory>
#include <sstream>

#include "base/error.hpp"
#include "base/interrupt.hpp"
#include "base/standard_streams.hpp"
#include "bench/error.hpp"
#include "bench/page.hpp"
#include "cli/bench_options.hpp"
#include "cli/bench_talk.hpp"
#include "cli/output_guard.hpp"
#include "cli/output_writer.hpp"
#include "cli/render_options.hpp"
#include "cli/validators.hpp"
#include "image/formats.hpp"

namespace regulus::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* REFERENCE_ERROR = "regulus:reference_relmse";
constexpr const char* DEFAULT_CONFIGS =
    "pt=-i pt --regularization none;pt regularized=-i pt --regularization roughness;"
    "bpt=-i bpt --regularization none;bpt regularized=-i bpt --regularization roughness;"
    "vcm=-i vcm --regularization none;vcm regularized=-i vcm --regularization roughness";

struct BenchErrorOptions {
  std::vector<std::string> scenes;
  std::string configs = DEFAULT_CONFIGS;
  std::string references;  ///< folder; empty: "reference" beside each scene
  std::string region;      ///< x0,y0,x1,y1; empty: the whole film
  std::string json, html;
  std::string device;
  bench::ErrorBudget budget;
};

struct BenchReferenceOptions {
  std::string scene, output, size = "256x256", options = "-i vcm --regularization none --seed 1001", device;
  bench::ErrorBudget budget;
};

std::vector<BenchConfig> parse_configs(const std::string& list) {
  std::vector<BenchConfig> configs;
  std::istringstream stream(list);
  for (std::string entry; std::getline(stream, entry, ';');) {
    if (entry.empty()) continue;
    const size_t equals = entry.find('=');
    configs.push_back(equals == std::string::npos
                          ? BenchConfig{entry, entry}
                          : BenchConfig{entry.substr(0, equals), entry.substr(equals + 1)});
  }
  if (configs.empty()) throw Error(ErrorCode::BadUsage, "--configs: the list is empty");
  return configs;
}

fs::path reference_file(const std::string& scene, const std::string& folder) {
  const fs::path path(scene);
  return (folder.empty() ? path.parent_path() / "reference" : fs::path(folder)) /
         path.stem().replace_extension(".exr");
}

void print_run(const bench::ErrorRun& run) {
  const bench::ErrorPoint& last = run.points.back();
  say("  {:<28} {:>8.1f} {:>8.2f} {:>8.2f} {:>10.3g} {:>10.3g} {:>10.3g} {:>10.3g} {:>10.3g} {:>10.3g} "
      "{:>8.4f}\n",
      run.name, last.samples, last.seconds, last.cpu_seconds, run.mse, run.relmse, run.trimmed_relmse,
      run.flip, run.variance, run.squared_bias, run.mean_ratio);
  flush_stdout();
}

// The bound on contributions under which runs of `settings` vary as much as `variance` says. The variance
// grows with the bound, over the decades in which samples lie.
float matching_clamp(gpu::Device& device, const bench::ErrorSubject& subject, render::RenderSettings settings,
                     bench::ErrorBudget budget, double variance) {
  constexpr int STEPS = 8;
  double low = -2, high = 4;  // log10; 8 steps leave 6 / 256 of a decade
  budget.seeds = 2;
  for (int step = 0; step < STEPS; ++step) {
    const double middle = 0.5 * (low + high);
    settings.largest_contribution = static_cast<float>(std::pow(10, middle));
    (bench::measure_error(device, subject, settings, budget).variance > variance ? high : low) = middle;
  }
  return static_cast<float>(std::pow(10, 0.5 * (low + high)));
}

double variance_of(const std::vector<bench::ErrorRun>& runs, const std::string& name) {
  return std::ranges::find(runs, name, &bench::ErrorRun::name)->variance;
}

bench::Section measure_section(gpu::Device& device, const BenchComparison& comparison,
                               const BenchErrorOptions& options) {
  bench::Section section{comparison.title, comparison.text, comparison.scene, {}, 0, 0, {}};
  const fs::path file = reference_file(comparison.scene, options.references);
  image::Attributes attributes;
  const image::Image whole = image::read_exr(file, &attributes);
  const std::string& error = attributes[REFERENCE_ERROR];
  if (std::from_chars(error.data(), error.data() + error.size(), section.reference_relmse).ec != std::errc{})
    section.reference_relmse = std::numeric_limits<double>::quiet_NaN();

  render::Window region;
  if (!options.region.empty())
    region = session::parse_window("region", options.region, {whole.width, whole.height});

  const PreparedScene prepared = prepare(scene::load(comparison.scene, {}));
  say("{} ({}), {}x{}; expected relmse of the reference {:.3g}\n", section.title, section.scene, whole.width,
      whole.height, section.reference_relmse);
  say("  {:<28} {:>8} {:>8} {:>8} {:>10} {:>10} {:>10} {:>10} {:>10} {:>10} {:>8}\n", "", "samples",
      "seconds", "CPU s", "mse", "relmse", "trimmed", "flip", "variance", "bias^2", "mean");
  const std::string size = fmt::format("{}x{}", whole.width, whole.height);
  const bench::ErrorSubject subject{prepared, whole, region};
  section.reference = bench::measured_reference(subject);
  bench::ErrorBudget budget = options.budget;
  if (comparison.samples != 0 && budget.samples == 0) budget.samples = comparison.samples;
  for (const BenchConfig& config : comparison.configs) {
    ResolvedOptions render = resolve_render_options(config.options, size, prepared);
    section.exposure_ev = render.exposure_ev;
    std::string clamp;
    if (!config.clamped_like.empty()) {
      render.settings.largest_contribution = matching_clamp(device, subject, render.settings, budget,
                                                            variance_of(section.runs, config.clamped_like));
      clamp = fmt::format(" --clamp {:.3g}", render.settings.largest_contribution);
    }
    bench::ErrorRun run = bench::measure_error(device, subject, render.settings, budget);
    run.name = config.name;
    run.options = config.options + clamp;
    print_run(run);
    section.runs.push_back(std::move(run));
  }
  return section;
}

// What can be known to be wrong before anything is rendered.
void require_valid(const BenchComparison& comparison, const BenchErrorOptions& options, OutputGuard& guard) {
  const fs::path file = reference_file(comparison.scene, options.references);
  if (!fs::exists(file))
    throw Error(ErrorCode::BadFile,
                fmt::format("{}: no such reference; make it with: regulus bench reference {} -o {}",
                            file.string(), comparison.scene, file.string()));
  for (const BenchConfig& config : comparison.configs) {
    require_render_options(config.options, comparison.scene);
  }
  guard.add_scene(comparison.scene);
  guard.add_input(file, "a reference");
}

// JSON and page, as far as they are asked for.
OutputWriter write_report(const BenchErrorOptions& options, const bench::Report& report) {
  OutputWriter writer;
  if (!options.json.empty())
    writer.write(options.json, [&] { return bench::report_json(report).dump(2) + "\n"; });
  if (!options.html.empty()) writer.write(options.html, [&] { return bench::page_of(report); });
  return writer;
}

void run_comparisons(const std::string& title, const std::vector<BenchComparison>& comparisons,
                     BenchErrorOptions& options) {
  OutputGuard guard;
  if (!options.json.empty()) guard.add_output("--json", options.json);
  if (!options.html.empty()) guard.add_output("--html", options.html);
  for (const BenchComparison& comparison : comparisons) require_valid(comparison, options, guard);
  guard.require_places();
  catch_interrupts();
  options.budget.is_interrupted = is_interrupted;
  gpu::Device device({.select = options.device, .software_stage_times = false});
  bench::Report report{title,
                       fmt::format("{} ({})", device.info().name, device.info().driver),
                       fmt::format("{} seeds{}; times without compiling kernels.", options.budget.seeds,
                                   options.budget.samples != 0
                                       ? fmt::format(", {} samples per pixel", options.budget.samples)
                                       : fmt::format(", {} {}s of rendering each", options.budget.seconds,
                                                     options.budget.counts_cpu_time ? "CPU " : "")),
                       {}};
  if (options.budget.samples != 0)
    report.axis = "samples";
  else if (options.budget.counts_cpu_time)
    report.axis = "cpu_seconds";
  say("device: {}\n", report.device);
  for (const BenchComparison& comparison : comparisons) {
    report.sections.push_back(measure_section(device, comparison, options));
    // After each scene, so that an interrupted run leaves what it measured.
    const OutputWriter writer = write_report(options, report);
    if (report.sections.size() == comparisons.size()) writer.throw_failures();
    if (writer.has_failed()) spdlog::warn("{}; it goes on", writer.failures());
  }
}

void run_bench_error(BenchErrorOptions& options) {
  std::vector<BenchComparison> comparisons;
  for (const std::string& scene : options.scenes)
    comparisons.push_back({fs::path(scene).stem().string(), "", scene, parse_configs(options.configs)});
  run_comparisons("Regulus: error against time", comparisons, options);
}

void run_bench_reference(BenchReferenceOptions& options) {
  catch_interrupts();
  options.budget.is_interrupted = is_interrupted;
  const fs::path file = options.output.empty() ? reference_file(options.scene, "") : fs::path(options.output);
  std::error_code ignored;
  if (file.has_parent_path()) fs::create_directories(file.parent_path(), ignored);
  image::require_format("--output", file, {image::Format::Exr});
  const PreparedScene prepared = prepare(scene::load(options.scene, {}));
  OutputGuard guard;
  guard.add_scene(options.scene);
  guard.add_output("--output", file);
  guard.require_places();
  const ResolvedOptions render = resolve_render_options(options.options, options.size, prepared);
  gpu::Device device({.select = options.device, .software_stage_times = false});
  const bench::Reference reference = bench::make_reference(device, prepared, render.settings, options.budget);
  OutputWriter writer;
  writer.write(file, [&] {
    return image::encode_exr(
        reference.image,
        {{"regulus:options", options.options}, {REFERENCE_ERROR, fmt::format("{:.6g}", reference.relmse)}},
        {}, {}, file.string());
  });
  writer.throw_failures();
  say("{}: {} independent renders, expected relmse {:.3g}\n", file.string(), options.budget.seeds,
      reference.relmse);
}

void declare_budget(CLI::App& command, bench::ErrorBudget& budget) {
  command.add_option("--time", budget.seconds, "Seconds of rendering for each seed")
      ->type_name("SECONDS")
      ->check(number_in(0.01, 1e6))
      ->capture_default_str();
  command.add_flag(
      "--cpu-time", budget.counts_cpu_time,
      "Count CPU seconds of this process, which is fair on a busy machine; for software devices");
  command.add_option("-s,--spp", budget.samples, "Samples per pixel for each seed, instead of a time")
      ->type_name("N")
      ->check(whole_number_in(1, session::MAX_SAMPLES));
  command.add_option("--seeds", budget.seeds, "Independent renders")
      ->type_name("N")
      ->check(whole_number_in(2, 1000))
      ->capture_default_str();
}

void declare_outputs(CLI::App& command, BenchErrorOptions& options) {
  command
      .add_option(
          "--references", options.references,
          "Folder of the references, NAME.exr for NAME.gltf (default: \"reference\" beside each scene)")
      ->type_name("FOLDER");
  command
      .add_option("--region", options.region,
                  "Measure only these pixels of each scene; whole pictures are rendered")
      ->type_name("x0,y0,x1,y1");
  command.add_option("--json", options.json, "Write what was measured as JSON")->type_name("FILE");
  command.add_option("--html", options.html, "Write a page with plots and pictures")->type_name("FILE");
  command.add_option("--device", options.device, "Index, uuid:... or part of the name of the Vulkan device")
      ->type_name("DEVICE");
  declare_budget(command, options.budget);
}

}  // namespace

void add_bench_error_commands(CLI::App& bench) {
  CLI::App* error =
      bench.add_subcommand("error", "Error, bias and variance against time, for several settings");
  const auto error_options = std::make_shared<BenchErrorOptions>();
  error->add_option("--scenes", error_options->scenes, "glTF files")->type_name("SCENE")->required();
  error
      ->add_option("--configs", error_options->configs,
                   "What to compare: NAME=OPTIONS;NAME=OPTIONS... with options of render")
      ->type_name("NAME=OPTIONS;...")
      ->capture_default_str();
  declare_outputs(*error, *error_options);
  error->callback([error_options] { run_bench_error(*error_options); });

  CLI::App* reference = bench.add_subcommand(
      "reference", "Make the reference image of a scene, with an estimate of its own error");
  const auto reference_options = std::make_shared<BenchReferenceOptions>();
  reference->add_option("SCENE", reference_options->scene, "glTF file")->type_name("FILE")->required();
  reference
      ->add_option("-o,--output", reference_options->output,
                   "EXR to write (default: reference/NAME.exr beside the scene)")
      ->type_name("FILE");
  reference->add_option("--size", reference_options->size, "Size of the film in pixels")
      ->type_name("WIDTHxHEIGHT")
      ->capture_default_str();
  reference->add_option("--options", reference_options->options, "Options of render")
      ->type_name("OPTIONS")
      ->capture_default_str();
  reference
      ->add_option("--device", reference_options->device,
                   "Index, uuid:... or part of the name of the Vulkan device")
      ->type_name("DEVICE");
  declare_budget(*reference, reference_options->budget);
  reference->callback([reference_options] { run_bench_reference(*reference_options); });

  CLI::App* talk = bench.add_subcommand("talk", "The comparisons of the talk on regularization, as a page");
  const auto talk_options = std::make_shared<BenchErrorOptions>();
  const auto folder = std::make_shared<std::string>("scenes");
  talk->add_option("--folder", *folder, "Folder of the scenes")->type_name("FOLDER")->capture_default_str();
  declare_outputs(*talk, *talk_options);
  talk->callback([talk_options, folder] {
    run_comparisons("Regulus: microfacet regularization", talk_comparisons(*folder), *talk_options);
  });
}

}  // namespace regulus::cli
