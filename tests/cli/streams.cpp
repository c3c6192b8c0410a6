// regulus with standard streams that are closed, full or gone, and with limits on the size of files. Rendered
// by the reference: nothing here needs a Vulkan device.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <thread>

#include "cli/process.hpp"
#include "cli/small_scenes.hpp"
#include "image/image.hpp"

namespace regulus::test {
namespace {

namespace fs = std::filesystem;

class Streams : public testing::Test {
 protected:
  void SetUp() override { write_lit_square(gltf()); }
  std::string gltf() const { return (folder_ / "scene.gltf").string(); }
  std::string exr() const { return (folder_ / "out.exr").string(); }

  Arguments render(const std::string& samples) const {
    return {"render", gltf(),  "-o",        exr(),       "--size",   "8x8",
            "-s",     samples, "--backend", "reference", "--verbose"};
  }
  // The quad fills the frame's middle: I / d^2 * albedo / pi = 0.159 right under the light.
  void expect_picture() const {
    ASSERT_TRUE(fs::exists(exr()));
    EXPECT_NEAR(image::read_exr(exr()).rgb[3 * (4 * 8 + 4)], 0.5 / M_PI, 0.03);
  }

  TemporaryFolder folder_;
};

/// Makes a stream of the new process a pipe that nobody reads.
Preparation onto_broken_pipe(std::initializer_list<int> streams) {
  return [streams = std::vector<int>(streams)] {
    int ends[2];
    if (pipe(ends) != 0) _exit(126);
    for (const int stream : streams) dup2(ends[1], stream);
    close(ends[0]);
    close(ends[1]);
  };
}

Preparation onto_full_device(int stream) {
  return [stream] { dup2(open("/dev/full", O_WRONLY), stream); };
}

Preparation without(std::initializer_list<int> streams) {
  return [streams = std::vector<int>(streams)] {
    for (const int stream : streams) close(stream);
  };
}

TEST_F(Streams, FullStdoutIsAnError) {
  for (const Arguments& arguments : {Arguments{"inspect", gltf()}, Arguments{"--help"},
                                     Arguments{"render", "--help"}, Arguments{"--version"}})
    expect_error(run(arguments, {}, onto_full_device(STDOUT_FILENO)), 1, {"stdout", "No space left"});
  expect_error(run({"inspect", gltf()}, {}, without({STDOUT_FILENO})), 1, {"stdout"});
}

// As with `| head -n 1`: who goes away has read enough.
TEST_F(Streams, ReadersThatGoAwayAreNoError) {
  for (const Arguments& arguments : {Arguments{"inspect", gltf()}, Arguments{"render", "--help"}}) {
    const Finished finished = run(arguments, {}, onto_broken_pipe({STDOUT_FILENO}));
    EXPECT_EQ(finished.status, 0) << finished.err;
    EXPECT_EQ(finished.err, "");
  }
  const Finished finished = run(render("4"), {}, onto_broken_pipe({STDOUT_FILENO, STDERR_FILENO}));
  EXPECT_EQ(finished.signal, 0);
  EXPECT_EQ(finished.status, 0);
  expect_picture();
}

TEST_F(Streams, ClosedOrFullStreamsDoNotTouchThePicture) {
  for (const Preparation& preparation :
       {without({STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}), without({STDERR_FILENO}),
        onto_full_device(STDERR_FILENO), onto_full_device(STDOUT_FILENO)}) {
    const Finished finished = run(render("4"), {}, preparation);
    EXPECT_EQ(finished.status, 0) << finished.err;
    expect_picture();
    fs::remove(exr());
  }
}

TEST_F(Streams, AFileSizeLimitIsAnError) {
  const Finished finished = run(render("4"), {{"TMPDIR", folder_.path().string()}}, [] {
    const rlimit limit{512, 512};
    setrlimit(RLIMIT_FSIZE, &limit);
  });
  EXPECT_EQ(finished.signal, 0);
  EXPECT_EQ(finished.status, 1);
  EXPECT_NE(finished.err.find("out.exr"), std::string::npos) << finished.err;
  EXPECT_NE(finished.err.find("File too large"), std::string::npos) << finished.err;
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), {}), 1)
      << "something lies beside the scene";
}

// As when the window is closed: SIGHUP, and a stderr that gives EIO.
TEST_F(Streams, ATerminalThatGoesAwayLeavesThePicture) {
  int terminal = -1;
  Arguments words = render("16000000");
  words.insert(words.begin(), REGULUS_BINARY);
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const pid_t pid = forkpty(&terminal, nullptr, nullptr, nullptr);
  ASSERT_GE(pid, 0);
  if (pid == 0) {
    signal(SIGHUP, SIG_DFL);
    execv(argv[0], argv.data());
    _exit(127);
  }
  std::string said;
  char buffer[4096];
  // The progress line, drawn from the first samples on.
  while (said.find("samples/s") == std::string::npos) {
    const ssize_t count = read(terminal, buffer, sizeof buffer);
    ASSERT_GT(count, 0) << said;
    said.append(buffer, static_cast<size_t>(count));
  }
  close(terminal);
  int status = 0;
  ASSERT_EQ(waitpid(pid, &status, 0), pid);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  expect_picture();
}

TEST_F(Streams, NohupIsRespected) {
  Process process(render("16000000"), {}, [] { signal(SIGHUP, SIG_IGN); });
  ASSERT_TRUE(process.wait_for_handler(SIGTERM));
  EXPECT_FALSE(process.catches(SIGHUP));
  process.send(SIGHUP);
  process.send(SIGTERM);
  EXPECT_EQ(process.wait().status, 130);
  expect_picture();
}

}  // namespace
}  // namespace regulus::test
