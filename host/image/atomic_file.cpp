// POSIX implementation: open, write, fsync and rename, because iostreams report neither a full disk nor
// its reason reliably.
#include "image/atomic_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "base/error.hpp"

namespace regulus::image {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, const int error) {
  throw Error(ExitStatus::Failed, fmt::format("{}: cannot be written ({}); choose another place or make room",
                                              path.string(), std::generic_category().message(error)));
}

/// An open descriptor; `close` reports what the destructor must swallow.
class Descriptor {
 public:
  explicit Descriptor(const int fd) : fd_(fd) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }

  bool is_open() const { return fd_ >= 0; }

  bool write(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t written = ::write(fd_, bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) return false;
      bytes.remove_prefix(static_cast<size_t>(written));
    }
    return true;
  }

  bool sync() { return ::fsync(fd_) == 0; }

  bool close() {
    const int fd = fd_;
    fd_ = -1;
    return ::close(fd) == 0;
  }

 private:
  int fd_;
};

/// Removes the temporary unless the rename succeeded.
class TemporaryName {
 public:
  explicit TemporaryName(fs::path path) : path_(std::move(path)) {}
  TemporaryName(const TemporaryName&) = delete;
  TemporaryName& operator=(const TemporaryName&) = delete;
  ~TemporaryName() {
    if (!path_.empty()) ::unlink(path_.c_str());
  }

  const fs::path& path() const { return path_; }
  void release() { path_.clear(); }

 private:
  fs::path path_;
};

bool is_device_or_pipe(const fs::path& path) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

void write_directly(const fs::path& path, const std::string_view bytes) {
  Descriptor file(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
  if (!file.is_open() || !file.write(bytes) || !file.close()) fail(path, errno);
}

/// The file that a chain of links ends at, so that the rename replaces the file and not the link.
fs::path link_target(const fs::path& path) {
  std::error_code error;
  if (!fs::is_symlink(path, error)) return path;
  const fs::path target = fs::weakly_canonical(path, error);
  return error ? path : target;
}

}  // namespace

void write_file_atomically(const fs::path& path, const std::string_view bytes) {
  if (is_device_or_pipe(path)) return write_directly(path, bytes);
  const fs::path target = link_target(path);
  std::error_code ignored;
  if (fs::is_directory(target, ignored)) fail(path, EISDIR);  // before the work, not at the rename

  // The process id keeps two processes apart, O_EXCL a leftover of a killed one.
  fs::path temporary_path = target;
  int fd = -1;
  for (int attempt = 0; attempt < 100 && fd < 0; ++attempt) {
    temporary_path.replace_filename(
        fmt::format(".{}.{}-{}.tmp", target.filename().string().substr(0, 200), ::getpid(), attempt));
    fd = ::open(temporary_path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (fd < 0 && errno != EEXIST) fail(path, errno);
  }
  if (fd < 0) fail(path, EEXIST);
  TemporaryName temporary(temporary_path);
  Descriptor file(fd);
  if (!file.write(bytes) || !file.sync() || !file.close()) fail(path, errno);
  if (::rename(temporary.path().c_str(), target.c_str()) != 0) fail(path, errno);
  temporary.release();
}

}  // namespace regulus::image
