// The options of `regulus render` on the command line, by topic.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <limits>

#include "base/error.hpp"
#include "base/tcp_client.hpp"
#include "cli/render_options.hpp"
#include "cli/strategy_images.hpp"
#include "cli/validators.hpp"
#include "render/aov.hpp"

namespace regulus::cli {

namespace {

using namespace interface;
namespace names = render::names;

/// From how many lights on --light-sampling auto is the tree.
size_t many_lights() {
  size_t count = 1;
  while (scene::resolve_light_sampling(LIGHT_SAMPLING_AUTO, count) != LIGHT_SAMPLING_BVH) ++count;
  return count;
}

/// An option that is a setting of a render: it takes what session::Setting of that name takes.
CLI::Option* add_setting(CLI::App& command, RenderOptions& options, const std::string& names,
                         const std::string& help) {
  const session::Setting& setting = session::find_setting(names.substr(names.find("--") + 2));
  return command
      .add_option_function<std::string>(
          names, [&options, &setting](const std::string& text) { setting.take(options, text); }, help)
      ->check([&setting](const std::string& text) {
        session::Request scratch;
        return setting.take(scratch, text).value_or("");
      });
}

// How the picture is shown and stored.
void declare_look(CLI::App& command, RenderOptions& options) {
  const CLI::Validator is_stops = number_in(-100.0, 100.0);
  command
      .add_option_function<std::string>(
          "--exposure",
          [&options](const std::string& text) {
            options.is_exposed_automatically = text == "auto";
            options.exposure_ev = options.is_exposed_automatically ? 0 : std::stof(text);
          },
          "Exposure of PNG and JPEG; auto: the mean logarithm of luminance becomes that of middle grey")
      ->type_name("STOPS|auto")
      ->check([is_stops](std::string text) { return text == "auto" ? std::string() : is_stops(text); });
  command
      .add_option(
          "--view", options.view,
          "How PNG and JPEG show linear light: neutral (Khronos), standard (cut off), agx, filmic (Hable), "
          "raw (no curve)")
      ->type_name(fmt::format("{}", fmt::join(image::view_names(), "|")))
      ->check(one_of(image::view_names()))
      ->capture_default_str();
  CLI::Option* config =
      command
          .add_option("--ocio", options.ocio,
                      "Config of OpenColorIO by which PNG and JPEG show linear light, in place of "
                      "--view: a file, or one that the library has built in (ocio://default)")
          ->type_name("CONFIG");
  command
      .add_option("--ocio-display", options.ocio_display, "Display of the config (default: its own choice)")
      ->type_name("NAME")
      ->needs(config);
  command.add_option("--ocio-view", options.ocio_view, "View of the display (default: its own choice)")
      ->type_name("NAME")
      ->needs(config);
  command.add_flag("--half", options.storage.has_half_floats,
                   "Store colours and normals of OpenEXR as half floats");
  command.add_flag("--dwaa", options.storage.is_dwaa, "Store OpenEXR with DWAA's lossy compression");
}

void declare_output(CLI::App& command, RenderOptions& options) {
  command
      .add_option("-o,--output", options.output,
                  "Picture to write, in the format of its extension: .exr, tone-mapped .png or .jpg, .hdr "
                  "(default: the scene's name with .exr, and beside it with .png)")
      ->type_name("FILE");
  command.add_option("--png", options.png, "Also write a tone-mapped 8-bit PNG")->type_name("FILE");
  declare_look(command, options);
  add_setting(command, options, "--aov",
              fmt::format("Extra channels, separated by commas: {}", fmt::join(render::known_aovs(), ", ")))
      ->type_name("NAMES");
  command.add_flag(
      "--denoise", options.is_denoised,
      "Denoise the picture by its albedo and normals, which are added to it; the noisy picture stays in "
      "it as noisy.R, noisy.G, noisy.B. Uses a box filter unless --filter says otherwise");
  add_denoiser_options(command, options.denoise);
  command.add_option("--strategy-images", options.strategy_images, STRATEGY_IMAGES_HELP)->type_name("FOLDER");
  command.add_option("--stats", options.stats, "Write times, rays and memory as JSON")->type_name("FILE");
  command
      .add_option("--report", options.report,
                  "Write a page with the picture, what was chosen and why, times, rays, memory, and how the "
                  "error fell")
      ->type_name("FILE.html");
  command
      .add_option("--display-server", options.display_server,
                  "Show the picture while it is rendered in a viewer that speaks tev's protocol, such as "
                  "localhost:14158")
      ->type_name("HOST:PORT")
      ->check(CLI::Validator(
          [](std::string& text) {
            try {
              parse_host_and_port(text);
              return std::string();
            } catch (const Error& error) {
              return std::string(error.what());
            }
          },
          ""));
  command.add_flag("-q,--quiet", options.is_quiet, "Print errors only");
  const std::vector<std::pair<std::string, ProgressStyle>> styles = {{"auto", ProgressStyle::Auto},
                                                                     {"lines", ProgressStyle::Lines},
                                                                     {"json", ProgressStyle::Json},
                                                                     {"none", ProgressStyle::None}};
  command
      .add_option_function<std::string>(
          "--progress",
          [&options, styles](const std::string& text) {
            for (const auto& [name, style] : styles)
              if (name == text) options.progress = style;
          },
          "How to show progress. auto: on a terminal a line that is redrawn, otherwise a line every 10 "
          "seconds, both on stderr; lines: always those lines; json: one JSON object a line on stdout, in "
          "place of the message at the end; none: not at all")
      ->type_name("auto|lines|json|none")
      ->check(one_of({"auto", "lines", "json", "none"}))
      ->default_str("auto");
  command.add_flag("-v,--verbose", options.is_verbose, "Print what is done and how long it takes");
}

void declare_quality(CLI::App& command, RenderOptions& options) {
  render::RenderSettings& settings = options.settings;
  add_setting(command, options, "-s,--spp", "Samples per pixel")
      ->type_name("N")
      ->default_str(std::to_string(settings.samples));
  add_setting(command, options, "--time",
              "Stop after this many seconds of rendering, but not before every pixel has a sample. Without "
              "--spp on the command line: as many samples as the time allows")
      ->type_name("SECONDS");
  add_setting(command, options, "--noise",
              "Stop when the estimated relative error of the picture (the root of relMSE, from how much it "
              "changes with more samples) is this small, "
              "after 16 samples at least. Without --spp on the command line: as many samples as that takes")
      ->type_name("ERROR");
  add_setting(command, options, "--seed", "Seed of the random numbers")
      ->type_name("N")
      ->default_str(std::to_string(settings.seed));
  add_setting(command, options, "--sampler",
              "Random numbers: scrambled Sobol points, or independent numbers from a hash")
      ->type_name(listed(names::SAMPLER))
      ->default_str("sobol");
  add_setting(command, options, "--filter", "Pixel filter")
      ->type_name(listed(names::FILTER))
      ->default_str("blackman-harris");
  add_setting(command, options, "--filter-radius",
              "Radius of the filter (default: 0.5 for box, 1.5 for the others)")
      ->type_name("PIXELS");
  add_setting(command, options, "--clamp",
              "Largest value that one technique may add to a sample: fewer fireflies, lost light; for "
              "comparison")
      ->type_name("RADIANCE");
}

void declare_transport(CLI::App& command, RenderOptions& options) {
  render::RenderSettings& settings = options.settings;
  add_setting(
      command, options, "-i,--integrator",
      "A named set of techniques; auto: those that suit the scene (`regulus plan` shows the candidates)")
      ->type_name(listed(names::INTEGRATORS))
      ->default_str(options.integrator);
  add_setting(command, options, "--techniques",
              "The techniques themselves, separated by commas: hit,nee,splat,connect,merge")
      ->type_name("NAMES");
  add_setting(command, options, "--settings-from",
              "Use the techniques and regularization of this picture instead of choosing them")
      ->type_name("FILE");
  add_setting(command, options, "--max-depth", "Longest path, in edges")
      ->type_name("N")
      ->default_str(std::to_string(settings.max_depth));
  add_setting(command, options, "--light-paths",
              "Light paths per iteration, in which every pixel gets one sample (default: one per pixel)")
      ->type_name("N");
  add_setting(command, options, "--light-sampling",
              fmt::format("How surfaces choose the light they sample: bvh by what it can send there, power, "
                          "uniform, or auto, which is bvh from {} lights on",
                          many_lights()))
      ->type_name(listed(names::LIGHT_SAMPLING))
      ->default_str("auto");
  add_setting(
      command, options, "--guide",
      "Camera paths look where light comes from: on, off (by their materials alone), or auto, where a "
      "training before the render shows that it pays")
      ->type_name(listed(names::LIGHT_GUIDE))
      ->default_str("off");
  add_setting(command, options, "--guide-light",
              "Light paths go where the camera looks: on, off (by power alone), or auto, where a training "
              "before the render shows that it pays")
      ->type_name(listed(names::LIGHT_GUIDE))
      ->default_str("off");
  add_setting(command, options, "--connections",
              "Light vertices that a camera vertex connects to: those of its own light path, or M drawn "
              "from all of the iteration")
      ->type_name("paired|cache:M")
      ->default_str(options.connections);
  add_setting(command, options, "--shadow-roulette",
              "Shadow rays that would carry less than this radiance are traced with a probability in "
              "proportion, and count accordingly more: auto takes an eighth of how bright the picture "
              "typically is, off traces every one")
      ->type_name("off|auto|RADIANCE")
      ->default_str(options.shadow_roulette);
  add_setting(command, options, "--merge-radius",
              "Merge radius of the first iteration in metres, or in percent of the extent seen, as in "
              "0.3%; at most a tenth of it (default: a thousandth of the picture's height at the "
              "surfaces seen)")
      ->type_name("METRES|PERCENT%");
  add_setting(command, options, "--merge-reduction",
              "The merge radius of iteration i is that of the first, times i to minus this power")
      ->type_name("EXPONENT")
      ->default_str(fmt::format("{:g}", settings.merge_reduction));
  add_setting(command, options, "--ndf", "Distribution of microfacet normals")
      ->type_name(listed(names::NDF))
      ->default_str("ggx");
  add_setting(command, options, "--shadowing",
              "Masking and shadowing of microfacets; smith is correlated by height")
      ->type_name(listed(names::SHADOWING))
      ->default_str("smith");
  command.add_flag("--energy-compensation", settings.has_energy_compensation,
                   "Rough metals, plastics and glass give back what single scattering between facets loses");
}

void declare_regularization(CLI::App& command, RenderOptions& options) {
  render::RenderSettings& settings = options.settings;
  add_setting(command, options, "--regularization",
              "How connections and merges see glossy and specular surfaces: as they are (none), with raised "
              "roughness (roughness), by what they send into a small cone (virtual-merge), or both as they "
              "are and with raised roughness (both)")
      ->type_name(listed(names::REGULARIZATION))
      ->default_str(options.regularization ? "none"
                                           : "with -i auto what suits the scene; otherwise roughness, or "
                                             "none with technique merge");
  add_setting(command, options, "--tau",
              "Largest density of a regularized lobe: smaller values blur more, inf is no regularization")
      ->type_name("1/SR")
      ->default_str(fmt::format("{:g}", settings.tau));
  add_setting(command, options, "--bound", "How roughness follows from tau")
      ->type_name(listed(names::BOUND))
      ->default_str("peak");
  add_setting(command, options, "--tau-schedule",
              "consistent: roughness is raised less with every iteration, so that the picture converges to "
              "the truth; fixed: always by as much")
      ->type_name(listed(names::TAU_SCHEDULE))
      ->default_str("consistent");
  add_setting(command, options, "--diffusion",
              "on: what the camera sees directly, or by way of sharp surfaces only, is not regularized")
      ->type_name(listed(names::DIFFUSION))
      ->default_str("on");
  add_setting(command, options, "--sampler-quality",
              "on: paths that some technique samples well are not regularized; smooth: with a soft "
              "transition")
      ->type_name(listed(names::SAMPLER_QUALITY))
      ->default_str("off");
  add_setting(command, options, "--mis",
              "Weights of regularized techniques: blended, corrected by the values of samples, or "
              "unmodified, which is wrong and there for comparison")
      ->type_name(listed(names::MIS))
      ->default_str("blended");
}

void declare_camera_and_scene(CLI::App& command, RenderOptions& options) {
  add_setting(command, options, "--size", "Size of the film in pixels (default: the scene's)")
      ->type_name("WIDTHxHEIGHT");
  add_setting(command, options, "--crop",
              "Render only these pixels; counted from the top left, x1 and y1 excluded")
      ->type_name("x0,y0,x1,y1");
  add_setting(command, options, "--camera", "Camera by name or index (default: the first)")
      ->type_name("CAMERA");
  command.add_option("--scene", options.scene_index, "Scene of the file by index (default: its own default)")
      ->type_name("INDEX");
  command
      .add_option("--variant", options.variant, "Material variant by name (default: the scene's, or none)")
      ->type_name("NAME");
  command
      .add_option("--animation", options.animation,
                  "Animation that poses the scene, by name or index (default: the scene's, or none)")
      ->type_name("ANIMATION");
  command
      .add_option("--at", options.time, "Time at which the animation, or else the first one, poses the scene")
      ->type_name("SECONDS")
      ->check(number_in(-1e9, 1e9));
  command
      .add_option("--frames", options.frames,
                  "Render each of these frames, number / fps seconds into the animation, into a file of its "
                  "own, with the frame's number as in name.0007.exr, or in place of a run of # in the name")
      ->type_name("FIRST:LAST")
      ->excludes("--at");
  command.add_option("--fps", options.frames_per_second, "Frames per second of --frames")
      ->type_name("RATE")
      ->check(number_in(1e-6, 1e6))
      ->capture_default_str();
  command
      .add_option(
          "--env", options.environment,
          "Environment light: a latitude-longitude map, OpenEXR or Radiance HDR (default: the scene's)")
      ->type_name("FILE");
  command
      .add_option("--env-rotation", options.environment_rotation,
                  "Turns the environment about +y, counterclockwise seen from above")
      ->type_name("DEGREES")
      ->check(number_in(-1e6, 1e6));
  command.add_option("--env-scale", options.environment_scale, "Factor on the environment's radiance")
      ->type_name("FACTOR")
      ->check(number_in(0.0, 1e12));
  add_edit_option(command, options.edits);
  command.add_flag("--allow-external", options.allow_external,
                   "Let the scene refer to files outside its folder");
  command.add_flag("--strict", options.is_strict, STRICT_HELP);
}

void declare_device(CLI::App& command, RenderOptions& options) {
  command
      .add_option("--device", options.device,
                  "Vulkan device by index, uuid:... or part of its name (see regulus devices); several with "
                  "commas between them, or all, render one picture")
      ->type_name("DEVICE");
  command
      .add_option("--split", options.split,
                  "Which of several devices renders which samples, as in the header of a picture "
                  "(regulus:split); default: by speed")
      ->type_name("DEVICE=FIRST:COUNT,...");
  command
      .add_option(
          "--backend", options.backend,
          "What renders: a Vulkan device, or the scalar double-precision reference, which is slow and "
          "needs no device")
      ->type_name("vulkan|reference")
      ->check(one_of({"vulkan", "reference"}))
      ->capture_default_str();
  add_memory_option(command, options.memory_bytes);
  add_setting(
      command, options, "--rays",
      "What traces rays: the device's own ray queries (hardware); kernels (software); Embree, in the memory "
      "of a software device (host); or auto, which is host on software devices and hardware on others where "
      "device and scene allow it, and software otherwise")
      ->type_name(listed(names::RAYS))
      ->default_str("auto");
  add_setting(command, options, "--wave",
              "Paths in flight (default: chosen for the device; never changes the picture)")
      ->type_name("N");
  add_setting(command, options, "--band",
              "Pixels rendered at once, in bands of rows (default: as many as the device's buffers hold; "
              "never changes the picture)")
      ->type_name("N");
}

void declare_long_renders(CLI::App& command, RenderOptions& options) {
  add_setting(command, options, "--samples",
              "Render only these samples, and store what `regulus merge` needs to join parts")
      ->type_name("FIRST:COUNT")
      ->excludes("--spp");
  command
      .add_option("--checkpoint", options.checkpoint,
                  "File from which --resume can go on; itself an OpenEXR picture and a part for merge")
      ->type_name("FILE");
  command.add_option("--checkpoint-seconds", options.checkpoint_seconds, "Time between two states of it")
      ->type_name("SECONDS")
      ->check(number_in(0.0, 1e9))
      ->capture_default_str();
  command.add_flag("--resume", options.is_resumed, "Go on from the checkpoint if there is one")
      ->needs("--checkpoint");
}

}  // namespace

void add_edit_option(CLI::App& command, std::vector<std::string>& edits) {
  command
      .add_option("-D,--define", edits,
                  "Edit the scene, as in materials.Glass.roughness=0.1, cameras.0.yfov=0.5 or "
                  "nodes.Lamp.translation=0,2,0; any number of times")
      ->type_name("ELEMENT.PROPERTY=VALUE")
      ->allow_extra_args(false);
}

void add_memory_option(CLI::App& command, uint64_t& bytes) {
  command
      .add_option("--memory", bytes,
                  "Most that a scene may take of the host's memory, and of the device's, as in 4G or 512M "
                  "(default: three quarters of the machine's; of the device what is free)")
      ->type_name("BYTES")
      ->transform(CLI::AsSizeValue(false).description(""))
      ->check(whole_number_in(1, std::numeric_limits<uint64_t>::max()));
}

void declare_render_options(CLI::App& command, RenderOptions& options) {
  command.add_option("scene-file", options.scene_file, "The .gltf or .glb file to render")
      ->required()
      ->type_name("SCENE");
  const std::pair<const char*, void (*)(CLI::App&, RenderOptions&)> topics[] = {
      {"Output", declare_output},
      {"Quality", declare_quality},
      {"Transport", declare_transport},
      {"Regularization", declare_regularization},
      {"Camera and scene", declare_camera_and_scene},
      {"Device", declare_device},
      {"Long renders", declare_long_renders}};
  for (const auto& [topic, declare] : topics) {
    command.option_defaults()->group(topic);
    declare(command, options);
  }
  command.option_defaults()->group("Options");
}

}  // namespace regulus::cli
