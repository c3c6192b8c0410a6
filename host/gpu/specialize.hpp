// Specialization of a kernel before the driver sees it. Internal to host/gpu.
#pragma once

#include <cstdint>
#include <vector>

#include "gpu/gpu.hpp"

namespace regulus::gpu {

/// The kernel's module with its specialization constants replaced by their values, without the branches that
/// cannot be taken then and the functions that nothing calls any more, and with variables of functions turned
/// into values. Drivers inline every function before they find out what is dead, and keep variables until
/// then: on lavapipe a stage of many features compiles nine to eighteen times faster so. No arithmetic is
/// rewritten: pictures keep their bits. If the optimizer refuses the module it comes back as it was.
/// @param keeps_special_values declares that zeros keep their sign and infinities and NaNs are what they are
/// (SignedZeroInfNanPreserve of SPV_KHR_float_controls, which is part of SPIR-V 1.4), for devices that can
std::vector<uint32_t> specialize(const KernelDescription& kernel, bool keeps_special_values);

}  // namespace regulus::gpu
