#include "render/workers.hpp"

#include <algorithm>

namespace regulus::render {

Workers::Workers() {
  for (unsigned i = 1; i < std::thread::hardware_concurrency(); ++i)
    threads_.emplace_back([this] { wait_for_loops(); });
}

Workers::~Workers() {
  {
    const std::lock_guard lock(mutex_);
    is_ending_ = true;
  }
  begins_.notify_all();
}

void Workers::run(uint32_t count, uint32_t grain, const std::function<void(uint32_t, uint32_t)>& body) {
  if (count <= grain) {
    if (count > 0) body(0, count);
    return;
  }
  {
    const std::lock_guard lock(mutex_);
    body_ = &body;
    count_ = count;
    grain_ = grain;
    next_ = 0;
    ++loops_;
  }
  begins_.notify_all();
  take_part();
  std::unique_lock lock(mutex_);
  ends_.wait(lock, [&] { return busy_ == 0; });
  body_ = nullptr;  // a thread that wakes up only now is too late
}

void Workers::wait_for_loops() {
  uint64_t seen = 0;
  std::unique_lock lock(mutex_);
  while (true) {
    begins_.wait(lock, [&] { return is_ending_ || (loops_ != seen && body_ != nullptr); });
    if (is_ending_) return;
    seen = loops_;
    ++busy_;
    lock.unlock();
    take_part();
    lock.lock();
    if (--busy_ == 0) ends_.notify_one();
  }
}

void Workers::take_part() {
  for (uint64_t begin = next_.fetch_add(grain_); begin < count_; begin = next_.fetch_add(grain_))
    (*body_)(static_cast<uint32_t>(begin), static_cast<uint32_t>(std::min<uint64_t>(begin + grain_, count_)));
}

}  // namespace regulus::render
