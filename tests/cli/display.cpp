// render --display-server: what arrives at a viewer, decoded as tev decodes it (src/Ipc.cpp), and viewers
// that are absent, stuck or go away.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstring>
#include <fstream>
#include <map>
#include <mutex>
#include <thread>

#include "cli/process.hpp"
#include "cli/small_scenes.hpp"
#include "image/image.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

/// A picture as the viewer has it.
struct Shown {
  int32_t width = 0, height = 0;
  std::map<std::string, std::vector<float>> channels;
  size_t updates = 0;
};

/// A message, taken apart from its start. Reading beyond its end fails the test.
class Payload {
 public:
  explicit Payload(std::string bytes) : bytes_(std::move(bytes)) {}
  template <typename Number>
  Number take() {
    Number value{};
    EXPECT_LE(at_ + sizeof value, bytes_.size());
    if (at_ + sizeof value <= bytes_.size()) std::memcpy(&value, bytes_.data() + at_, sizeof value);
    at_ += sizeof value;
    return value;
  }
  std::string take_text() {
    const size_t end = bytes_.find('\0', at_);
    EXPECT_NE(end, std::string::npos);
    std::string text = bytes_.substr(at_, end - at_);
    at_ = end + 1;
    return text;
  }
  bool is_at_end() const { return at_ == bytes_.size(); }

 private:
  std::string bytes_;
  size_t at_ = 0;
};

/// Listens on a port of its own.
class Viewer {
 public:
  enum class Manner { Reads, ReadsNothing, LeavesOnce };

  explicit Viewer(Manner manner) : manner_(manner) {
    listener_ = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(listen(listener_, 4), 0);
    socklen_t size = sizeof address;
    getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { serve(); });
  }
  ~Viewer() { stop(); }

  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }
  /// Ends; what was shown stays.
  std::map<std::string, Shown> stop() {
    is_over_ = true;
    shutdown(listener_, SHUT_RDWR);
    if (thread_.joinable()) thread_.join();
    if (listener_ >= 0) close(listener_);
    listener_ = -1;
    return shown_;
  }
  int connections() const { return connections_; }

 private:
  void serve() {
    while (!is_over_) {
      const int peer = accept(listener_, nullptr, nullptr);
      if (peer < 0) return;
      ++connections_;
      if (manner_ == Manner::ReadsNothing) {
        while (!is_over_) std::this_thread::sleep_for(std::chrono::milliseconds(10));
      } else {
        while (take_message(peer) && !(manner_ == Manner::LeavesOnce && connections_ == 1)) {
        }
      }
      close(peer);
    }
  }

  static bool read_all(int peer, char* to, size_t count) {
    while (count > 0) {
      const ssize_t got = recv(peer, to, count, 0);
      if (got <= 0) return false;
      to += got;
      count -= static_cast<size_t>(got);
    }
    return true;
  }

  bool take_message(int peer) {
    int32_t length = 0;
    if (!read_all(peer, reinterpret_cast<char*>(&length), sizeof length)) return false;
    EXPECT_GT(length, 5);
    EXPECT_LT(length, 1 << 24);
    std::string bytes(static_cast<size_t>(length) - sizeof length, '\0');
    if (!read_all(peer, bytes.data(), bytes.size())) return false;
    Payload payload(std::move(bytes));
    const auto type = payload.take<uint8_t>();
    payload.take<uint8_t>();  // whether to grab the focus
    Shown& shown = shown_[payload.take_text()];
    if (type == 4)
      create(shown, payload);
    else if (type == 3)
      update(shown, payload);
    else
      ADD_FAILURE() << "message of type " << int{type};
    EXPECT_TRUE(payload.is_at_end());
    return true;
  }
  static void create(Shown& shown, Payload& payload) {
    shown.width = payload.take<int32_t>();
    shown.height = payload.take<int32_t>();
    const auto channels = payload.take<int32_t>();
    for (int32_t c = 0; c < channels; ++c)
      shown.channels[payload.take_text()].assign(static_cast<size_t>(shown.width * shown.height), 0);
  }
  static void update(Shown& shown, Payload& payload) {
    std::vector<float>& channel = shown.channels.at(payload.take_text());
    const auto x = payload.take<int32_t>(), y = payload.take<int32_t>(), width = payload.take<int32_t>(),
               height = payload.take<int32_t>();
    ASSERT_TRUE(x >= 0 && y >= 0 && x + width <= shown.width && y + height <= shown.height);
    for (int32_t v = y; v < y + height; ++v)
      for (int32_t u = x; u < x + width; ++u)
        channel[static_cast<size_t>(v * shown.width + u)] = payload.take<float>();
    ++shown.updates;
  }

  Manner manner_;
  int listener_ = -1;
  uint16_t port_ = 0;
  std::atomic<bool> is_over_ = false;
  std::atomic<int> connections_ = 0;
  std::map<std::string, Shown> shown_;  // the thread's until it has ended
  std::thread thread_;
};

