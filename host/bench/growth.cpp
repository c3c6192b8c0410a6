#include "bench/growth.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>
#include <random>

#include "base/error.hpp"
#include "base/near_names.hpp"
#include "base/process_usage.hpp"
#include "bench/growth_scene.hpp"
#include "prepared/prepared_scene.hpp"
#include "render/plan.hpp"
#include "render/renderer.hpp"
#include "render/technique_sets.hpp"

namespace regulus::bench {
namespace {

using namespace interface;
using Points = std::vector<std::pair<double, double>>;

using namespace technique_sets;

/// One render of a sweep.
struct Case {
  GrowthScene scene{};
  render::RenderSettings settings{};

  Case() {
    settings.width = settings.height = 64;
    settings.samples = 8;
    settings.max_depth = 6;
    settings.techniques = PT;
    settings.rays = RAYS_AUTO;
  }
};

struct Kind {
  const char* name;
  const char* text;
  std::vector<double> quick, full;
  void (*apply)(Case&, double size);
};

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> all = {
      {"pixels",
       "pt, 6 edges, 8 samples, 2,000 triangles",
       {1024, 4096, 16384},
       {4096, 65536, 1048576},
       [](Case& one, double size) {
         one.settings.width = one.settings.height = static_cast<uint32_t>(std::sqrt(size));
       }},
      {"samples",
       "pt, 6 edges, 64x64, 2,000 triangles",
       {4, 16, 64},
       {16, 128, 1024},
       [](Case& one, double size) { one.settings.samples = static_cast<uint32_t>(size); }},
      {"triangles",
       "pt, 6 edges, 64x64, 8 samples",
       {1e3, 1e4, 1e5},
       {1e3, 1e4, 1e5, 1e6, 1e7},
       [](Case& one, double size) { one.scene.triangles = static_cast<uint64_t>(size); }},
      {"lights",
       "pt, 6 edges, 64x64, 8 samples, emissive triangles of the same area together",
       {1, 10, 100, 1e4},
       {1, 10, 100, 1e4, 1e6},
       [](Case& one, double size) { one.scene.lights = static_cast<uint64_t>(size); }},
      {"depth",
       "bpt, a closed room, 64x64, 4 samples: each vertex is connected to each of the light path",
       {4, 8, 16, 32},
       {4, 8, 16, 32, 64, 128},
       [](Case& one, double size) {
         one.scene.is_closed = true;
         one.settings.techniques = BPT;
         one.settings.samples = 4;
         one.settings.max_depth = static_cast<uint32_t>(size);
       }},
      {"light paths",
       "vcm, 6 edges, 64x64, 4 samples",
       {1024, 4096, 16384},
       {1024, 16384, 262144},
       [](Case& one, double size) {
         one.settings.techniques = VCM;
         one.settings.samples = 4;
         one.settings.light_paths = static_cast<uint32_t>(size);
       }},
      {"instances",
       "pt, 6 edges, 64x64, 8 samples, copies of a mesh of 8 triangles",
       {10, 100, 1000},
       {10, 100, 1e3, 1e4, 1e5},
       [](Case& one, double size) { one.scene.instances = static_cast<uint64_t>(size); }}};
  return all;
}

/// A folder that goes away with the object.
class Folder {
 public:
  Folder()
      : path_(std::filesystem::temp_directory_path() /
              ("regulus-growth-" + std::to_string(std::random_device()()))) {
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

double now(bool counts_cpu_time) {
  if (counts_cpu_time) return process_cpu_seconds();
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

GrowthPoint measure(gpu::Device& device, const Kind& kind, double size, const GrowthBudget& budget) {
  const bool counts_cpu_time = device.info().kind == gpu::DeviceKind::Software;
  Case one;
  kind.apply(one, size);
  const Folder folder;
  const std::filesystem::path file = write_growth_scene(one.scene, folder.path());
  constexpr double LONG = std::numeric_limits<double>::max();
  GrowthPoint point{.size = size, .prepare_seconds = LONG, .render_seconds = LONG};
  for (uint32_t repeat = 0; repeat <= budget.repeats; ++repeat) {
    const double begin = now(counts_cpu_time);
    const PreparedScene prepared = prepare(load_growth_scene(file));
    const double prepared_at = now(counts_cpu_time);
    const uint64_t bytes_before = device.allocated_bytes();
    render::Renderer renderer(device, prepared, make_plan(prepared, one.settings));
    const double start = now(counts_cpu_time);
    renderer.render([](uint64_t, uint64_t) { return true; }, budget.is_interrupted);
    const double end = now(counts_cpu_time);
    if (budget.is_interrupted && budget.is_interrupted()) throw Error(ErrorCode::Interrupted, "interrupted");
    point.device_bytes = static_cast<double>(device.allocated_bytes() - bytes_before);
    if (repeat == 0) continue;  // it compiled kernels
    point.prepare_seconds = std::min(point.prepare_seconds, prepared_at - begin);
    point.render_seconds = std::min(point.render_seconds, end - start);
  }
  return point;
}

}  // namespace

PowerFit fit_power(const Points& points) {
  const auto count = static_cast<double>(points.size());
  double mean_x = 0, mean_y = 0;
  for (const auto& [x, y] : points) {
    mean_x += std::log(x) / count;
    mean_y += std::log(y) / count;
  }
  double xx = 0, xy = 0;
  for (const auto& [x, y] : points) {
    xx += (std::log(x) - mean_x) * (std::log(x) - mean_x);
    xy += (std::log(x) - mean_x) * (std::log(y) - mean_y);
  }
  PowerFit fit;
  fit.exponent = xy / xx;
  double residuals = 0;
  for (const auto& [x, y] : points) {
    const double residual = std::log(y) - mean_y - fit.exponent * (std::log(x) - mean_x);
    residuals += residual * residual;
  }
  if (points.size() > 2) fit.deviation = std::sqrt(residuals / (count - 2) / xx);
  const auto& [x1, y1] = points[points.size() - 2];
  const auto& [x2, y2] = points.back();
  fit.last = std::log(y2 / y1) / std::log(x2 / x1);
  return fit;
}

PowerFit fit_of(const GrowthSweep& sweep, double GrowthPoint::*quantity) {
  Points points;
  for (const GrowthPoint& point : sweep.points) points.emplace_back(point.size, point.*quantity);
  return fit_power(points);
}

double log_linear_exponent(const GrowthSweep& sweep) {
  const double small = sweep.points[sweep.points.size() - 2].size, large = sweep.points.back().size;
  return small <= 1 ? 1 : 1 + std::log(std::log(large) / std::log(small)) / std::log(large / small);
}

std::vector<std::string> growth_names() {
  std::vector<std::string> names;
  for (const Kind& kind : kinds()) names.emplace_back(kind.name);
  return names;
}

void require_growth_names(const std::vector<std::string>& names) {
  for (const std::string& name : names)
    if (std::ranges::find(kinds(), name, &Kind::name) == kinds().end())
      throw Error(ErrorCode::BadUsage, "bench growth: " + unknown_name(name, growth_names()));
}

void measure_growth(gpu::Device& device, const GrowthBudget& budget,
                    const std::function<void(const GrowthSweep&)>& use) {
  require_growth_names(budget.names);
  for (const Kind& kind : kinds()) {
    if (!budget.names.empty() && std::ranges::find(budget.names, kind.name) == budget.names.end()) continue;
    GrowthSweep sweep{kind.name, kind.text, {}};
    for (const double size : budget.is_full ? kind.full : kind.quick)
      sweep.points.push_back(measure(device, kind, size, budget));
    use(sweep);
  }
}

}  // namespace regulus::bench
