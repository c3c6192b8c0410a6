// The last message of each kind, for those who watch.
#pragma once

#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace regulus::view {

/// What there is to be told. Of each kind only the last message counts: who is slow misses those between.
enum class Topic { Status, FirstSide, SecondSide };
inline constexpr size_t TOPIC_COUNT = 3;

class Board {
 public:
  /// What a reader has seen.
  using Seen = std::array<uint64_t, TOPIC_COUNT>;

  void post(Topic topic, std::string message);
  /// Waits until something was posted that has not been seen, or until the time is up.
  std::vector<std::shared_ptr<const std::string>> wait(Seen& seen, std::chrono::milliseconds time);

 private:
  std::mutex mutex_;
  std::condition_variable posted_;
  std::array<std::shared_ptr<const std::string>, TOPIC_COUNT> messages_;
  Seen numbers_{};
};

}  // namespace regulus::view
