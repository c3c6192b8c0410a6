#include "cli/render_result.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <filesystem>

#include "base/error.hpp"
#include "base/standard_streams.hpp"
#include "base/version.hpp"
#include "cli/choice_json.hpp"
#include "cli/strategy_images.hpp"
#include "image/formats.hpp"

namespace regulus::cli {

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

// The error that a render is estimated to have, in words.
std::string noise_text(double noise, std::optional<double> target) {
  if (std::isnan(noise)) return "relative error unknown: more samples are needed to estimate it";
  return fmt::format("estimated relative error {:.4g}{}", noise,
                     !target || noise <= *target ? "" : fmt::format(", not the {:.4g} asked for", *target));
}

// The picture itself goes where messages would go.
bool is_stdout(const fs::path& file) {
  return file == "/dev/stdout" || file == "/dev/fd/1" || file == "/proc/self/fd/1";
}

// The sets of techniques that -i auto chose among, the best first.
nlohmann::json candidates(const Rendered& rendered) {
  if (rendered.plan.asked.techniques) return nlohmann::json::array();
  return choice_json(render::choose_techniques(rendered.prepared, rendered.plan.asked)).at("candidates");
}

std::string report_page(const Rendered& rendered) {
  const session::Result& result = rendered.result;
  std::vector<std::string> warnings = rendered.prepared.scene.warnings;
  for (const auto* more : {&rendered.plan.warnings, &result.warnings, &result.bugs})
    warnings.insert(warnings.end(), more->begin(), more->end());
  const image::Attributes& attributes = result.attributes;
  const auto attribute = [&](const char* name) {
    const auto found = attributes.find(name);
    return found == attributes.end() ? std::string() : found->second;
  };
  return bench::render_page(
      {.title = rendered.prepared.scene.path.filename().string(),
       .about = fmt::format("{}. {} {}. Regulus {} ({}).", rendered.outputs.picture.string(),
                            attribute("regulus:device"), attribute("regulus:driver"), VERSION, COMMIT),
       .summary =
           fmt::format("{}; {}.", result.summary, noise_text(result.noise, rendered.options.noise_target)),
       .image = result.image,
       .channels = result.channels,
       .exposure_ev = rendered.options.exposure_ev,
       .statistics = result.statistics,
       .candidates = candidates(rendered),
       .convergence = rendered.convergence,
       .warnings = warnings});
}

// Preview, statistics and report.
void write_others(OutputWriter& writer, const Rendered& rendered) {
  const RenderOutputs& outputs = rendered.outputs;
  if (!outputs.png.empty())
    writer.write(outputs.png, [&] {
      return image::encode_tone_mapped(image::Format::Png, rendered.result.image, encoding(rendered.options),
                                       outputs.png.string());
    });
  if (!outputs.stats.empty())
    writer.write(outputs.stats, [&] { return rendered.result.statistics.dump(2) + "\n"; });
  if (!outputs.report.empty()) writer.write(outputs.report, [&] { return report_page(rendered); });
}

void report(const session::Result& result, const RenderOutputs& outputs) {
  const std::string picture = outputs.picture.string();
  for (const std::string& warning : result.warnings) spdlog::warn("{}: {}", picture, warning);
  for (const std::string& bug : result.bugs) spdlog::error("{}: a bug, please report the scene", bug);
  spdlog::info("{}: {}", picture, result.summary);
}

// What was written, how long it took, and how good it is: a word more than what was asked for, which is the
// picture.
void say_success(const Rendered& rendered, ProgressReport& progress, Clock::time_point begin) {
  const auto& [result, prepared, plan, job, options, outputs, convergence] = rendered;
  std::vector<std::string> files;
  for (const fs::path& file :
       {outputs.picture, outputs.png, outputs.stats, outputs.report, outputs.strategy_images})
    if (!file.empty()) files.push_back(file.string());
  forgive_stdout();
  progress.done({{"files", files},
                 {"samples", result.paths / plan.window().pixels()},
                 {"render_seconds", result.seconds},
                 {"estimated_error",
                  std::isfinite(result.noise) ? nlohmann::json(result.noise) : nlohmann::json(nullptr)}});
  progress.end();
  if (progress.is_json() || options.is_quiet || is_stdout(outputs.picture)) return;
  const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  say("wrote {}: {}, {:.2f} s in all{}\n", fmt::join(files, ", "), result.summary, seconds,
      result.renderer ? "; " + noise_text(result.noise, options.noise_target) : "");
  flush_stdout();
}

}  // namespace

void write_result(const Rendered& rendered, ProgressReport& progress, Clock::time_point begin) {
  const session::Result& result = rendered.result;
  const RenderOutputs& outputs = rendered.outputs;
  const float exposure_ev = rendered.options.exposure_ev;
  progress.begin("write");
  OutputWriter writer;
  writer.write(outputs.picture, [&] {
    return encode(result, rendered.plan, rendered.job, outputs.format, encoding(rendered.options),
                  outputs.picture);
  });
  write_others(writer, rendered);
  if (!outputs.strategy_images.empty() && !result.failure)
    write_strategy_images(writer, outputs.strategy_images, *result.renderer, rendered.plan.max_depth,
                          result.attributes, exposure_ev);
  report(result, outputs);
  const std::string picture = outputs.picture.string();
  if (result.failure && writer.has_failed())
    spdlog::error("{}", result.failure->what());
  else if (result.failure)
    throw Error(result.failure->code(),
                fmt::format("{}; {} holds what was rendered before", result.failure->what(), picture));
  writer.throw_failures();
  if (!result.is_complete)
    throw Error(ErrorCode::Interrupted, fmt::format("interrupted; {} holds what was rendered", picture));
  say_success(rendered, progress, begin);
}

}  // namespace regulus::cli
