#include <cmath>
#include <memory>
#include <utility>

#include "interface/wavefront.h"
#include "probe/probe.hpp"
#include "reference/estimator.hpp"
#include "reference/parallel.hpp"

namespace regulus::probe {

using namespace interface;

namespace {

constexpr uint32_t GRAIN = 64;         // pixels or light walks that a thread takes at a time
constexpr uint32_t COUNTED = 4;        // the work of every fourth pixel is counted
constexpr double BEYOND_THE_LOBE = 2;  // raised over plain density, where the plain lobe hardly reaches
constexpr double THROUGHPUT = 0.5;     // say, of a camera path from its pixel to a lamp that it hits

/// Whether chance can bring a technique to the path at all: nothing connects or merges at a mirror as a
/// mirror reflects, though with raised roughness weights compare both.
bool can_find(const reference::Technique& technique, const reference::Path& path) {
  if (technique.kind == TECHNIQUE_HIT) return true;
  const auto is_mirror = [&](size_t i) { return i >= 1 && i < path.length() && path.vertices[i].is_delta; };
  const size_t s = technique.vertex;
  return technique.kind == TECHNIQUE_MERGE ? !is_mirror(s) : !is_mirror(s - 1) && !is_mirror(s);
}

/// Fills in what a hit would be worth, if the path's light goes by mirrors and clear glass alone to the first
/// vertex that anything connects to, or to the camera, and a light sample met it only because the last of
/// them is raised.
void describe_hit(const reference::SampledPath& found, FoundPath& result) {
  const reference::Path& path = found.path;
  if (found.technique != TECHNIQUE_NEE || !reference::can_be_hit(path.light.kind)) return;
  const double ratio = connected_at(path, 1).ratio;
  if (ratio != 0 && ratio < BEYOND_THE_LOBE) return;
  size_t rough = 1;
  while (rough < path.length() && (path.vertices[rough].is_delta || path.vertices[rough].raised)) ++rough;
  if (rough + 1 == path.length()) return;  // seen directly: splats find it, and tell what it is without them
  result.value_of_hit = THROUGHPUT * path.light.emitted;
  result.other_finders = rough == path.length() ? 0 : uint32_t{TECHNIQUE_MERGE};
}

FoundPath describe(const reference::Contribution& found, uint32_t pixel, uint32_t iteration) {
  FoundPath result{pixel, iteration, found.sampled.technique, found.value(), {}, {}, glm::dvec3(0), 0};
  describe_hit(found.sampled, result);
  reference::Wide weights = 0, densities = 0;
  const auto density_of = [&](const reference::Technique& technique) {
    return can_find(technique, found.sampled.path) ? technique.density : 0;
  };
  for (const reference::Technique& technique : found.techniques) {
    weights += technique.weight_density;
    densities += density_of(technique);
  }
  for (const reference::Technique& technique : found.techniques)
    for (size_t kind = 0; kind < result.weights.size(); ++kind) {
      if (technique.kind != 1u << kind) continue;
      result.weights[kind] += static_cast<double>(technique.weight_density / weights);
      result.densities[kind] += static_cast<double>(density_of(technique) / densities);
    }
  return result;
}

/// The integral of h^2 over the plane, 1 / px^2.
double integral_of_square(const reference::Filter& filter) {
  constexpr int STEPS = 32;  // along each side
  const double step = 2 * filter.radius / STEPS;
  double sum = 0;
  for (int y = 0; y < STEPS; ++y)
    for (int x = 0; x < STEPS; ++x) {
      const double value = filter.value((glm::dvec2(x, y) + 0.5) * step - filter.radius);
      sum += value * value * step * step;
    }
  return sum;
}

class Finder {
 public:
  Finder(const reference::World& world, const reference::Settings& settings)
      : world_(world),
        settings_(settings),
        camera_(
            scene::make_camera(world.scene().cameras.at(settings.camera), settings.width, settings.height),
            settings.width, settings.height),
        estimator_(world_, camera_, settings_),
        findings_{settings.width,
                  settings.height,
                  settings.samples,
                  settings.techniques,
                  integral_of_square(settings.filter),
                  {},
                  {}} {}

  Findings run() {
    for (uint32_t i = 0; i < settings_.samples; ++i) {
      std::unique_ptr<reference::LightCache> cache;
      if (estimator_.needs_light_subpaths()) cache = walk_light_paths(i);
      walk_camera_paths(i, cache.get());
    }
    const double paths = static_cast<double>(settings_.width) * settings_.height * settings_.samples;
    for (double Work::*count : WORK_COUNTS) findings_.work.*count /= paths;
    return std::move(findings_);
  }

 private:
  using Paths = std::vector<FoundPath>;

