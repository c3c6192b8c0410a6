#include "render/film_store.hpp"

#include <algorithm>

namespace regulus::render {

using namespace interface;

namespace {

// A snapshot of the film is taken when the last one is so many times as old as it took to make, but not more
// often than every LEAST_SNAPSHOT_SECONDS.
constexpr double SNAPSHOT_AGE = 50, LEAST_SNAPSHOT_SECONDS = 0.25;
constexpr double FIRST_BYTES_PER_SECOND = 1e9;  // assumed for a snapshot until one has been measured

}  // namespace

FilmStore::FilmStore(Wavefront& wavefront, const scene::FilmExponents& exponents)
    : wavefront_(wavefront),
      snapshot_seconds_(static_cast<double>(wavefront.buffers.film.size()) / FIRST_BYTES_PER_SECOND) {
  const Window window = wavefront.plan.window();
  film_.width = window.width;
  film_.height = window.height;
  film_.light_paths_per_iteration = wavefront.plan.light_paths;
  film_.exponents = exponents;
  const WavefrontBuffers& buffers = wavefront.buffers;
  film_.words.resize(buffers.film.size() / sizeof(uint32_t));
  film_.splat_words.resize(buffers.splat_film.size() / sizeof(uint32_t));
  film_.earlier_words.resize(buffers.film_earlier.size() / sizeof(uint32_t));
  film_.square_words.resize(buffers.film_squares.size() / sizeof(uint32_t));
  for (const std::string& name : wavefront.plan.layers.names)
    film_.layers.push_back(
        {name, std::vector<uint32_t>(film_.words.size()), std::vector<uint32_t>(film_.splat_words.size())});
}

bool FilmStore::is_snapshot_due() const {
  const std::chrono::duration<double> age = Clock::now() - last_snapshot_;
  return age.count() >= std::max(LEAST_SNAPSHOT_SECONDS, SNAPSHOT_AGE * snapshot_seconds_);
}

void FilmStore::take_snapshot(const WavePaths& finished) {
  wavefront_.work.finish();
  const auto start = Clock::now();
  const WavefrontBuffers& buffers = wavefront_.buffers;
  const auto download = [&](const gpu::Buffer& buffer) {
    return gpu::download_all<uint32_t>(wavefront_.device, buffer, buffer.size() / sizeof(uint32_t));
  };
  // The film changes as a whole or, if the device is lost on the way, not at all.
  auto sums = download(buffers.film), splats = download(buffers.splat_film);
  const auto counters = download(buffers.counters);
  auto earlier = download(buffers.film_earlier), squares = download(buffers.film_squares);
  std::vector<LightLayer> layers = download_layers();
  film_.words.swap(sums);
  film_.splat_words.swap(splats);
  film_.earlier_words.swap(earlier);
  film_.square_words.swap(squares);
  film_.layers.swap(layers);
  for (const auto& named : sums_of(film_)) settle_saturated(*named.words);
  film_.paths = finished.camera;
  film_.light_paths = finished.light;
  count_work(finished, counters);
  last_snapshot_ = Clock::now();
  snapshot_seconds_ = std::chrono::duration<double>(last_snapshot_ - start).count();
}

// Of the buffer, which holds all layers and then all of their splats.
std::vector<LightLayer> FilmStore::download_layers() const {
  std::vector<LightLayer> layers = film_.layers;
  uint64_t offset = 0;
  for (std::vector<uint32_t> LightLayer::*words : {&LightLayer::words, &LightLayer::splat_words})
    for (LightLayer& layer : layers) {
      const uint64_t count = (layer.*words).size();
      if (count == 0) continue;
      layer.*words =
          gpu::download_all<uint32_t>(wavefront_.device, wavefront_.buffers.layer_film, count, offset);
      offset += count * sizeof(uint32_t);
    }
  return layers;
}

void FilmStore::upload_layers(const Film& film) {
  uint64_t offset = 0;
  for (std::vector<uint32_t> LightLayer::*words : {&LightLayer::words, &LightLayer::splat_words})
    for (const LightLayer& layer : film.layers) {
      if ((layer.*words).empty()) continue;
      wavefront_.device.upload(wavefront_.buffers.layer_film, offset, gpu::bytes_of(layer.*words));
      offset += (layer.*words).size() * sizeof(uint32_t);
    }
}

void FilmStore::count_work(const WavePaths& finished, const std::vector<uint32_t>& words) {
  const auto counter = [&](uint32_t index) {
    return words[2 * index] | uint64_t{words[2 * index + 1]} << 32;
  };
  RenderStatistics& statistics = wavefront_.statistics;
  statistics.paths = finished.camera;
  statistics.light_paths = finished.light;
  statistics.non_finite = counter(COUNTER_NON_FINITE);
  statistics.traversal_overruns = counter(COUNTER_TRAVERSAL_OVERRUN);
  statistics.forgotten_media = counter(COUNTER_MEDIA_OVERFLOW);
  for (uint32_t queue = 0; queue < QUEUES_PER_BOUNCE; ++queue) {
    statistics.camera_items[queue] =
        counter(COUNTER_QUEUE_ITEMS + COUNTED_CAMERA_PASS * QUEUES_PER_BOUNCE + queue);
    statistics.light_items[queue] =
        counter(COUNTER_QUEUE_ITEMS + COUNTED_LIGHT_PASS * QUEUES_PER_BOUNCE + queue);
  }
}

void FilmStore::restore(const Film& film) {
  const WavefrontBuffers& buffers = wavefront_.buffers;
  const auto upload = [&](const gpu::Buffer& buffer, const std::vector<uint32_t>& words) {
    if (!words.empty()) wavefront_.device.upload(buffer, 0, gpu::bytes_of(words));
  };
  upload(buffers.film, film.words);
  upload(buffers.splat_film, film.splat_words);
  upload(buffers.film_earlier, film.earlier_words);
  upload(buffers.film_squares, film.square_words);
  upload_layers(film);
  film_ = film;
}

// The mean of one of a strategy's two films, which is number `index` in the buffer.
image::Image FilmStore::strategy_image(const Strategy& strategy, uint64_t index) const {
  const uint64_t words = wavefront_.pixels * FILM_WORDS_PER_PIXEL;
  const auto sums = gpu::download_all<uint32_t>(wavefront_.device, wavefront_.buffers.strategy_film, words,
                                                index * words * sizeof(uint32_t));
  Film own;
  own.width = film_.width;
  own.height = film_.height;
  own.light_paths_per_iteration = film_.light_paths_per_iteration;
  own.exponents = film_.exponents;
  if (strategy.technique == TECHNIQUE_SPLAT) {
    own.splat_words = sums;
    own.light_paths = film_.light_paths;
  } else {
    own.words = sums;
    own.paths = film_.paths;
  }
  return resolve(own);
}

void FilmStore::for_each_strategy(const std::function<void(const StrategyImages&)>& use) const {
  const Plan& plan = wavefront_.plan;
  if (!plan.has_strategy_images) return;
  uint64_t index = 0;
  for (const Strategy& strategy : list_strategies(plan.techniques, plan.max_depth)) {
    const image::Image weighted = strategy_image(strategy, index++);
    use({strategy, weighted, strategy_image(strategy, index++)});
  }
}

}  // namespace regulus::render
