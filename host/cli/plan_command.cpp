// `regulus plan`: what `render -i auto` would choose for a scene, and among what.
#include <memory>

#include "base/standard_streams.hpp"
#include "cli/choice_json.hpp"
#include "cli/commands.hpp"
#include "cli/output_guard.hpp"
#include "cli/output_writer.hpp"
#include "cli/render_options.hpp"
#include "render/names.hpp"
#include "render/technique_choice.hpp"

namespace regulus::cli {

namespace {

struct PlanOptions : RenderOptions {
  std::string json;  ///< file; empty: none
};

void print(const render::TechniqueChoice& choice) {
  if (!choice.candidates.empty()) {
    const double least = choice.candidates.front().error_at_equal_time();
    say("{:<28} {:>11} {:>13} {:>8} {:>22}\n", "techniques", "regularized", "squared error", "cost",
        "error at equal time");
    for (const render::Candidate& candidate : choice.candidates)
      say("{:<28} {:>11} {:>13.4g} {:>8.2f} {:>22.2f}\n", render::technique_set_name(candidate.techniques),
          candidate.regularization != 0 ? "yes" : "no", candidate.error, candidate.cost,
          least > 0 ? candidate.error_at_equal_time() / least : 1.0);
  }
  say("chosen: {}{}: {}\n", render::technique_set_name(choice.techniques),
      choice.regularization != 0 ? " with regularization" : "", choice.why);
}

void plan_scene(CLI::App& command, PlanOptions& options) {
  require_no_outputs(options, "plan");
  scene::Scene scene = scene::load(options.scene_file, load_options(options));
  apply_scene_settings(command, scene);
  const render::RenderSettings settings = resolve_settings(options, scene);
  const PreparedScene prepared = prepare(std::move(scene));
  const render::TechniqueChoice choice = choose_techniques(prepared, settings);
  OutputWriter writer;
  if (!options.json.empty()) {
    OutputGuard guard;
    guard.add_scene(options.scene_file);
    guard.add_output("--json", options.json);
    writer.write(options.json, [&] { return choice_json(choice).dump(2) + "\n"; });
  }
  print(choice);
  writer.throw_failures();
}

}  // namespace

void add_plan_command(CLI::App& app) {
  const auto options = std::make_shared<PlanOptions>();
  CLI::App* command =
      app.add_subcommand("plan", "Which sets of techniques suit a scene: those among which -i auto chooses");
  declare_render_options(*command, *options);
  command->add_option("--json", options->json, "Write the table to this file")->type_name("FILE");
  command->callback([command, options] { plan_scene(*command, *options); });
}

}  // namespace regulus::cli
