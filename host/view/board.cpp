#include "view/board.hpp"

#include <utility>

namespace regulus::view {

void Board::post(Topic topic, std::string message) {
  auto shared = std::make_shared<const std::string>(std::move(message));
  const std::lock_guard lock(mutex_);
  const auto index = static_cast<size_t>(topic);
  messages_[index] = std::move(shared);
  ++numbers_[index];
  posted_.notify_all();
}

std::vector<std::shared_ptr<const std::string>> Board::wait(Seen& seen, std::chrono::milliseconds time) {
  std::unique_lock lock(mutex_);
  posted_.wait_for(lock, time, [&] { return seen != numbers_; });
  std::vector<std::shared_ptr<const std::string>> unseen;
  for (size_t topic = 0; topic < TOPIC_COUNT; ++topic)
    if (seen[topic] != numbers_[topic]) unseen.push_back(messages_[topic]);
  seen = numbers_;
  return unseen;
}

}  // namespace regulus::view
