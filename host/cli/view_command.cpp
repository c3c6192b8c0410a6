// `regulus view`: a scene on a local page, rendered while it is looked at.
#include <spdlog/spdlog.h>

#include <memory>

#include "base/interrupt.hpp"
#include "base/standard_streams.hpp"
#include "bench/view_page.hpp"
#include "cli/commands.hpp"
#include "cli/render_options.hpp"
#include "cli/validators.hpp"
#include "render/names.hpp"
#include "view/painter.hpp"
#include "view/server.hpp"

namespace regulus::cli {

namespace {

struct ViewOptions : RenderOptions {
  uint16_t port = 0;
};

// A picture with fewer pixels is sooner there.
constexpr uint32_t MOST_COLUMNS = 640, SAMPLES = 4096;

/// The settings that both sides begin with.
render::RenderSettings base_settings(const CLI::App& command, const ViewOptions& options,
                                     const scene::Scene& scene) {
  render::RenderSettings settings = resolve_settings(options, scene);
  if (command.get_option("--spp")->count() == 0) settings.samples = SAMPLES;
  if (command.get_option("--size")->count() != 0 || settings.width <= MOST_COLUMNS) return settings;
  settings.height = std::max(settings.height * MOST_COLUMNS / settings.width, 1u);
  settings.width = MOST_COLUMNS;
  settings.crop = {};
  return settings;
}

view::Wanted first_state(const CLI::App& command, const ViewOptions& options,
                         const render::RenderSettings& settings) {
  view::Side side;
  side.tau = static_cast<double>(settings.tau);
  if (!options.techniques.empty())
    side.techniques = options.techniques;
  else if (command.get_option("--integrator")->count() != 0)
    side.techniques = options.integrator;
  side.is_regularized = settings.regularization != interface::REGULARIZATION_NONE;
  return {.sides = {side, side}, .is_split = false, .orbit = {}};
}

nlohmann::json page_json(const view::Wanted& wanted, const view::Orbit& home, const scene::Scene& scene,
                         const render::RenderSettings& settings, float exposure_ev) {
  std::vector<std::string> techniques = names_of(render::names::INTEGRATORS);
  const std::string& first = wanted.sides[0].techniques;
  if (std::ranges::find(techniques, first) == techniques.end()) techniques.push_back(first);
  view::Wanted at_home = wanted;
  at_home.orbit = home;
  return {{"title", scene.path.filename().string()},
          {"state", to_json(wanted)},
          {"home", to_json(at_home).at("orbit")},
          {"techniques", techniques},
          {"width", settings.width},
          {"height", settings.height},
          {"exposure", exposure_ev}};
}

void view_scene(CLI::App& command, ViewOptions& options) {
  require_no_outputs(options, "view");
  scene::Scene scene = scene::load(options.scene_file, load_options(options));
  apply_scene_settings(command, scene);
  const render::RenderSettings settings = base_settings(command, options, scene);
  const view::Orbit home = view::orbit_of(scene.cameras.at(settings.camera), scene);
  const view::Wanted wanted = first_state(command, options, settings);
  for (const std::string& warning : scene.warnings) spdlog::warn("{}: {}", scene.path.string(), warning);
  PreparedScene prepared = prepare(std::move(scene));
  gpu::Device device(
      {.select = options.device, .software_stage_times = false, .memory_bytes = options.memory_bytes});
  view::Mailbox mailbox(wanted);
  view::Board board;
  view::Painter painter(device, prepared, settings, home, options.denoise.library, mailbox, board);
  catch_interrupts();
  const view::Server server(
      options.port, bench::view_page(page_json(wanted, home, prepared.scene, settings, options.exposure_ev)),
      mailbox, board);
  say("{}\n", server.address());
  flush_stdout();
  painter.run(is_interrupted, [&] { return server.watchers() > 0; });
}

}  // namespace

void add_view_command(CLI::App& app) {
  const auto options = std::make_shared<ViewOptions>();
  CLI::App* command = app.add_subcommand(
      "view", "Look at a scene while it is rendered, on a page for this machine's browser; Ctrl-C ends it");
  declare_render_options(*command, *options);
  command->add_option("--port", options->port, "Port of the page (default: any that is free)")
      ->type_name("PORT")
      ->check(whole_number_in(0, 65535));
  command->callback([command, options] { view_scene(*command, *options); });
}

}  // namespace regulus::cli
