// Loops over threads.
#pragma once

#include <cstdint>
#include <functional>

namespace regulus::reference {

/// Calls body(begin, end) for consecutive ranges of at most `grain` items that cover [0, count), on `threads`
/// threads (0: one per processor). An exception of the body is rethrown once all threads have stopped.
void parallel_ranges(uint32_t count, uint32_t grain, uint32_t threads,
                     const std::function<void(uint32_t begin, uint32_t end)>& body);

}  // namespace regulus::reference
