// Checkpoints of a render from the outside: --checkpoint, --resume, kill -9.
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <functional>
#include <random>
#include <thread>

#include "cli/render_parts.hpp"

namespace regulus::test {
namespace {

namespace fs = std::filesystem;

// Everything that decides about the samples is named when it is another.
TEST_F(RenderParts, CheckpointsOfOtherRendersAreRefusedByName) {
  render("x.exr", {"-s", "2", "--checkpoint", file("state.exr")});
  const auto resume = [&](const Arguments& more, const std::string& mention) {
    Arguments arguments = command("y.exr", {"-s", "4", "--checkpoint", file("state.exr"), "--resume"});
    arguments.insert(arguments.end(), more.begin(), more.end());
    expect_error(run(arguments), 3, {"state.exr", mention});
  };
  resume({"-i", "bpt"}, "techniques");
  resume({"--seed", "9"}, "seed");
  resume({"--max-depth", "3"}, "max_depth");
  resume({"--tau", "7"}, "tau");
  resume({"--crop", "0,0,8,8"}, "crop");
  resume({"--sampler", "hash"}, "sampler");
  resume({"--filter", "box"}, "filter");
  resume({"--aov", "variance"}, "aov");
  resume({"--clamp", "3"}, "clamp");
  Arguments size = command("y.exr", {"-s", "4", "--checkpoint", file("state.exr"), "--resume"});
  std::ranges::replace(size, std::string("24x16"), std::string("24x17"));
  expect_error(run(size), 3, {"state.exr", "crop is [0,0,24,16] and [0,0,24,17]"});
  GltfScene other;
  other.add({quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2})}, lambert({0.25, 0.5, 0.5}));
  other.add({quad({-0.5, 1.5, -0.5}, {1, 0, 0}, {0, 0, 1})}, emitter({10, 10, 10}));
  other.set_perspective(look_at({0, 1, 0}, {0, 0, 0.001}), 1.0);
  other.write(file("scene.gltf"));
  resume({}, "scene_hash");
  EXPECT_FALSE(fs::exists(file("y.exr")));
}

// The folder of the checkpoint goes away, or there never is room: the render warns, goes on, and is written.
TEST_F(RenderParts, ACheckpointThatCannotBeWrittenIsAWarning) {
  Arguments arguments = command("x.exr", {"-s", "2", "--checkpoint", "/dev/full", "--resume"});
  std::erase(arguments, "--quiet");
  const Finished finished = run(arguments);
  EXPECT_EQ(finished.status, 0) << finished.err;
  EXPECT_NE(finished.err.find("warning: checkpoint /dev/full"), std::string::npos) << finished.err;
  render("plain.exr", {"-s", "2"});
  EXPECT_TRUE(contents("x.exr").channels == contents("plain.exr").channels);
}

