#include "cli/bench_kernels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>

#include "base/error.hpp"
#include "base/median.hpp"
#include "base/standard_streams.hpp"
#include "cli/bench_error.hpp"
#include "cli/bench_geometry.hpp"
#include "cli/bench_growth.hpp"
#include "cli/bench_rays.hpp"
#include "cli/bench_skip.hpp"
#include "cli/bench_stability.hpp"
#include "cli/output_guard.hpp"
#include "cli/output_writer.hpp"
#include "cli/validators.hpp"
#include "gpu/gpu.hpp"
#include "interface/wavefront.h"
#include "render/scene_structure.hpp"

namespace regulus::bench_shaders {
std::span<const uint32_t> spirv(std::string_view name);
}

namespace regulus::cli {

namespace {

constexpr uint32_t FILM_WIDTH = 512;
constexpr uint32_t FILM_HEIGHT = 256;

struct Measurement {
  std::string scene, rays, query, by;  ///< by: software, the traversal kernels, or hardware
  double mrays_per_s = 0, embree_mrays_per_s = 0;
  double ratio() const { return mrays_per_s / embree_mrays_per_s; }
};

// Device and Embree run for this long in turns: equally long, so that other load on the machine slows both
// alike.
constexpr double TURN_SECONDS = 0.1;

/// Runs per second of `work`, which is run until a turn is over.
template <typename Work>
double rate_of(const Work& work) {
  const auto begin = std::chrono::steady_clock::now();
  double seconds = 0;
  uint32_t runs = 0;
  while (seconds < TURN_SECONDS) {
    work();
    ++runs;
    seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }
  return runs / seconds;
}

/// Both query kernels on a device: by traversal, or by the device's own queries.
class QueryKernels {
 public:
  QueryKernels(gpu::Device& device, bool by_hardware)
      : is_hardware(by_hardware),
        device_(device),
        closest_(create("bench_closest")),
        any_(create("bench_any")) {}

  const bool is_hardware;
  const gpu::Kernel& closest() const { return closest_; }
  const gpu::Kernel& any() const { return any_; }

  void run(const gpu::Kernel& kernel, const interface::BenchArguments& arguments) {
    gpu::CommandList commands(device_);
    const uint32_t groups = (arguments.ray_count + interface::WORKGROUP_SIZE - 1) / interface::WORKGROUP_SIZE;
    commands.dispatch(kernel, gpu::bytes_of(arguments), groups);
    gpu::Submission submission = device_.submit(std::move(commands));
    device_.wait(submission);
  }

 private:
  gpu::Kernel create(const std::string& name) {
    const char* variant = is_hardware ? ".rays" : device_.info().has_int64 ? "" : ".int32";
    return device_.create_kernel({name, bench_shaders::spirv(name + variant), {}});
  }

  gpu::Device& device_;
  gpu::Kernel closest_, any_;
};

/// A scene on the device and in Embree.
class SceneBench {
 public:
  SceneBench(gpu::Device& device, std::vector<std::unique_ptr<QueryKernels>>& kernels,
             const BenchScene& scene, uint32_t repeats)
      : device_(device), kernels_(kernels), name_(scene.name), repeats_(repeats), embree_(scene.triangles) {
    const bvh::Bvh bvh = bvh::build(scene.triangles);
    nodes_ = gpu::upload_new(device, bvh.nodes, "bvh nodes");
    triangles_ = gpu::upload_new(device, bvh.triangles, "bvh triangles");
    if (device.info().has_ray_query) structure_ = render::TriangleStructure(device, bvh.triangles);
    overruns_ = device.create_buffer(sizeof(uint32_t), "overruns");
    rays_ = make_bench_rays(scene, embree_, FILM_WIDTH, FILM_HEIGHT);
  }

  std::vector<Measurement> run() {
    std::vector<Measurement> results;
    const std::pair<const char*, const std::vector<interface::BenchRay>*> kinds[] = {
        {"primary", &rays_.primary}, {"diffuse", &rays_.diffuse}, {"shadow", &rays_.shadow}};
    for (const auto& [kind, rays] : kinds) {
      if (rays->empty()) throw Error(ErrorCode::BadFile, fmt::format("{}: its camera sees nothing", name_));
      for (const bool is_any : {false, true})
        for (const auto& kernels : kernels_) results.push_back(measure(*kernels, kind, *rays, is_any));
    }
    const uint32_t overruns = gpu::download_all<uint32_t>(device_, overruns_, 1)[0];
    if (overruns > 0)
      std::fputs(fmt::format("warning: {}: {} rays were given up\n", name_, overruns).c_str(), stderr);
    return results;
  }

