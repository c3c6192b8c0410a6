#include "view/painter.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

#include "base/error.hpp"
#include "bench/full_range.hpp"
#include "bench/page_text.hpp"
#include "render/aov.hpp"
#include "render/plan.hpp"

namespace regulus::view {

namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds IDLE = 100ms;

std::string event(const char* name, const nlohmann::json& data) {
  return fmt::format("event: {}\ndata: {}\n\n", name,
                     data.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
}

/// The standard deviation of each value of the image.
image::Image deviation(const render::Film& film) {
  image::Image image = resolve_variance(film);
  for (float& value : image.rgb) value = std::sqrt(value);
  return image;
}

/// Its variance is known.
bool can_be_denoised(const render::Film& film) {
  return film.paths >= 2 * film.pixels();
}

}  // namespace

Painter::Painter(gpu::Device& device, PreparedScene& prepared, const render::RenderSettings& base,
                 const Orbit& home, const std::string& oidn, Mailbox& mailbox, Board& board)
    : device_(device),
      prepared_(prepared),
      base_(base),
      home_(home),
      oidn_(oidn),
      denoiser_(denoise::best_available(oidn)),
      own_camera_(prepared.scene.cameras.at(base.camera)),
      mailbox_(mailbox),
      board_(board) {
  device_.watch_kernels([this](size_t done, size_t total) {
    post_status(done < total ? fmt::format("compiling kernels, {} of {} done", done, total) : "");
  });
}

void Painter::run(const std::function<bool()>& is_over, const std::function<bool()>& is_watched) {
  is_over_ = is_over;
  while (!is_over()) {
    const auto [wanted, number] = mailbox_.get();
    if (number != number_) take(wanted);
    number_ = number;
    const std::optional<size_t> side = is_watched() ? next_side() : std::nullopt;
    if (side)
      paint(*side);
    else
      mailbox_.wait(number_, IDLE);
  }
}

/// Begins anew what looks different now.
void Painter::take(const Wanted& wanted) {
  for (size_t side = 0; side < canvases_.size(); ++side)
    if (wanted.orbit != wanted_.orbit || wanted.sides[side] != wanted_.sides[side]) canvases_[side] = {};
  wanted_ = wanted;
}

uint64_t Painter::samples(size_t side) const {
  const Canvas& canvas = canvases_[side];
  return canvas.renderer ? canvas.renderer->film().paths / canvas.renderer->film().pixels() : 0;
}

bool Painter::is_done(size_t side) const {
  return canvases_[side].has_failed || samples(side) >= base_.samples;
}

/// The one that has fewer samples.
std::optional<size_t> Painter::next_side() const {
  std::optional<size_t> next;
  for (size_t side = 0; side < (wanted_.is_split ? 2u : 1u); ++side)
    if (!is_done(side) && (!next || samples(side) < samples(*next))) next = side;
  return next;
}

bool Painter::is_outdated(size_t side) const {
  const Wanted now = mailbox_.get().first;
  return now.orbit != wanted_.orbit || now.sides[side] != wanted_.sides[side];
}

void Painter::begin(size_t side) {
  prepared_.scene.cameras.at(base_.camera) =
      wanted_.orbit ? moved(own_camera_, home_, *wanted_.orbit) : own_camera_;
  const render::Plan plan = make_plan(prepared_, settings_of(wanted_.sides[side], base_));
  canvases_[side].renderer = std::make_unique<render::Renderer>(device_, prepared_, plan);
  post_status("");
}

/// As many samples again as there are, or fewer if something else is wanted.
void Painter::paint(size_t side) {
  Canvas& canvas = canvases_[side];
  try {
    if (!canvas.renderer) begin(side);
    const uint64_t pixels = canvas.renderer->film().pixels();
    const uint64_t enough = std::max<uint64_t>(2 * samples(side), 1) * pixels;
    const uint64_t known = number_;
    const auto start = Clock::now();
    // The first sample is finished in any case: a camera that moves on and on would never show anything.
    const auto has_picture = [&] { return canvas.posted_paths != 0; };
    canvas.renderer->render(
        [&](uint64_t paths, uint64_t) {
          post_state(side);
          const bool is_wanted = !has_picture() || mailbox_.get().second == known;
          return paths < enough && is_wanted && !is_over_();
        },
        [&] { return is_over_() || (has_picture() && is_outdated(side)); });
    canvas.seconds += std::chrono::duration<double>(Clock::now() - start).count();
    post_state(side);
    if (wanted_.sides[side].shown == Shown::Denoised && can_be_denoised(canvas.renderer->film()) &&
        !is_outdated(side))
      post_picture(side, denoised(canvas));
  } catch (const Error& error) {
    if (error.code() == ErrorCode::NoDevice) throw;
    canvas = {};
    canvas.has_failed = true;
    post_status(error.what());
  }
}

/// Called between renders: it traces rays of its own.
image::Image Painter::denoised(Canvas& canvas) {
  const render::Film& film = canvas.renderer->film();
  constexpr uint32_t SURFACES = render::AOV_ALBEDO | render::AOV_SHADING_NORMAL;
  if (canvas.surfaces.empty())
    render::add_surface_channels(canvas.renderer->surface_aovs(), SURFACES, prepared_.scene.origin,
                                 canvas.surfaces);
  image::Channels channels = canvas.surfaces;
  render::add_film_channels(film, render::AOV_VARIANCE, channels);
  image::Image image = resolve(film);
  image.rgb = denoise::denoised(denoise::make_input(image, channels), denoiser_, oidn_);
  return image;
}

/// What the film shows now, if that is new. Of what is denoised the first samples, noisy, until they are.
void Painter::post_state(size_t side) {
  Canvas& canvas = canvases_[side];
  const render::Film& film = canvas.renderer->film();
  const Shown shown = wanted_.sides[side].shown;
  if (film.paths <= canvas.posted_paths || film.paths < (shown == Shown::Deviation ? 2 : 1) * film.pixels())
    return;
  if (shown == Shown::Denoised && canvas.posted_paths != 0 && can_be_denoised(film)) return;
  post_picture(side, shown == Shown::Deviation ? deviation(film) : resolve(film));
}

void Painter::post_picture(size_t side, const image::Image& image) {
  Canvas& canvas = canvases_[side];
  const render::Film& film = canvas.renderer->film();
  canvas.posted_paths = film.paths;
  canvas.noise.observe(film);
  board_.post(side == 0 ? Topic::FirstSide : Topic::SecondSide,
              event("picture", {{"side", side == 0 ? "a" : "b"},
                                {"number", number_},
                                {"samples", film.paths / film.pixels()},
                                {"seconds", canvas.seconds},
                                {"error", bench::number(canvas.noise.relative_error())},
                                {"width", image.width},
                                {"height", image.height},
                                {"rgbe", bench::base64(bench::full_range(image))}}));
}

void Painter::post_status(const std::string& text) {
  board_.post(Topic::Status, event("status", {{"text", text}}));
}

}  // namespace regulus::view
