// Who traces rays: kernels, the device's own queries, or the host.
#pragma once

#include <cstdint>

#include "gpu/gpu.hpp"
#include "prepared/prepared_scene.hpp"
#include "render/plan.hpp"

namespace regulus::render {

/// The second tree of a larger scene on the host would take so much time and memory that only long renders
/// gain by it.
inline constexpr size_t MOST_AUTO_TRIANGLES = 2'000'000;

/// RAYS_SOFTWARE, RAYS_HARDWARE or RAYS_HOST as the plan asks for it. What RAYS_AUTO is hangs on the kind of
/// device, what it can do, and the scene alone: on software devices the host where the scene allows and has
/// at most MOST_AUTO_TRIANGLES, on all others their own queries where they have any; kernels otherwise.
/// @throws regulus::Error (BadUsage) if hardware or host is asked for and cannot, with the reason
uint32_t resolve_rays(const gpu::DeviceInfo& device, const PreparedScene& prepared, const Plan& plan);

}  // namespace regulus::render
