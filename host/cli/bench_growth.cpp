#include "cli/bench_growth.hpp"

#include <fmt/format.h>

#include <memory>

#include "base/interrupt.hpp"
#include "base/standard_streams.hpp"
#include "bench/growth_page.hpp"
#include "cli/output_guard.hpp"
#include "cli/output_writer.hpp"
#include "cli/validators.hpp"

namespace regulus::cli {
namespace {

struct BenchGrowthOptions {
  bench::GrowthBudget budget;
  std::string json, html, device;
};

std::string exponent_text(const bench::GrowthSweep& sweep, double bench::GrowthPoint::*quantity) {
  const bench::PowerFit fit = fit_of(sweep, quantity);
  return fmt::format("{:.2f} +-{:.2f}, {:.2f}", fit.exponent, fit.deviation, fit.last);
}

void print_sweep(const bench::GrowthSweep& sweep) {
  say("{} ({})\n", sweep.name, sweep.text);
  for (const bench::GrowthPoint& point : sweep.points)
    say("  {:<12.6g} {:>20.4g} {:>20.4g} {:>20.4g}\n", point.size, point.render_seconds,
        point.prepare_seconds, point.device_bytes);
  say("  {:<12} {:>20} {:>20} {:>20}\n", "exponent",
      exponent_text(sweep, &bench::GrowthPoint::render_seconds),
      exponent_text(sweep, &bench::GrowthPoint::prepare_seconds),
      exponent_text(sweep, &bench::GrowthPoint::device_bytes));
  flush_stdout();
}

void run_bench_growth(BenchGrowthOptions& options) {
  bench::require_growth_names(options.budget.names);
  catch_interrupts();
  options.budget.is_interrupted = is_interrupted;
  OutputGuard guard;
  if (!options.json.empty()) guard.add_output("--json", options.json);
  if (!options.html.empty()) guard.add_output("--html", options.html);
  guard.require_places();
  gpu::Device device({.select = options.device, .software_stage_times = false});
  bench::GrowthReport report{fmt::format("{} ({})", device.info().name, device.info().driver),
                             device.info().kind == gpu::DeviceKind::Software,
                             {}};
  say("device: {}\n  {:<12} {:>20} {:>20} {:>20}\n", report.device, "size",
      report.is_cpu_time ? "render CPU s" : "render s", report.is_cpu_time ? "prepare CPU s" : "prepare s",
      "device bytes");
  measure_growth(device, options.budget, [&](const bench::GrowthSweep& sweep) {
    print_sweep(sweep);
    report.sweeps.push_back(sweep);
  });
  say("exponents: by least squares over all sizes with the standard error, then between the last two "
      "sizes\n");
  OutputWriter writer;
  if (!options.json.empty())
    writer.write(options.json, [&] { return bench::growth_json(report).dump(2) + "\n"; });
  if (!options.html.empty()) writer.write(options.html, [&] { return bench::growth_page(report); });
  writer.throw_failures();
}

}  // namespace

void add_bench_growth_command(CLI::App& bench) {
  CLI::App* growth = bench.add_subcommand(
      "growth",
      "Time and memory against pixels, samples, triangles, lights, depth, light paths and instances");
  const auto options = std::make_shared<BenchGrowthOptions>();
  growth->add_option("--sweeps", options->budget.names, "What grows, with commas between; all by default")
      ->type_name("NAME,...")
      ->delimiter(',');
  const auto is_quick = std::make_shared<bool>(false);
  CLI::Option* quick =
      growth->add_flag("--quick", *is_quick, "Small sizes: a minute of processor time (default)");
  growth->add_flag("--full", options->budget.is_full, "To 10^7 triangles, 10^6 lights and 10^5 instances")
      ->excludes(quick);
  growth->add_option("--repeats", options->budget.repeats, "Renders of each size; the least time counts")
      ->type_name("N")
      ->check(whole_number_in(1, 1000))
      ->capture_default_str();
  growth->add_option("--json", options->json, "Write what was measured as JSON")->type_name("FILE");
  growth->add_option("--html", options->html, "Write a page with plots")->type_name("FILE");
  growth->add_option("--device", options->device, "Index, uuid:... or part of the name of the Vulkan device")
      ->type_name("DEVICE");
  growth->callback([options, is_quick] { run_bench_growth(*options); });
}

}  // namespace regulus::cli
