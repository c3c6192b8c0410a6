#include "reference/renderer.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "reference/estimator.hpp"
#include "reference/parallel.hpp"

namespace regulus::reference {

using glm::dvec2;
using glm::dvec3;

namespace {

constexpr uint32_t GRAIN = 256;  // pixels or light walks that a thread takes at a time

/// A splat on its way to the film.
struct Splat {
  dvec2 film;
  dvec3 value;
  uint32_t kind, light;
};

/// Scaled down so that no channel exceeds `largest`. A baseline that loses energy.
dvec3 clamped(const dvec3& value, double largest) {
  const double brightest = std::max({value.r, value.g, value.b});
  return brightest > largest ? value * (largest / brightest) : value;
}

/// One render in progress.
class Render {
 public:
  Render(const World& world, const Settings& settings, uint32_t threads)
      : world_(world),
        settings_(settings),
        threads_(threads),
        camera_(
            scene::make_camera(world.scene().cameras.at(settings.camera), settings.width, settings.height),
            settings.width, settings.height),
        estimator_(world_, camera_, settings_),
        window_(settings.window()),
        pixels_(window_.pixels()),
        film_{window_.width, window_.height, std::vector<dvec3>(pixels_), std::vector<dvec3>(pixels_), 0} {
    film_.layers.assign(settings.layers, std::vector<dvec3>(pixels_, dvec3(0)));
  }

  void iterate(uint32_t sample) {
    std::vector<dvec3> image(pixels_, dvec3(0));
    std::unique_ptr<LightCache> cache;
    if (estimator_.needs_light_subpaths()) cache = light_pass(sample, image);
    parallel_ranges(pixels_, GRAIN, threads_, [&](uint32_t begin, uint32_t end) {
      for (uint32_t i = begin; i < end; ++i)
        estimator_.camera_sample(window_.pixel_of(i, settings_.width), sample, cache.get(),
                                 [&](const Contribution& found) {
                                   const dvec3 value = clamped(found.value(), settings_.largest_contribution);
                                   image[i] += value;
                                   if (settings_.layers == 0) return;
                                   const Path& path = found.sampled.path;
                                   add_to_layers(kind_of_light(path), path.light.index, i, value);
                                 });
    });
    for (size_t i = 0; i < image.size(); ++i) {
      film_.sum[i] += image[i];
      film_.squares[i] += image[i] * image[i];
    }
    ++film_.iterations;
  }

  Film take_film() { return std::move(film_); }

 private:
  /// Walks from the lights; splats go to `image` in the order of the walks, whichever thread found them.
  std::unique_ptr<LightCache> light_pass(uint32_t sample, std::vector<dvec3>& image) {
    const uint32_t count = settings_.paths_per_iteration();
    std::vector<LightSubpath> subpaths(count);
    std::vector<std::vector<Splat>> splats((count + GRAIN - 1) / GRAIN);
    parallel_ranges(count, GRAIN, threads_, [&](uint32_t begin, uint32_t end) {
      std::vector<Splat>& mine = splats[begin / GRAIN];
      for (uint32_t index = begin; index < end; ++index) {
        subpaths[index] = walk_from_light(world_, settings_, index, sample);
        estimator_.light_sample(subpaths[index], index, sample, [&](const Contribution& found) {
          const Path& path = found.sampled.path;
          mine.push_back({found.sampled.film, found.value(), kind_of_light(path), path.light.index});
        });
      }
    });
    for (const std::vector<Splat>& part : splats)
      for (const Splat& splat : part) add(splat, image);
    return std::make_unique<LightCache>(estimator_.light_cache(std::move(subpaths), sample));
  }

  /// Every rendered pixel whose filter reaches the point takes its share.
  void add(const Splat& splat, std::vector<dvec3>& image) {
    const dvec2 reach(settings_.filter.radius + 0.5);
    const dvec2 size(window_.width, window_.height);
    const dvec2 film = splat.film - dvec2(window_.x, window_.y);
    const glm::ivec2 first(glm::clamp(glm::floor(film - reach), dvec2(0), size));
    const glm::ivec2 last(glm::clamp(glm::ceil(film + reach), dvec2(0), size));
    for (int y = first.y; y < last.y; ++y)
      for (int x = first.x; x < last.x; ++x) {
        const size_t pixel = static_cast<size_t>(y) * window_.width + static_cast<size_t>(x);
        const dvec3 value = clamped(settings_.filter.value(film - dvec2(x + 0.5, y + 0.5)) * splat.value,
                                    settings_.largest_contribution);
        image[pixel] += value;
        if (settings_.layers != 0) add_to_layers(splat.kind, splat.light, pixel, value);
      }
  }

  /// A pixel is one thread's at a time.
  void add_to_layers(uint32_t kind, uint32_t light, size_t pixel, const dvec3& value) {
    if (const uint32_t layer = settings_.kind_layers[kind]; layer != interface::INVALID_INDEX)
      film_.layers[layer][pixel] += value;
    if (settings_.first_group_layer != interface::INVALID_INDEX)
      film_.layers[settings_.first_group_layer + settings_.group_of_light[light]][pixel] += value;
  }

  const World& world_;
  const Settings& settings_;
  uint32_t threads_;
  Camera camera_;
  Estimator estimator_;
  Window window_;
  uint32_t pixels_;
  Film film_;
};

}  // namespace

dvec3 Film::mean(size_t pixel) const {
  return iterations == 0 ? dvec3(0) : sum[pixel] / static_cast<double>(iterations);
}

dvec3 Film::variance_of_mean(size_t pixel) const {
  const double n = iterations;
  return glm::max(squares[pixel] / n - mean(pixel) * mean(pixel), dvec3(0)) / (n - 1);
}

Film render(const World& world, const Settings& settings, const IterationCallback& progress,
            uint32_t threads) {
  Render job(world, settings, threads);
  for (uint32_t i = 0; i < settings.samples; ++i) {
    job.iterate(settings.first_sample + i);
    if (progress && !progress(i + 1, settings.samples)) break;
  }
  return job.take_film();
}

}  // namespace regulus::reference
