// Writing fails with one line and leaves no trace; it succeeds in one step.
#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include "base/atomic_file.hpp"
#include "image_files.hpp"

namespace regulus::test {
namespace {

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
  expect_error([&] { write_file_atomically(folder / "file/x.exr", "new"); }, ErrorCode::Failed, "file/x.exr");
  expect_error([&] { write_file_atomically(folder / "none/x.exr", "new"); }, ErrorCode::Failed,
               "No such file or directory");
  expect_error([&] { write_file_atomically(folder.path(), "new"); }, ErrorCode::Failed, "Is a directory");
  expect_error([&] { write_file_atomically("", "new"); }, ErrorCode::Failed, "cannot be written");
  expect_error([&] { write_file_atomically(folder / std::string(300, 'n'), "new"); }, ErrorCode::Failed,
               "File name too long");
  EXPECT_EQ(read_bytes(folder / "file"), "old");
  EXPECT_EQ(folder.file_count(), 1u);
}

TEST(AtomicFile, DevicesAreWrittenToAndNeverReplaced) {
  write_file_atomically("/dev/null", "gone");
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
  if (std::filesystem::is_character_file("/dev/full"))
    expect_error([] { write_file_atomically("/dev/full", "x"); }, ErrorCode::Failed,
                 "No space left on device");
}

TEST(AtomicFile, ALinkToNothingYetIsFollowed) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "below");
  std::filesystem::create_symlink("below/new", folder / "link");
  write_file_atomically(folder / "link", "x");
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  EXPECT_EQ(read_bytes(folder / "below/new"), "x");
  std::filesystem::create_symlink("circle", folder / "circle");
  expect_error([&] { write_file_atomically(folder / "circle", "x"); }, ErrorCode::Failed, "circle");
}

TEST(AtomicFile, WhatKilledProcessesLeftIsRemovedAndNothingElse) {
  const TemporaryFolder folder;
  const std::vector<std::string> others = {".file.tmp", ".file.12x-0.tmp", ".other.7-0.tmp", "file.7-0.tmp",
                                           ".file.exr.7-0.tmp"};
  for (const std::string& name : others) write_bytes(folder / name, "someone's");
  write_bytes(folder / ".file.4711-0.tmp", "half a pict");
  write_bytes(folder / ".file.4712-3.tmp", "of a process that still writes it");
  const int held = ::open((folder / ".file.4712-3.tmp").c_str(), O_RDONLY);
  ASSERT_EQ(::flock(held, LOCK_EX), 0);
  require_writable(folder / "file");
  EXPECT_FALSE(std::filesystem::exists(folder / ".file.4711-0.tmp"));
  EXPECT_EQ(folder.file_count(), others.size() + 1);
  ::close(held);
  write_file_atomically(folder / "file", "new");
  EXPECT_FALSE(std::filesystem::exists(folder / ".file.4712-3.tmp"));
  EXPECT_EQ(folder.file_count(), others.size() + 1);
}

TEST(AtomicFile, PlacesAreTriedWithoutATrace) {
  const TemporaryFolder folder;
  write_bytes(folder / "file", "old");
  require_writable(folder / "file");
  require_writable(folder / "new");
  EXPECT_EQ(folder.file_count(), 1u);
  EXPECT_EQ(read_bytes(folder / "file"), "old");
  for (const std::string& place : {std::string("file/x"), std::string("none/x"), std::string(300, 'n')})
    expect_error([&] { require_writable(folder / place); }, ErrorCode::Failed, "cannot be written");
  expect_error([&] { require_writable(folder.path()); }, ErrorCode::Failed, "Is a directory");
  expect_error([&] { require_writable(""); }, ErrorCode::Failed, "cannot be written");
  require_writable("/dev/null");
}

TEST(AtomicFile, WhatCannotBeWrittenFindsARoomElsewhere) {
  const TemporaryFolder folder;
  ::setenv("TMPDIR", folder.path().c_str(), 1);
  const std::filesystem::path place = write_to_temporary_folder("/nowhere/picture.exr", "bytes");
  ::setenv("TMPDIR", (folder / "none").c_str(), 1);
  EXPECT_EQ(write_to_temporary_folder("/nowhere/picture.exr", "bytes"), "");
  ::unsetenv("TMPDIR");
  EXPECT_EQ(place.parent_path(), folder.path());
  EXPECT_TRUE(place.filename().string().ends_with("-picture.exr")) << place;
  EXPECT_EQ(read_bytes(place), "bytes");
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
    expect_error([&] { image::write_exr(folder / "a.exr", image); }, ErrorCode::Failed, "a.exr");
    expect_error([&] { image::write_png(folder / "b.png", image); }, ErrorCode::Failed, "b.png");
  }
  EXPECT_EQ(read_bytes(folder / "a.exr"), before);
  EXPECT_EQ(folder.file_count(), 1u) << "a temporary file was left";
}

}  // namespace
}  // namespace regulus::test
