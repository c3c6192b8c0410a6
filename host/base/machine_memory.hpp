// How much memory this process may count on.
#pragma once

#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <fstream>

namespace regulus {

/// Bytes of the machine's memory, or of what its control group allows if that is less.
inline uint64_t machine_memory_bytes() {
  uint64_t bytes =
      static_cast<uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<uint64_t>(sysconf(_SC_PAGE_SIZE));
  for (const char* limit : {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"}) {
    uint64_t allowed = 0;
    if (std::ifstream(limit) >> allowed) bytes = std::min(bytes, allowed);  // "max" is no number
  }
  return bytes;
}

/// What a scene may take unless --memory says otherwise: three quarters of it.
inline uint64_t default_memory_bytes() {
  return machine_memory_bytes() / 4 * 3;
}

}  // namespace regulus
