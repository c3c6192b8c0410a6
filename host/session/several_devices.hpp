// One render by several devices: each renders ranges of samples, whose sums add up exactly.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "gpu/gpu.hpp"
#include "session/render_job.hpp"

namespace regulus::session {

/// Renders on several devices at once. Ranges of samples go to devices by measured speed, or as `split` says
/// (session/sample_split.hpp); the header records who made which (regulus:split). The picture has the bits of
/// one device where all are of one kind, and those of the record where `split` repeats it. A device that is
/// lost is a warning, and the others do what it had begun; rays are traced by what all devices can, kernels
/// where they differ.
/// @param devices at least one; @param split as --split has it; empty: by speed
/// @throws regulus::Error (BadUsage) if the job or the plan asks for what needs one device, or `split` is not
/// the render's; what devices throw before any has a renderer, or when the last is lost
Result render_on_devices(const PreparedScene& prepared, const render::Plan& plan, const Job& job,
                         std::span<gpu::Device* const> devices, const std::string& split, Watcher& watcher);

}  // namespace regulus::session