class Display : public testing::Test {
 protected:
  void SetUp() override {
    REGULUS_SKIP_WITHOUT_DEVICE();
    write_lit_floor(file("scene.gltf"));
  }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }

  Finished render(const std::string& address, const Arguments& more) const {
    Arguments arguments = {"render", file("scene.gltf"), "-o", file("a.exr"), "--display-server", address};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }
  // The picture in the file is the part at (x, y) of what is shown; the rest is black.
  void expect_shown(const Shown& shown, int32_t x, int32_t y) const {
    const image::Image image = image::read_exr(file("a.exr"));
    const char* names[] = {"R", "G", "B"};
    size_t different = 0;
    for (int32_t v = 0; v < shown.height; ++v)
      for (int32_t u = 0; u < shown.width; ++u)
        for (size_t c = 0; c < 3; ++c) {
          const auto column = static_cast<uint32_t>(u - x), row = static_cast<uint32_t>(v - y);
          const bool is_inside = u >= x && v >= y && column < image.width && row < image.height;
          const float expected = is_inside ? image.rgb[3 * (size_t{row} * image.width + column) + c] : 0;
          if (shown.channels.at(names[c])[static_cast<size_t>(v * shown.width + u)] != expected) ++different;
        }
    EXPECT_EQ(different, 0u);
  }

  TemporaryFolder folder_;
};

TEST_F(Display, TheLastPictureIsTheFile) {
  Viewer viewer(Viewer::Manner::Reads);
  const Finished finished = render(viewer.address(), {"--size", "300x250", "--time", "2"});
  ASSERT_EQ(finished.status, 0) << finished.err;
  EXPECT_EQ(finished.err, "");
  const auto shown = viewer.stop();
  ASSERT_EQ(shown.size(), 1u);
  const Shown& picture = shown.at(file("a.exr"));
  EXPECT_EQ(picture.width, 300);
  EXPECT_EQ(picture.height, 250);
  EXPECT_EQ(viewer.connections(), 1);
  // 300 x 250 takes two messages a channel: there were states before the last.
  EXPECT_GE(picture.updates, 12u);
  expect_shown(picture, 0, 0);
}

TEST_F(Display, ACropLiesWhereItBelongs) {
  Viewer viewer(Viewer::Manner::Reads);
  ASSERT_EQ(render(viewer.address(), {"--size", "32x24", "-s", "1", "--crop", "5,6,20,17"}).status, 0);
  const Shown picture = viewer.stop().at(file("a.exr"));
  EXPECT_EQ(picture.width, 32);
  EXPECT_EQ(picture.height, 24);
  expect_shown(picture, 5, 6);
}

TEST_F(Display, AReferenceIsShownWhenItIsDone) {
  Viewer viewer(Viewer::Manner::Reads);
  ASSERT_EQ(render(viewer.address(), {"--size", "8x8", "-s", "1", "--backend", "reference"}).status, 0);
  expect_shown(viewer.stop().at(file("a.exr")), 0, 0);
}

// One that leaves after its first message gets the whole picture when it is back, a second later.
TEST_F(Display, AViewerMayComeBack) {
  Viewer viewer(Viewer::Manner::LeavesOnce);
  const Finished finished = render(viewer.address(), {"--size", "300x250", "--time", "3"});
  ASSERT_EQ(finished.status, 0) << finished.err;
  const auto shown = viewer.stop();
  EXPECT_GE(viewer.connections(), 2);
  EXPECT_EQ(count_lines(finished.err), 1u) << finished.err;
  EXPECT_NE(finished.err.find("warning: display server " + viewer.address()), std::string::npos)
      << finished.err;
  expect_shown(shown.at(file("a.exr")), 0, 0);
}

// The same picture as without, one warning, and no more time than the two seconds at the end.
TEST_F(Display, NoViewerAndAStuckOneChangeNothing) {
  ASSERT_EQ(run({"render", file("scene.gltf"), "-o", file("plain.exr"), "--size", "1000x1000", "-s", "1",
                 "--max-depth", "1", "-q"})
                .status,
            0);
  const image::Image plain = image::read_exr(file("plain.exr"));
  const auto seconds = [](const std::function<void()>& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  // Larger than what sockets hold by themselves: 12 MB.
  const Arguments more = {"--size", "1000x1000", "-s", "1", "--max-depth", "1"};
  Viewer stuck(Viewer::Manner::ReadsNothing);
  std::string absent;
  {
    Viewer gone(Viewer::Manner::Reads);
    absent = gone.address();
  }
  for (const std::string& address : {stuck.address(), absent}) {
    Finished finished;
    const double took = seconds([&] { finished = render(address, more); });
    std::printf("%.2f s\n", took);
    EXPECT_EQ(finished.status, 0) << finished.err;
    EXPECT_TRUE(image::read_exr(file("a.exr")).rgb == plain.rgb);
    EXPECT_LT(took, 30);
    if (address != absent) continue;
    EXPECT_EQ(count_lines(finished.err), 1u) << finished.err;
    EXPECT_NE(finished.err.find(address + ": Connection refused"), std::string::npos) << finished.err;
  }
}

TEST_F(Display, AddressesAreChecked) {
  for (const char* address : {"localhost", ":14158", "localhost:", "localhost:0", "localhost:65536",
                              "localhost:1x", "a:b:1", "[]:1"})
    expect_error(render(address, {}), 2, {"--display-server", address, "localhost:14158"});
}

}  // namespace
}  // namespace regulus::test
