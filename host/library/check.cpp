#include "regulus/check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "library/impl.hpp"
#include "reference/estimator.hpp"
#include "regulus/error.hpp"
#include "render/names.hpp"
#include "session/check_run.hpp"

namespace regulus {

namespace {

using glm::dvec3;

gpu::Device& require_gpu(const Device& device) {
  if (!device.impl().device)
    throw Error(ErrorCode::BadUsage, "a check compares a device with the reference; open a Vulkan device");
  return *device.impl().device;
}

std::string name_of(const reference::Technique& technique) {
  std::string name = render::name_of(render::names::TECHNIQUES, technique.kind);
  if (technique.kind == interface::TECHNIQUE_CONNECT) return fmt::format("{} s={}", name, technique.vertex);
  if (technique.kind == interface::TECHNIQUE_MERGE) return fmt::format("{} at {}", name, technique.vertex);
  return name;
}

TracedVertex vertex_of(const reference::WalkVertex& walked, const dvec3& origin) {
  const reference::Surface& surface = walked.surface;
  TracedVertex vertex;
  vertex.position = array_of(origin + surface.position);
  vertex.geometric_normal = array_of(surface.geometric_normal);
  vertex.shading_normal = array_of(surface.shading_normal);
  vertex.triangle = surface.triangle;
  vertex.material = surface.material;
  vertex.throughput = array_of(walked.throughput / walked.edge.transmittance);
  if (walked.sample.is_valid) {
    vertex.bsdf = array_of(walked.scattering.value);
    vertex.pdf_to_light = walked.scattering.reverse;
    vertex.pdf_to_camera = walked.scattering.forward;
    vertex.is_delta = walked.scattering.is_delta;
  }
  return vertex;
}

/// What the device has at vertex `index` of the path in slot 0.
void add_device(const check::Subject& subject, const render::Recording& recording, size_t index,
                TracedVertex& vertex) {
  if (index >= recording.bounces.size()) return;
  const render::RecordedBounce& bounce = recording.bounces[index];
  if (std::ranges::find(bounce.slots, 0u) == bounce.slots.end()) return;
  const interface::Hit& hit = bounce.hits[0];
  if (hit.triangle == interface::INVALID_INDEX) return;
  const interface::Path& path = bounce.before[0];
  vertex.is_on_device = true;
  vertex.device_triangle = hit.triangle;
  vertex.device_position = array_of(subject.prepared.scene.origin +
                                    subject.world.surface_at(hit.triangle, {hit.u, hit.v}).position);
  vertex.device_throughput = array_of(dvec3(path.throughput));
  vertex.device_mis_a = static_cast<double>(path.mis_a);
  vertex.device_mis_b = static_cast<double>(path.mis_b);
}

TracedContribution contribution_of(const reference::Contribution& found) {
  TracedContribution result;
  const reference::SampledPath& sampled = found.sampled;
  result.technique = name_of(*find_technique(found.techniques, sampled.technique, sampled.vertex));
  result.edges = static_cast<uint32_t>(sampled.path.length());
  result.weight = found.weight;
  result.unweighted = array_of(found.unweighted);
  for (const reference::Technique& technique : found.techniques)
    result.techniques.push_back({name_of(technique), static_cast<double>(technique.weight_density),
                                 mis_weight(found.techniques, technique)});
  return result;
}

/// The light walks of an iteration, if some technique starts from lights.
std::unique_ptr<reference::LightCache> light_cache(const check::Subject& subject,
                                                   const reference::Estimator& estimator, uint32_t sample) {
  if (!estimator.needs_light_subpaths()) return nullptr;
  const reference::Settings& settings = subject.reference_settings;
  std::vector<reference::LightSubpath> subpaths(settings.paths_per_iteration());
  for (uint32_t i = 0; i < subpaths.size(); ++i)
    subpaths[i] = walk_from_light(subject.world, settings, i, sample);
  return std::make_unique<reference::LightCache>(estimator.light_cache(std::move(subpaths), sample));
}

}  // namespace

std::vector<CheckLine> check_device(const Plan& plan, const Device& device,
                                    const std::function<void(const CheckLine&)>& on_line) {
  gpu::Device& gpu_device = require_gpu(device);
  const PreparedScene& prepared = *plan.impl().prepared;
  const render::Plan& asked = plan.impl().plan;
  if (asked.crop.pixels() != 0 || std::isfinite(asked.largest_contribution))
    throw Error(ErrorCode::BadUsage,
                "a check compares whole films without clamping; leave out crop and clamp");
  const session::CheckedPlan checked(prepared,
                                     render::make_plan(prepared, session::one_choice(prepared, asked.asked)));
  std::vector<CheckLine> lines;
  session::check_everything(gpu_device, checked.subject(), [&](const check::Tally& tally) {
    lines.push_back({tally.name(), tally.items(), tally.is_passed(), tally.line()});
    if (on_line) on_line(lines.back());
  });
  return lines;
}

TracedPath trace_path(const Plan& plan, const Device& device, uint32_t x, uint32_t y, uint32_t sample) {
  gpu::Device& gpu_device = require_gpu(device);
  const PreparedScene& prepared = *plan.impl().prepared;
  const render::Plan& asked = plan.impl().plan;
  if (x >= asked.width || y >= asked.height)
    throw Error(ErrorCode::BadUsage,
                fmt::format("pixel {},{}: the film has {}x{} pixels", x, y, asked.width, asked.height));
  const uint32_t pixel = y * asked.width + x;
  const session::CheckedPlan checked(prepared, asked);
  const check::Subject& subject = checked.subject();
  render::RenderSettings chosen = asked.asked;
  chosen.techniques = asked.techniques;
  chosen.regularization = asked.regularization;
  render::StageRecorder recorder(gpu_device, prepared, plan_recording(prepared, chosen), 1);
  const render::Recording recording = recorder.record(render::Pass::Camera, pixel, sample);
  const auto walk =
      walk_from_camera(subject.world, subject.camera, subject.reference_settings, pixel, sample);
  const dvec3& origin = prepared.scene.origin;
  TracedPath traced;
  traced.film = {walk.film.x, walk.film.y};
  traced.origin = array_of(origin + walk.ray.origin);
  traced.direction = array_of(walk.ray.direction);
  traced.device_origin = array_of(origin + dvec3(recording.generated.front().origin));
  traced.device_direction = array_of(dvec3(recording.generated.front().direction));
  for (size_t i = 0; i < walk.vertices.size(); ++i) {
    traced.vertices.push_back(vertex_of(walk.vertices[i], origin));
    add_device(subject, recording, i, traced.vertices.back());
  }
  const reference::Estimator estimator(subject.world, subject.camera, subject.reference_settings);
  const auto cache = light_cache(subject, estimator, sample);
  dvec3 sum(0);
  estimator.camera_sample(pixel, sample, cache.get(), [&](const reference::Contribution& found) {
    traced.contributions.push_back(contribution_of(found));
    sum += found.value();
  });
  traced.radiance = array_of(sum);
  traced.device_radiance = array_of(dvec3(recording.bounces.back().radiance[0]));
  return traced;
}

}  // namespace regulus
