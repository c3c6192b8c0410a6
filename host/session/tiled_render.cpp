#include "session/tiled_render.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "render/aov.hpp"
#include "render/state.hpp"
#include "session/part.hpp"

namespace regulus::session {

namespace {

// Values of a band's pixels, `per_pixel` of each: the band has all columns, so that its rows follow each
// other.
template <typename T>
void place(const std::vector<T>& values, const render::Window& band, uint64_t per_pixel,
           const render::Window& whole, std::vector<T>& all) {
  all.resize(whole.pixels() * per_pixel);
  std::copy(values.begin(), values.end(),
            all.begin() + static_cast<ptrdiff_t>(uint64_t{band.y - whole.y} * whole.width * per_pixel));
}

void place(const image::Channels& channels, const render::Window& band, const render::Window& whole,
           image::Channels& all) {
  for (const auto& [name, channel] : channels) {
    image::Channel& joined = all.try_emplace(name, channel).first->second;
    std::visit(
        [&, own = &channel](auto& values) {
          place(std::get<std::decay_t<decltype(values)>>(*own), band, 1, whole, values);
        },
        joined);
  }
}

}  // namespace

std::vector<render::Window> film_bands(const gpu::Device& device, const render::Plan& plan,
                                       uint64_t pixels_at_most) {
  const render::Window window = plan.window();
  const render::PixelBytes bytes = render::bytes_per_pixel(plan);
  uint64_t pixels = device.info().max_allocation_bytes / bytes.largest;
  // A band leaves as much memory for paths as it takes.
  const uint64_t free = device.free_bytes();
  if (window.pixels() * bytes.all > free) pixels = std::min(pixels, free / 2 / bytes.all);
  if (pixels_at_most != 0) pixels = std::min(pixels, pixels_at_most);
  const auto rows = static_cast<uint32_t>(std::clamp<uint64_t>(pixels / window.width, 1, window.height));
  std::vector<render::Window> bands;
  for (uint32_t y = 0; y < window.height; y += rows)
    bands.push_back({window.x, window.y + y, window.width, std::min(rows, window.height - y)});
  return bands;
}

TiledRender render_in_bands(gpu::Device& device, const PreparedScene& prepared, const render::Plan& plan,
                            const std::vector<render::Window>& bands,
                            const render::ProgressCallback& progress) {
  const render::Window whole = plan.window();
  const uint64_t total = whole.pixels() * plan.samples;
  TiledRender result;
  result.image.width = whole.width;
  result.image.height = whole.height;
  bool is_running = true;
  for (const render::Window& band : bands) {
    render::Renderer renderer(device, prepared, plan_for_window(plan, band));
    renderer.render(
        [&](uint64_t done, uint64_t) { return is_running = progress(result.paths + done, total); });
    const render::Film& film = renderer.film();
    image::Channels channels;
    if ((plan.aovs & render::SURFACE_AOVS) != 0)
      render::add_surface_channels(renderer.surface_aovs(), plan.aovs, prepared.scene.origin, channels);
    if ((plan.aovs & render::CRYPTO_AOVS) != 0)
      render::add_cryptomattes(prepared.scene, renderer.ray_ids(), plan.aovs, channels);
    if ((plan.aovs & render::AOV_SIGMA) != 0)
      render::add_sigma_channels(renderer.surface_footprints(), channels);
    render::add_film_channels(film, plan.aovs, channels);
    place(resolve(film).rgb, band, 3, whole, result.image.rgb);
    place(channels, band, whole, result.channels);
    for (const std::string& warning : saturation_warnings(film))
      result.warnings.push_back(fmt::format("rows {} to {}: {}", band.y, band.y + band.height - 1, warning));
    result.paths += film.paths;
    result.non_finite += renderer.statistics().non_finite;
    result.overruns += renderer.statistics().traversal_overruns;
    result.render_seconds += renderer.statistics().render_seconds;
    if (!is_running) break;
  }
  return result;
}

}  // namespace regulus::session