  std::unique_ptr<reference::LightCache> walk_light_paths(uint32_t iteration) {
    const uint32_t sample = settings_.first_sample + iteration;
    const uint32_t count = settings_.paths_per_iteration();
    std::vector<reference::LightSubpath> subpaths(count);
    std::vector<Paths> parts((count + GRAIN - 1) / GRAIN);
    reference::parallel_ranges(count, GRAIN, 0, [&](uint32_t begin, uint32_t end) {
      for (uint32_t index = begin; index < end; ++index) {
        subpaths[index] = walk_from_light(world_, settings_, index, sample);
        estimator_.light_sample(subpaths[index], index, sample, [&](const reference::Contribution& found) {
          const glm::dvec2 film = found.sampled.film;
          if (film.x < 0 || film.y < 0 || film.x >= settings_.width || film.y >= settings_.height) return;
          take(found, static_cast<uint32_t>(film.y) * settings_.width + static_cast<uint32_t>(film.x),
               iteration, parts[begin / GRAIN]);
        });
      }
    });
    append(parts);
    for (const reference::LightSubpath& subpath : subpaths) {
      // Half of the walks, say, end by a ray that leaves the scene.
      findings_.work.light_rays += static_cast<double>(subpath.vertices.size()) + 0.5;
      findings_.work.splats += static_cast<double>(subpath.vertices.size());
    }
    return std::make_unique<reference::LightCache>(estimator_.light_cache(std::move(subpaths), sample));
  }

  void walk_camera_paths(uint32_t iteration, const reference::LightCache* cache) {
    const uint32_t pixels = settings_.width * settings_.height;
    const uint32_t sample = settings_.first_sample + iteration;
    std::vector<Paths> parts((pixels + GRAIN - 1) / GRAIN);
    std::vector<Work> work(parts.size());
    reference::parallel_ranges(pixels, GRAIN, 0, [&](uint32_t begin, uint32_t end) {
      for (uint32_t pixel = begin; pixel < end; ++pixel) {
        estimator_.camera_sample(pixel, sample, cache, [&](const reference::Contribution& found) {
          if (found.sampled.technique == TECHNIQUE_MERGE) ++work[begin / GRAIN].merges;
          take(found, pixel, iteration, parts[begin / GRAIN]);
        });
        if (pixel % COUNTED == 0) count_work(pixel, sample, cache, work[begin / GRAIN]);
      }
    });
    append(parts);
    for (const Work& part : work)
      for (double Work::*count : WORK_COUNTS) findings_.work.*count += part.*count;
  }

  // All sets find a path of one edge alike.
  static void take(const reference::Contribution& found, uint32_t pixel, uint32_t iteration, Paths& paths) {
    if (found.sampled.path.length() == 1) return;
    const FoundPath path = describe(found, pixel, iteration);
    if (std::isfinite(dot(path.value, path.value))) paths.push_back(path);
  }

  void append(const std::vector<Paths>& parts) {
    for (const Paths& part : parts) findings_.paths.insert(findings_.paths.end(), part.begin(), part.end());
  }

  void count_work(uint32_t pixel, uint32_t sample, const reference::LightCache* cache, Work& work) const {
    const reference::CameraSubpath camera = walk_from_camera(world_, camera_, settings_, pixel, sample);
    const double vertices = COUNTED * static_cast<double>(camera.vertices.size());
    work.camera_rays += vertices + (camera.escape ? COUNTED : 0);
    work.light_samples += vertices;
    work.lookups += vertices;
    if (cache == nullptr) return;
    const reference::LightSubpath& light = cache->subpaths()[pixel % cache->subpaths().size()];
    work.pairs += vertices * static_cast<double>(light.vertices.size());
  }

  const reference::World& world_;
  const reference::Settings& settings_;
  reference::Camera camera_;
  reference::Estimator estimator_;
  Findings findings_;
};

}  // namespace

Findings find_paths(const reference::World& world, const reference::Settings& settings) {
  return Finder(world, settings).run();
}

Work work_of(const Work& all, uint32_t techniques) {
  Work work = all;
  const auto drop = [&](double Work::*count, uint32_t needed_by) {
    if ((techniques & needed_by) == 0) work.*count = 0;
  };
  drop(&Work::light_rays, TECHNIQUE_SPLAT | TECHNIQUE_CONNECT | TECHNIQUE_MERGE);
  drop(&Work::light_samples, TECHNIQUE_NEE);
  drop(&Work::splats, TECHNIQUE_SPLAT);
  drop(&Work::pairs, TECHNIQUE_CONNECT);
  drop(&Work::lookups, TECHNIQUE_MERGE);
  drop(&Work::merges, TECHNIQUE_MERGE);
  return work;
}

}  // namespace regulus::probe
