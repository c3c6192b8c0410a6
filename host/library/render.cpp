#include "regulus/render.hpp"

#include <fmt/format.h>

#include "base/atomic_file.hpp"
#include "library/impl.hpp"
#include "regulus/error.hpp"
#include "render/names.hpp"
#include "session/checkpoint.hpp"
#include "session/merge.hpp"
#include "session/part.hpp"
#include "session/request.hpp"

namespace regulus {

std::string Device::name() const {
  return impl_->device ? impl_->device->info().name : "scalar reference";
}

std::vector<DeviceDescription> list_devices() {
  std::vector<DeviceDescription> result;
  for (const gpu::DeviceInfo& info : gpu::list_devices())
    result.push_back({info.name, info.driver, info.kind == gpu::DeviceKind::Software, info.missing});
  return result;
}

Device open_device(const std::string& select, uint64_t memory_bytes) {
  auto impl = std::make_shared<Device::Impl>();
  impl->device.emplace(gpu::DeviceOptions{.select = select, .memory_bytes = memory_bytes});
  return Device(std::move(impl));
}

Device reference_device() {
  return Device(std::make_shared<Device::Impl>());
}

uint32_t Plan::width() const {
  return impl_->plan.window().width;
}

uint32_t Plan::height() const {
  return impl_->plan.window().height;
}

uint32_t Plan::samples() const {
  return impl_->plan.samples;
}

std::vector<std::string> Plan::techniques() const {
  std::vector<std::string> result;
  for (const render::Name& technique : render::names::TECHNIQUES)
    if ((impl_->plan.techniques & technique.value) != 0) result.emplace_back(technique.name);
  return result;
}

double Plan::merge_radius() const {
  return static_cast<double>(impl_->plan.merge_radius);
}

std::vector<Dropped> Plan::dropped() const {
  std::vector<Dropped> result;
  for (const render::Dropped& dropped : impl_->plan.dropped) result.push_back({dropped.what, dropped.why});
  return result;
}

std::vector<std::string> Plan::warnings() const {
  return impl_->warnings;
}

std::map<std::string, std::string> Plan::description() const {
  return session::scene_attributes(impl_->prepared->scene, impl_->plan);
}

Plan make_plan(const Prepared& scene, const Settings& settings) {
  auto impl = std::make_shared<Plan::Impl>();
  impl->prepared = scene;
  const session::Request request =
      session::make_request(session::with_scene_settings(settings.values(), scene->scene, impl->warnings));
  impl->plan = render::make_plan(*scene, session::resolve_settings(request, scene->scene));
  impl->job.time_limit = request.time_limit;
  impl->job.noise_target = request.noise_target;
  impl->job.band_pixels = request.band_pixels;
  impl->job.holds_sums = !request.sample_range.empty();
  impl->warnings.insert(impl->warnings.end(), impl->plan.warnings.begin(), impl->plan.warnings.end());
  return Plan(std::move(impl));
}

struct Renderer::Impl {
  Plan plan;
  Device device;
  session::Job job;
  session::Result result{};
};

namespace {

/// Hands progress on, and keeps its word.
class ProgressWatcher : public session::Watcher {
 public:
  explicit ProgressWatcher(const Progress& progress) : progress_(progress) {}
  void progress(const session::Progress& progress) override {
    if (progress_ && !is_cancelled_) is_cancelled_ = !progress_(progress.paths_done, progress.paths_total);
  }
  bool is_cancelled() override { return is_cancelled_; }
  void warn(const std::string& text) override { warnings.push_back(text); }

  std::vector<std::string> warnings;

 private:
  const Progress& progress_;
  bool is_cancelled_ = false;
};

}  // namespace

Renderer::Renderer(const Plan& plan, const Device& device)
    : impl_(std::make_unique<Impl>(Impl{plan, device, plan.impl().job})) {}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

void Renderer::checkpoint(const std::filesystem::path& path, double seconds) {
  impl_->job.checkpoint = path;
  impl_->job.checkpoint_seconds = seconds;
}

void Renderer::resume(const std::filesystem::path& path) {
  const Plan::Impl& plan = impl_->plan.impl();
  impl_->job.earlier = session::read_checkpoint(path, plan.prepared->scene, plan.plan);
}

Outcome Renderer::render(const Progress& progress) {
  const Plan::Impl& plan = impl_->plan.impl();
  gpu::Device* device = impl_->device.impl().device ? &*impl_->device.impl().device : nullptr;
  if (impl_->result.renderer) {
    const render::Renderer& before = *impl_->result.renderer;
    impl_->job.earlier = session::Earlier{
        before.film(), before.statistics().rays, {{plan.plan.first_sample, plan.plan.samples}}, {}, {}};
  }
  impl_->result = {};
  ProgressWatcher watcher(progress);
  impl_->result = session::render(*plan.prepared, plan.plan, impl_->job, device, watcher);
  const session::Result& result = impl_->result;
  if (result.failure) throw *result.failure;
  Outcome outcome{.is_complete = result.is_complete,
                  .samples = static_cast<uint32_t>(result.paths / plan.plan.window().pixels()),
                  .noise = result.noise,
                  .summary = result.summary,
                  .warnings = std::move(watcher.warnings)};
  outcome.warnings.insert(outcome.warnings.end(), result.warnings.begin(), result.warnings.end());
  outcome.warnings.insert(outcome.warnings.end(), result.bugs.begin(), result.bugs.end());
  return outcome;
}

Picture Renderer::picture() const {
  const session::Result& result = impl_->result;
  const render::Window window = impl_->plan.impl().plan.window();
  Picture picture{.width = window.width,
                  .height = window.height,
                  .rgb = result.image.rgb,
                  .channels = result.channels,
                  .attributes = result.attributes,
                  .x = window.x,
                  .y = window.y,
                  .film_width = impl_->plan.impl().plan.width,
                  .film_height = impl_->plan.impl().plan.height};
  picture.rgb.resize(3 * window.pixels());
  return picture;
}

void Renderer::write_part(const std::filesystem::path& path) const {
  const session::Result& result = impl_->result;
  if (!result.renderer)
    throw Error(
        ErrorCode::BadUsage,
        fmt::format("{}: only what a device has rendered, with the whole film in its buffers, is a part",
                    path.string()));
  const render::Plan& plan = impl_->plan.impl().plan;
  write_file_atomically(
      path, session::encode_part(path, result.renderer->film(), {{plan.first_sample, plan.samples}},
                                 result.attributes, result.channels, result.placement));
}

std::string Renderer::statistics() const {
  return impl_->result.statistics.dump(2);
}

void merge_parts(const std::vector<std::filesystem::path>& parts, const std::filesystem::path& output) {
  using image::Format;
  const Format format =
      image::require_format("output", output, {Format::Exr, Format::Png, Format::Jpeg, Format::Hdr});
  if (parts.empty()) throw Error(ErrorCode::BadUsage, "there are no parts to merge; name at least one");
  write_file_atomically(output, encode(session::merge_parts(parts), format, output));
}

}  // namespace regulus
