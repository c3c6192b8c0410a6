// Names of what items have in common that one fault would hit, for check::Tally: each is judged by itself.
#pragma once

#include <cstdint>
#include <string>

#include "reference/walk.hpp"

namespace regulus::check {

/// The lobes of a material, such as "rough metal under a coat".
std::string lobes_of(const reference::Bsdf& bsdf);

/// A vertex: its lobes, and whether the walk arrived through a medium.
std::string vertex_class(const reference::WalkVertex& vertex);

/// A kind of light, LIGHT_*.
std::string light_class(uint32_t kind);

}  // namespace regulus::check
