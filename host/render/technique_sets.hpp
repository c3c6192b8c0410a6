// Sets of techniques that have a name of their own (docs/architecture.md).
#pragma once

#include <cstdint>

#include "interface/wavefront.h"

namespace regulus::technique_sets {

inline constexpr uint32_t PT = interface::TECHNIQUE_HIT | interface::TECHNIQUE_NEE;
inline constexpr uint32_t LT = interface::TECHNIQUE_SPLAT;
inline constexpr uint32_t BPT = PT | interface::TECHNIQUE_SPLAT | interface::TECHNIQUE_CONNECT;
inline constexpr uint32_t BPM = PT | interface::TECHNIQUE_MERGE;
inline constexpr uint32_t VCM = BPT | interface::TECHNIQUE_MERGE;

}  // namespace regulus::technique_sets
