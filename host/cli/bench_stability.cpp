#include "cli/bench_stability.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/interrupt.hpp"
#include "base/standard_streams.hpp"
#include "bench/stability_page.hpp"
#include "cli/output_guard.hpp"
#include "cli/output_writer.hpp"

namespace regulus::cli {
namespace {

struct BenchStabilityOptions {
  bool is_quick = false, is_full = false;
  std::vector<std::string> families;
  std::string json, html, device;
};

std::string range_text(const stability::Sweep& sweep) {
  const auto [from, to] = sweep.accurate_range(0.01);
  return from > 0 ? fmt::format("{:.1e} .. {:.1e}", from, to) : "nowhere";
}

void print_report(const stability::Report& report) {
  say("device: {}\n{:<48} {:>7} {:>9} {:>6} {:>9} {:>6}  {:<20} {:>6} {:>6}\n", report.device, "", "cases",
      "device", "bound", "reference", "bound", "device within 1 %", "lost", "");
  std::string family;
  for (const stability::Sweep& sweep : report.sweeps) {
    if (sweep.text().family != family) say("{}\n", sweep.text().family);
    family = sweep.text().family;
    say("  {:<46} {:>7} {:>9.1e} {:>6.2f} {:>9.1e} {:>6.2f}  {:<20} {:>6} {:>6}\n", sweep.text().name,
        sweep.cases(), sweep.worst_device(), sweep.device_ratio(), sweep.worst_reference(),
        sweep.reference_ratio(), range_text(sweep), sweep.lost(), sweep.holds() ? "" : "BROKEN");
    if (sweep.holds()) continue;
    say("    not finite: {} on the device, {} in the reference\n    worst on the device: {}\n    worst in "
        "the reference: {}\n",
        sweep.non_finite_device(), sweep.non_finite_reference(), sweep.worst_case(),
        sweep.worst_reference_case());
  }
}

void run_bench_stability(const BenchStabilityOptions& options) {
  catch_interrupts();
  OutputGuard guard;
  if (!options.json.empty()) guard.add_output("--json", options.json);
  if (!options.html.empty()) guard.add_output("--html", options.html);
  guard.require_places();
  gpu::Device device({.select = options.device, .software_stage_times = false});
  const stability::Report report =
      stability::measure(device, options.is_full ? stability::Extent::Full : stability::Extent::Quick,
                         options.families, is_interrupted);
  print_report(report);
  OutputWriter writer;
  if (!options.json.empty())
    writer.write(options.json, [&] { return bench::stability_json(report).dump(2) + "\n"; });
  if (!options.html.empty()) writer.write(options.html, [&] { return bench::stability_page(report); });
  writer.throw_failures();
  const auto broken = std::count_if(report.sweeps.begin(), report.sweeps.end(),
                                    [](const stability::Sweep& sweep) { return !sweep.holds(); });
  if (broken > 0)
    throw Error(
        ErrorCode::Failed,
        fmt::format("bench stability: {} of {} sweeps leave their bounds on {}; their worst cases are above",
                    broken, report.sweeps.size(), report.device));
}

}  // namespace

void add_bench_stability_command(CLI::App& bench) {
  CLI::App* command = bench.add_subcommand("stability",
                                           "Errors of device and reference up to where their arithmetic "
                                           "ends, against closed forms and more digits");
  const auto options = std::make_shared<BenchStabilityOptions>();
  CLI::Option* quick = command->add_flag("--quick", options->is_quick,
                                         "Few points in each sweep: takes seconds (the default)");
  command->add_flag("--full", options->is_full, "Many points and all models: takes minutes")->excludes(quick);
  command->add_option("--families", options->families, "Sweep only these families")
      ->type_name("LIST")
      ->delimiter(',')
      ->check(CLI::IsMember(stability::family_names()));
  command->add_option("--json", options->json, "Write what was measured as JSON")->type_name("FILE");
  command->add_option("--html", options->html, "Write a page with tables and plots")->type_name("FILE");
  command->add_option("--device", options->device, "Index, uuid:... or part of the name of the Vulkan device")
      ->type_name("DEVICE");
  command->callback([options] { run_bench_stability(*options); });
}

}  // namespace regulus::cli
