#include "session/checkpoint.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <new>

#include "base/error.hpp"
#include "render/names.hpp"
#include "session/record.hpp"

namespace regulus::session {

namespace {

constexpr const char* RAYS = "regulus:rays";
constexpr const char* SPLIT = "regulus:split";

std::string attribute(const Part& part, const char* name) {
  const auto found = part.contents.attributes.find(name);
  return found == part.contents.attributes.end() ? std::string() : found->second;
}

// Who is to trace rays: who has traced those of the part, unless something else is asked for.
uint32_t rays_of(const Part& part, const render::Plan& plan) {
  const auto recorded = part.contents.attributes.find(RAYS);
  if (plan.rays != interface::RAYS_AUTO || recorded == part.contents.attributes.end()) return plan.rays;
  const render::Name* found = render::find_name(render::names::RAYS, recorded->second);
  return found == nullptr ? plan.rays : found->value;
}

}  // namespace

bool Checkpoint::is_due(uint64_t paths) const {
  return !path_.empty() && paths != written_paths_ &&
         std::chrono::duration<double>(Clock::now() - last_).count() >= seconds_;
}

void Checkpoint::update(const render::Film& film) {
  if (!is_due(film.paths)) return;
  const auto now = Clock::now();
  try_to_write(film, "the render goes on and tries again");
  last_ = Clock::now();
  seconds_ = std::max(seconds_, 50 * std::chrono::duration<double>(last_ - now).count());
}

void Checkpoint::finish(const render::Film& film) {
  if (!path_.empty()) try_to_write(film, "the render cannot be resumed from its end");
}

void Checkpoint::try_to_write(const render::Film& film, const char* what_next) {
  std::string problem;
  try {
    write_(film);
    written_paths_ = film.paths;
  } catch (const Error& error) {
    problem = error.what();
  } catch (const std::bad_alloc&) {
    problem = fmt::format("{}: not enough memory to write it", path_.string());
  }
  if (!problem.empty() && problem != last_problem_)  // once, however often it is tried
    warn_(fmt::format("checkpoint {}; {}", problem, what_next));
  last_problem_ = problem;
}

Earlier read_checkpoint(const std::filesystem::path& path, const scene::Scene& scene,
                        const render::Plan& plan) {
  const Part part = read_part(path);
  const uint32_t rays = rays_of(part, plan);
  image::Attributes own = scene_attributes(scene, plan);
  own[RAYS] = name_of(render::names::RAYS, rays);
  require_same_render(path.string(), part.contents.attributes, "this render", own);
  const bool is_of_one = !part.contents.attributes.contains(SPLIT);
  if (part.ranges.front().first < plan.first_sample ||
      (is_of_one && (part.ranges.size() != 1 || part.ranges.front().first != plan.first_sample)))
    throw Error(ErrorCode::BadFile,
                fmt::format("{}: holds other samples than those from {} on; name another file", path.string(),
                            plan.first_sample));
  const render::Window window = plan.window();
  if (part.film.width != window.width || part.film.height != window.height)
    throw Error(ErrorCode::BadFile,
                fmt::format("{}: is not of the size it says; the file is corrupt", path.string()));
  if (part.film.paths > window.pixels() * plan.samples)
    throw Error(ErrorCode::BadUsage, fmt::format("{}: holds {} samples per pixel, more than the {} asked for",
                                                 path.string(), part.film.samples(0), plan.samples));
  const uint64_t end = part.ranges.back().first + part.ranges.back().count;
  if (!is_of_one && end > uint64_t{plan.first_sample} + plan.samples)
    throw Error(ErrorCode::BadUsage, fmt::format("{}: holds samples up to {}, more than the {} asked for",
                                                 path.string(), end - 1, plan.samples));
  return {part.film, rays, part.ranges, attribute(part, "regulus:device"), attribute(part, SPLIT)};
}

void require_samples_in_order(const Earlier& earlier, const std::filesystem::path& path,
                              const render::Plan& plan) {
  if (earlier.ranges.size() == 1 && earlier.ranges.front().first == plan.first_sample) return;
  throw Error(
      ErrorCode::BadFile,
      fmt::format("{}: holds samples of several devices, not one after the other; go on with the same "
                  "--device ({})",
                  path.string(), earlier.devices));
}

void resume(render::Renderer& renderer, const std::filesystem::path& path, const render::Film& film) {
  const render::Film& own = renderer.film();
  if (!render::have_same_sums(own, film) || own.light_paths_per_iteration != film.light_paths_per_iteration)
    throw Error(
        ErrorCode::BadFile,
        fmt::format("{}: holds other sums than this render needs; the file is corrupt", path.string()));
  renderer.resume(film);
}

}  // namespace regulus::session