TEST_F(RenderParts, ACheckpointIsTriedAgain) {
  fs::create_directory(file("states"));
  Arguments arguments = command(
      "x.exr", {"-s", "16000000", "--checkpoint", file("states/state.exr"), "--checkpoint-seconds", "0"});
  std::erase(arguments, "--quiet");
  Process process(arguments);
  ASSERT_TRUE(process.wait_for_handler(SIGTERM)) << process.wait().err;
  // States of the film are a quarter of a second apart or more: it need not render all that time.
  const auto pause_while = [&](const std::function<void()>& action) {
    process.send(SIGSTOP);
    action();
    std::this_thread::sleep_for(std::chrono::milliseconds(600));
    process.send(SIGCONT);
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
  };
  pause_while([&] { fs::rename(file("states"), file("gone")); });
  pause_while([&] { fs::rename(file("gone"), file("states")); });
  for (int i = 0; i < 600 && !fs::exists(file("states/state.exr")); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_TRUE(fs::exists(file("states/state.exr")));
  process.send(SIGTERM);
  const Finished finished = process.wait();
  EXPECT_EQ(finished.status, 130) << finished.err;
  EXPECT_NE(finished.err.find("tries again"), std::string::npos) << finished.err;
  EXPECT_TRUE(fs::exists(file("x.exr")));
}

/// How often each integrator is killed: REGULUS_TEST_KILLS, or twice.
int kill_count() {
  const char* count = std::getenv("REGULUS_TEST_KILLS");
  return count == nullptr ? 2 : std::atoi(count);
}

// Killed without warning, then resumed: what comes out is what an undisturbed render gives, bit by bit. Every
// second kill hits the checkpoint while it is written, the others fall into the 300 ms after it was.
class KilledRender : public RenderParts {
 protected:
  bool has_temporary() const {
    return std::ranges::any_of(fs::directory_iterator(folder_.path()), [](const fs::directory_entry& entry) {
      return entry.path().extension() == ".tmp";
    });
  }

  static void wait_until(const std::function<bool()>& is_reached, std::chrono::seconds at_most) {
    const auto limit = std::chrono::steady_clock::now() + at_most;
    while (!is_reached() && std::chrono::steady_clock::now() < limit) {
    }
  }

  /// Renders on from the checkpoint and is killed; true if that was while the checkpoint was written.
  bool render_and_kill(const Arguments& arguments, const std::string& state, bool while_writing) {
    const auto written = [&] {
      std::error_code error;
      const fs::file_time_type time = fs::last_write_time(state, error);
      return error ? fs::file_time_type::min() : time;
    };
    const auto before = written();
    Process process(arguments);
    EXPECT_TRUE(process.wait_for_handler(SIGINT)) << process.wait().err;
    // States of the film are a quarter of a second apart or more: it need not render all that time.
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    process.send(SIGSTOP);
    std::this_thread::sleep_for(std::chrono::milliseconds(600));
    process.send(SIGCONT);
    // A checkpoint is a temporary file for less than a millisecond, which can be missed each time; and every
    // second of waiting makes samples that are rendered twice more below.
    if (while_writing)
      wait_until([&] { return has_temporary(); }, std::chrono::seconds(4));
    else
      wait_until([&] { return written() != before; }, std::chrono::seconds(60));
    if (!while_writing) std::this_thread::sleep_for(std::chrono::milliseconds(random_() % 300));
    process.send(SIGKILL);
    EXPECT_EQ(process.wait().signal, SIGKILL);
    return has_temporary();
  }

  void kill_and_compare(const std::string& integrator) {
    const std::string state = integrator + ".state.exr";
    Arguments own = {"-i", integrator, "--checkpoint", file(state), "--resume", "--checkpoint-seconds", "0"};
    Arguments endless = command("out.exr", own);
    endless.insert(endless.end(), {"-s", "16000000"});
    int while_writing = 0;
    for (int i = 0; i < kill_count(); ++i)
      while_writing += render_and_kill(endless, file(state), i % 2 == 1) ? 1 : 0;
    EXPECT_FALSE(fs::exists(file("out.exr")));
    const uint64_t paths = std::stoull(contents(state).attributes.at("regulus:paths"));
    const std::string samples = std::to_string(paths / (24 * 16) + 3);
    std::printf("%s: killed %d times, %d of them while the checkpoint was written; it holds %llu paths\n",
                integrator.c_str(), kill_count(), while_writing, static_cast<unsigned long long>(paths));
    own.insert(own.end(), {"-s", samples});
    render(integrator + ".exr", own);
    render(integrator + ".whole.exr", {"-i", integrator, "-s", samples});
    EXPECT_TRUE(contents(integrator + ".exr").channels == contents(integrator + ".whole.exr").channels);
    EXPECT_FALSE(has_temporary()) << "the next run removes what a killed one leaves";
    // Once more there is nothing left to do.
    render(integrator + ".again.exr", own);
    EXPECT_TRUE(contents(integrator + ".again.exr").channels == contents(integrator + ".whole.exr").channels);
  }

  std::minstd_rand random_{20};
};

TEST_F(KilledRender, GoesOnBitByBitByPathTracing) {
  kill_and_compare("pt");
}
TEST_F(KilledRender, GoesOnBitByBitByBidirectionalPathTracing) {
  if (!is_slow_device()) kill_and_compare("bpt");
}
TEST_F(KilledRender, GoesOnBitByBitByConnectionAndMerging) {
  if (!is_slow_device()) kill_and_compare("vcm");
}

TEST_F(RenderParts, AMissingCheckpointIsABeginning) {
  render("fresh.exr", {"-s", "2", "--checkpoint", file("fresh-state.exr"), "--resume"});
  EXPECT_TRUE(fs::exists(file("fresh-state.exr")));
}

}  // namespace
}  // namespace regulus::test
