// What a SPIR-V module takes of a device.
#pragma once

#include <cstdint>
#include <span>

namespace regulus::test {

struct ModuleNeeds {
  bool int64 = false;           ///< capability Int64 or Int64Atomics
  uint64_t shared_bytes = 0;    ///< of its variables of storage class Workgroup
  uint64_t workgroup_size = 0;  ///< invocations
};

/// Lengths of arrays that are specialization constants count with their defaults.
ModuleNeeds needs_of(std::span<const uint32_t> module);

}  // namespace regulus::test
