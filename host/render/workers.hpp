// Threads that wait for loops to share.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace regulus::render {

class Workers {
 public:
  /// One thread per processor takes part in each loop, the caller's among them.
  Workers();
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  /// Calls body(begin, end) for consecutive ranges of at most `grain` items that cover [0, count), and
  /// returns when all are done. `body` must not throw.
  void run(uint32_t count, uint32_t grain, const std::function<void(uint32_t begin, uint32_t end)>& body);

 private:
  void wait_for_loops();
  void take_part();

  std::mutex mutex_;
  std::condition_variable begins_, ends_;
  const std::function<void(uint32_t, uint32_t)>* body_ = nullptr;
  uint32_t count_ = 0, grain_ = 1;
  std::atomic<uint64_t> next_ = 0;
  uint64_t loops_ = 0;  ///< begun so far
  uint32_t busy_ = 0;   ///< threads in the loop at hand
  bool is_ending_ = false;
  std::vector<std::jthread> threads_;
};

}  // namespace regulus::render