 private:
  /// Device and Embree in turns, after one run of each to warm up.
  Measurement measure(QueryKernels& kernels, const std::string& kind,
                      const std::vector<interface::BenchRay>& rays, bool is_any) {
    const auto address = [](const auto& memory) { return interface::device_address(memory.address()); };
    const gpu::Buffer ray_buffer = gpu::upload_new(device_, rays, "rays");
    const gpu::Buffer results = device_.create_buffer(rays.size() * sizeof(interface::Hit), "results");
    const interface::BenchArguments arguments {
      kernels.is_hardware ? address(structure_) : address(nodes_), address(triangles_), address(ray_buffer),
          address(results), address(overruns_), static_cast<uint32_t>(rays.size())
    };
    std::vector<interface::Hit> hits(rays.size());
    std::vector<uint32_t> is_hit(rays.size());
    const auto trace_embree = [&] {
      is_any ? embree_.trace_any(rays, is_hit) : embree_.trace_closest(rays, hits);
    };
    const auto trace_device = [&] { kernels.run(is_any ? kernels.any() : kernels.closest(), arguments); };

    trace_embree();
    trace_device();
    std::vector<double> embree_rates, device_rates;
    for (uint32_t i = 0; i < repeats_; ++i) {
      embree_rates.push_back(rate_of(trace_embree));
      device_rates.push_back(rate_of(trace_device));
    }
    const double millions = 1e-6 * static_cast<double>(rays.size());
    return {name_,
            kind,
            is_any ? "any" : "closest",
            kernels.is_hardware ? "hardware" : "software",
            millions * median(device_rates),
            millions * median(embree_rates)};
  }

  gpu::Device& device_;
  std::vector<std::unique_ptr<QueryKernels>>& kernels_;
  std::string name_;
  uint32_t repeats_;
  EmbreeScene embree_;
  gpu::Buffer nodes_, triangles_, overruns_;
  render::TriangleStructure structure_;  // of a device with ray queries
  BenchRays rays_;
};

void print_row(const Measurement& m) {
  say("{:<20} {:<8} {:<8} {:<8} {:>8.3f} {:>8.3f} {:>6.2f}\n", m.scene, m.rays, m.query, m.by, m.mrays_per_s,
      m.embree_mrays_per_s, m.ratio());
  flush_stdout();
}

std::string json_of(const std::vector<Measurement>& measurements) {
  nlohmann::json array = nlohmann::json::array();
  for (const Measurement& m : measurements)
    array.push_back({{"scene", m.scene},
                     {"rays", m.rays},
                     {"query", m.query},
                     {"by", m.by},
                     {"mrays_per_s", m.mrays_per_s},
                     {"embree_mrays_per_s", m.embree_mrays_per_s},
                     {"ratio", m.ratio()}});
  return array.dump(2) + "\n";
}

}  // namespace

int run_bench_kernels(const BenchKernelsOptions& options) {
  OutputGuard guard;
  if (!options.json.empty()) guard.add_output("--json", options.json);
  for (const std::filesystem::path& path : options.scenes) guard.add_scene(path);
  guard.require_places();
  gpu::DeviceOptions device_options;
  device_options.select = options.device;
  gpu::Device device(device_options);
  std::vector<std::unique_ptr<QueryKernels>> kernels;
  for (const bool is_hardware : {false, true})
    if (!is_hardware || device.info().has_ray_query)
      kernels.push_back(std::make_unique<QueryKernels>(device, is_hardware));
  std::vector<BenchScene> scenes = procedural_bench_scenes();
  for (const std::filesystem::path& path : options.scenes) scenes.push_back(load_bench_scene(path));

  say("device: {}\n{:<20} {:<8} {:<8} {:<8} {:>8} {:>8} {:>6}   (million rays per second)\n",
      device.info().name, "scene", "rays", "query", "by", "device", "Embree", "ratio");
  std::vector<Measurement> measurements;
  for (const BenchScene& scene : scenes) {
    for (const Measurement& measurement : SceneBench(device, kernels, scene, options.repeats).run()) {
      print_row(measurement);
      measurements.push_back(measurement);
    }
  }
  OutputWriter writer;
  if (!options.json.empty()) writer.write(options.json, [&] { return json_of(measurements); });
  writer.throw_failures();
  return 0;
}

void add_bench_command(CLI::App& app) {
  CLI::App* bench = app.add_subcommand("bench", "Measure speed and error");
  bench->require_subcommand(1);
  CLI::App* kernels = bench->add_subcommand(
      "kernels",
      "Rays per second of the traversal kernels, and of the device's own ray queries, beside Embree");
  const auto options = std::make_shared<BenchKernelsOptions>();
  kernels->add_option("SCENE", options->scenes, "glTF files to measure in addition to the procedural scenes")
      ->type_name("FILE");
  kernels->add_option("--json", options->json, "Write the results as a JSON array")->type_name("FILE");
  kernels->add_option("--device", options->device, "Index, uuid:... or part of the name of the Vulkan device")
      ->type_name("DEVICE");
  kernels->add_option("--repeats", options->repeats, "Measurements of each query; their median counts")
      ->type_name("N")
      ->check(whole_number_in(1, 1000));
  kernels->callback([options] { run_bench_kernels(*options); });
  add_bench_error_commands(*bench);
  add_bench_skip_command(*bench);
  add_bench_growth_command(*bench);
  add_bench_stability_command(*bench);
}

}  // namespace regulus::cli
