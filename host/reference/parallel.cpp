#include "reference/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace regulus::reference {

void parallel_ranges(uint32_t count, uint32_t grain, uint32_t threads,
                     const std::function<void(uint32_t begin, uint32_t end)>& body) {
  std::atomic<uint64_t> next{0};
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto work = [&] {
    try {
      for (uint64_t begin = next.fetch_add(grain); begin < count; begin = next.fetch_add(grain))
        body(static_cast<uint32_t>(begin), static_cast<uint32_t>(std::min<uint64_t>(begin + grain, count)));
    } catch (...) {
      const std::lock_guard<std::mutex> lock(failure_mutex);
      failure = std::current_exception();
      next = count;
    }
  };
  const uint32_t wanted = threads != 0 ? threads : std::max(1u, std::thread::hardware_concurrency());
  std::vector<std::thread> others;
  for (uint32_t i = 1; i < std::min(wanted, (count + grain - 1) / grain); ++i) others.emplace_back(work);
  work();
  for (std::thread& thread : others) thread.join();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace regulus::reference
