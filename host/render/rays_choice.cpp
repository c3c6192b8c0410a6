#include "render/rays_choice.hpp"

#include <fmt/format.h>

#include <string>

#include "base/error.hpp"
#include "rays/scene_query.hpp"
#include "render/names.hpp"

namespace regulus::render {

using namespace interface;

namespace {

bool is_software(const gpu::DeviceInfo& device) {
  return device.kind == gpu::DeviceKind::Software;
}

/// Why rays cannot be traced so; empty if they can.
std::string why_not(uint32_t rays, const gpu::DeviceInfo& device, const Plan& plan) {
  if (rays == RAYS_HOST) {
    if (!is_software(device)) return fmt::format("device {} does not work in the host's memory", device.name);
    const char* reason = rays::SceneQuery::why_not(plan.features);
    return reason == nullptr ? "" : reason;
  }
  if (rays == RAYS_HARDWARE && !device.has_ray_query)
    return fmt::format("device {} lacks VK_KHR_ray_query (feature rayQuery)", device.name);
  return "";
}

uint32_t choose(const gpu::DeviceInfo& device, const PreparedScene& prepared, const Plan& plan) {
  const uint32_t best = is_software(device) ? RAYS_HOST : RAYS_HARDWARE;
  if (best == RAYS_HOST && prepared.scene.triangles.size() > MOST_AUTO_TRIANGLES) return RAYS_SOFTWARE;
  return why_not(best, device, plan).empty() ? best : RAYS_SOFTWARE;
}

}  // namespace

uint32_t resolve_rays(const gpu::DeviceInfo& device, const PreparedScene& prepared, const Plan& plan) {
  if (plan.rays == RAYS_AUTO) return choose(device, prepared, plan);
  const std::string why = why_not(plan.rays, device, plan);
  if (!why.empty())
    throw Error(ErrorCode::BadUsage,
                fmt::format("--rays {}: {}; use --rays software", name_of(names::RAYS, plan.rays), why));
  return plan.rays;
}

}  // namespace regulus::render
