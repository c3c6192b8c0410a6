#include "session/display_server.hpp"

#include <fmt/format.h>

#include <bit>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <limits>
#include <mutex>
#include <new>
#include <system_error>
#include <thread>
#include <utility>
#include <variant>

namespace regulus::session {

namespace tev {

namespace {

static_assert(std::endian::native == std::endian::little, "the protocol is little-endian");

enum Type : uint8_t { UPDATE_IMAGE = 3, CREATE_IMAGE = 4 };

class Message {
 public:
  explicit Message(Type type) {
    add(int32_t{0});  // the length
    add(type);
  }
  template <typename Number>
  void add(Number value) {
    const auto* bytes = reinterpret_cast<const char*>(&value);
    text_.append(bytes, sizeof value);
  }
  /// Without a 0 in it, as names of files are.
  void add_text(const std::string& text) {
    text_ += text;
    text_ += '\0';
  }
  std::string finish() {
    const auto length = static_cast<int32_t>(text_.size());
    std::memcpy(text_.data(), &length, sizeof length);
    return std::move(text_);
  }

 private:
  std::string text_;
};

constexpr const char* CHANNELS[] = {"R", "G", "B"};

}  // namespace

std::string create_image(const std::string& name, uint32_t width, uint32_t height) {
  Message message(CREATE_IMAGE);
  message.add(uint8_t{1});  // show it
  message.add_text(name);
  message.add(static_cast<int32_t>(width));
  message.add(static_cast<int32_t>(height));
  message.add(static_cast<int32_t>(std::size(CHANNELS)));
  for (const char* channel : CHANNELS) message.add_text(channel);
  return message.finish();
}

std::string update_image(const std::string& name, const image::Image& image, uint32_t channel,
                         uint32_t first_row, uint32_t rows, const image::Placement& placement) {
  Message message(UPDATE_IMAGE);
  message.add(uint8_t{0});  // leave the focus where it is
  message.add_text(name);
  message.add_text(CHANNELS[channel]);
  message.add(static_cast<int32_t>(placement.x));
  message.add(static_cast<int32_t>(placement.y + first_row));
  message.add(static_cast<int32_t>(image.width));
  message.add(static_cast<int32_t>(rows));
  const size_t first = size_t{first_row} * image.width, end = first + size_t{rows} * image.width;
  for (size_t pixel = first; pixel < end; ++pixel) message.add(image.rgb[3 * pixel + channel]);
  return message.finish();
}

}  // namespace tev

namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds CONNECT_PATIENCE = 3s, SEND_PATIENCE = 5s, RETRY = 1s,
                                    LEAST_PERIOD = 250ms, FLUSH = 2s;
constexpr uint32_t PIXELS_PER_MESSAGE = 1u << 16;

}  // namespace

struct DisplayServer::State {
  HostAndPort address;
  std::string name;
  image::Placement placement;

  std::mutex mutex;  // of what follows
  std::condition_variable wake;
  std::variant<std::monostate, render::Film, image::Image> pending;
  bool is_busy = false, is_over = false, has_ended = false;
  uint64_t last_paths = 0;
  Clock::time_point last_offer{}, deadline = Clock::time_point::max();
  std::optional<std::string> warning;
  bool has_warned = false;

  TcpClient client;  // the thread's
  bool is_created = false;

  bool is_too_late() {
    const std::lock_guard lock(mutex);
    return Clock::now() >= deadline;
  }

  void warn(const std::string& why) {
    const std::lock_guard lock(mutex);
    if (!std::exchange(has_warned, true))
      warning = fmt::format("display server {}:{}: {}; looking for it while the render goes on", address.host,
                            address.port, why);
  }

  /// Why there is no connection; empty if there is.
  std::string connect() {
    if (client.is_connected()) return "";
    is_created = false;
    return client.connect(address, CONNECT_PATIENCE);
  }

  /// Why the picture could not be sent; empty if it was.
  std::string send(const image::Image& image) {
    const auto too_late = [this] { return is_too_late(); };
    const auto put = [&](const std::string& message) {
      return client.send(message, SEND_PATIENCE, too_late);
    };
    if (!std::exchange(is_created, true))
      if (std::string why = put(tev::create_image(name, placement.film_width, placement.film_height));
          !why.empty())
        return why;
    const uint32_t rows_at_once = std::max(PIXELS_PER_MESSAGE / std::max(image.width, 1u), 1u);
    for (uint32_t row = 0; row < image.height; row += rows_at_once)
      for (uint32_t channel = 0; channel < 3; ++channel) {
        const uint32_t rows = std::min(rows_at_once, image.height - row);
        if (std::string why = put(tev::update_image(name, image, channel, row, rows, placement));
            !why.empty())
          return why;
      }
    return "";
  }

  void run() {
    std::unique_lock lock(mutex);
    while (true) {
      wake.wait(lock, [&] { return is_over || pending.index() != 0; });
      if (pending.index() == 0) break;
      auto taken = std::exchange(pending, std::monostate{});
      is_busy = true;
      lock.unlock();
      std::string why = connect();
      if (why.empty())
        why = send(taken.index() == 1 ? resolve(std::get<render::Film>(taken))
                                      : std::get<image::Image>(std::move(taken)));
      if (!why.empty() && !is_too_late()) warn(why);
      lock.lock();
      is_busy = false;
      if (!why.empty() && !is_over) wake.wait_for(lock, RETRY, [&] { return is_over; });
    }
    client.close();
    has_ended = true;
    wake.notify_all();
  }
};

DisplayServer::DisplayServer(const HostAndPort& address, const std::string& name,
                             const image::Placement& placement)
    : state_(std::make_shared<State>()) {
  state_->address = address;
  state_->name = name;
  state_->placement = placement;
  try {
    std::thread([state = state_] {
      try {
        state->run();
      } catch (const std::bad_alloc&) {  // the render needs the memory
        state->warn("not enough memory");
        const std::lock_guard lock(state->mutex);
        state->has_ended = true;
        state->wake.notify_all();
      }
    }).detach();
  } catch (const std::system_error&) {
    state_->warn("no thread can be had for it");
    state_->has_ended = true;
  }
}

void DisplayServer::close() {
  std::unique_lock lock(state_->mutex);
  state_->is_over = true;
  state_->deadline = Clock::now() + FLUSH;
  state_->wake.notify_all();
  state_->wake.wait_for(lock, FLUSH, [&] { return state_->has_ended; });
}

void DisplayServer::offer(const render::Film& film) {
  const std::lock_guard lock(state_->mutex);
  State& state = *state_;
  if (film.paths <= state.last_paths || state.is_busy || state.has_ended || state.pending.index() != 0)
    return;
  if (Clock::now() - state.last_offer < LEAST_PERIOD) return;
  state.pending = film;
  state.last_paths = film.paths;
  state.last_offer = Clock::now();
  state.wake.notify_all();
}

void DisplayServer::finish(const image::Image& image) {
  const std::lock_guard lock(state_->mutex);
  state_->pending = image;
  state_->wake.notify_all();
}

std::optional<std::string> DisplayServer::take_warning() {
  const std::lock_guard lock(state_->mutex);
  return std::exchange(state_->warning, std::nullopt);
}

}  // namespace regulus::session
