// Writing fails with one line and leaves no trace; it succeeds in one step.
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include "image/atomic_file.hpp"
#include "image_files.hpp"

namespace regulus::test {
namespace {

using image::write_file_atomically;

TEST(AtomicFile, ReplacesAFileAndFollowsALink) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "file", "first");
  write_file_atomically(folder / "file", "second");
  EXPECT_EQ(read_bytes(folder / "file"), "second");
  std::filesystem::create_symlink("file", folder / "link");
  write_file_atomically(folder / "link", "third");
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  EXPECT_EQ(read_bytes(folder / "file"), "third");
  EXPECT_EQ(folder.file_count(), 2u);
}

TEST(AtomicFile, HonoursTheUmask) {
  const TemporaryFolder folder;
  const mode_t before = ::umask(027);
  write_file_atomically(folder / "file", "x");
  ::umask(before);
  struct stat status {};
  ASSERT_EQ(::stat((folder / "file").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0640u);
}

TEST(AtomicFile, UnwritablePlacesAreNamed) {
  const TemporaryFolder folder;
  write_bytes(folder / "file", "old");
  // Below a regular file nothing can be created, not even by root.
  expect_error([&] { write_file_atomically(folder / "file/x.exr", "new"); }, ExitStatus::Failed,
               "file/x.exr");
  expect_error([&] { write_file_atomically(folder / "none/x.exr", "new"); }, ExitStatus::Failed,
               "No such file or directory");
  expect_error([&] { write_file_atomically(folder.path(), "new"); }, ExitStatus::Failed, "Is a directory");
  expect_error([&] { write_file_atomically("", "new"); }, ExitStatus::Failed, "cannot be written");
  expect_error([&] { write_file_atomically(folder / std::string(300, 'n'), "new"); }, ExitStatus::Failed,
               "File name too long");
  EXPECT_EQ(read_bytes(folder / "file"), "old");
  EXPECT_EQ(folder.file_count(), 1u);
}

TEST(AtomicFile, DevicesAreWrittenToAndNeverReplaced) {
  write_file_atomically("/dev/null", "gone");
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
  if (std::filesystem::is_character_file("/dev/full"))
    expect_error([] { write_file_atomically("/dev/full", "x"); }, ExitStatus::Failed,
                 "No space left on device");
}

/// Limits the size of files this process can write, as a full disk does, while it lives.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) : handler_(::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    rlimit limit = before_;
    limit.rlim_cur = bytes;
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;
  ~FullDisk() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    ::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int);
};

TEST(AtomicFile, AWriteThatStopsHalfwayLeavesTheOldFile) {
  constexpr size_t LIMIT = 2048;  // the PNG below has 3 * 64 * 64 bytes of noise, the EXR more
  const TemporaryFolder folder;
  const image::Image image =
      make_image(64, 64, [](size_t i) { return static_cast<float>(i * i % 1013) / 1013; });
  image::write_exr(folder / "a.exr", image);
  const std::string before = read_bytes(folder / "a.exr");
  ASSERT_GT(before.size(), LIMIT);
  {
    const FullDisk disk(LIMIT);
    expect_error([&] { image::write_exr(folder / "a.exr", image); }, ExitStatus::Failed, "a.exr");
    expect_error([&] { image::write_png(folder / "b.png", image); }, ExitStatus::Failed, "b.png");
  }
  EXPECT_EQ(read_bytes(folder / "a.exr"), before);
  EXPECT_EQ(folder.file_count(), 1u) << "a temporary file was left";
}

}  // namespace
}  // namespace regulus::test
