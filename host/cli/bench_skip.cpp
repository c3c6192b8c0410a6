#include "cli/bench_skip.hpp"

#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "base/interrupt.hpp"
#include "base/standard_streams.hpp"
#include "bench/skip.hpp"
#include "cli/bench_options.hpp"
#include "cli/output_guard.hpp"
#include "cli/output_writer.hpp"
#include "cli/validators.hpp"

namespace regulus::cli {
namespace {

struct BenchSkipOptions {
  std::string scene, options = "-i pt -s 16", size = "128x128", json, device;
  bench::SkipBudget budget;
};

nlohmann::json json_of(const bench::SkipReport& report) {
  nlohmann::json features = nlohmann::json::array();
  for (const bench::SkippedFeature& feature : report.features)
    features.push_back({{"name", feature.name},
                        {"time_ratio", feature.time_ratio},
                        {"least_ratio", feature.least_ratio},
                        {"greatest_ratio", feature.greatest_ratio},
                        {"bytes", feature.bytes},
                        {"bytes_per_path", feature.bytes_per_path}});
  return {{"cpu_seconds", report.seconds},
          {"noise", report.noise},
          {"bytes_per_path", report.bytes_per_path},
          {"features", features}};
}

void run_bench_skip(BenchSkipOptions& options) {
  catch_interrupts();
  options.budget.is_interrupted = is_interrupted;
  const scene::Scene scene = scene::load(options.scene, {});
  OutputGuard guard;
  guard.add_scene(options.scene);
  if (!options.json.empty()) guard.add_output("--json", options.json);
  guard.require_places();
  const ResolvedOptions render = resolve_render_options(options.options, options.size, prepare(scene));
  gpu::Device device({.select = options.device, .software_stage_times = false});
  if (device.info().kind != gpu::DeviceKind::Software)
    throw Error(
        ErrorCode::BadUsage,
        fmt::format(
            "bench skip counts CPU seconds, and {} does not compute on the CPU; choose another --device",
            device.info().name));
  const bench::SkipReport report = bench::measure_skipped(device, scene, render.settings, options.budget);
  say("device: {}\n{}, {}: {:.2f} CPU s, {} bytes per path; against itself +-{:.1f} %\n", device.info().name,
      options.scene, options.options, report.seconds, report.bytes_per_path, 100 * report.noise);
  say("{:<20} {:>8} {:>16} {:>12} {:>14}\n", "present but unused", "time", "least..greatest", "bytes",
      "bytes per path");
  for (const bench::SkippedFeature& feature : report.features)
    say("{:<20} {:>7.3f}x {:>7.3f}..{:<7.3f} {:>+12} {:>14}\n", feature.name, feature.time_ratio,
        feature.least_ratio, feature.greatest_ratio, feature.bytes, feature.bytes_per_path);
  OutputWriter writer;
  if (!options.json.empty()) writer.write(options.json, [&] { return json_of(report).dump(2) + "\n"; });
  writer.throw_failures();
}

}  // namespace

void add_bench_skip_command(CLI::App& bench) {
  CLI::App* skip = bench.add_subcommand(
      "skip", "Time and memory that it saves to compile away each feature that a scene lacks");
  const auto options = std::make_shared<BenchSkipOptions>();
  skip->add_option("SCENE", options->scene, "glTF file")->type_name("FILE")->required();
  skip->add_option("--options", options->options, "Options of render")
      ->type_name("OPTIONS")
      ->capture_default_str();
  skip->add_option("--size", options->size, "Size of the film in pixels")
      ->type_name("WIDTHxHEIGHT")
      ->capture_default_str();
  skip->add_option("--repeats", options->budget.repeats,
                   "Pairs of renders for each feature; the median of their ratios counts")
      ->type_name("N")
      ->check(whole_number_in(1, 1000))
      ->capture_default_str();
  skip->add_option("--json", options->json, "Write what was measured as JSON")->type_name("FILE");
  skip->add_option("--device", options->device, "Index, uuid:... or part of the name of the Vulkan device")
      ->type_name("DEVICE");
  skip->callback([options] { run_bench_skip(*options); });
}

}  // namespace regulus::cli
