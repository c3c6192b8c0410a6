// POSIX implementation: open, write, fsync and rename, because iostreams report neither a full disk nor
// its reason reliably. A temporary file is locked for as long as its process needs it (flock), so that one
// without a lock is known to be left over, whatever machine or container it was made on.
#include "base/atomic_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <system_error>
#include <utility>

#include "base/error.hpp"

namespace regulus {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, const int error) {
  throw Error(ErrorCode::Failed, fmt::format("{}: cannot be written ({}); choose another place or make room",
                                             path.string(), std::generic_category().message(error)));
}

/// An open descriptor; `close` reports what the destructor must swallow.
class Descriptor {
 public:
  explicit Descriptor(const int fd) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
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
  Descriptor duplicate() const { return Descriptor(::fcntl(fd_, F_DUPFD_CLOEXEC, 0)); }

  /// False if another process holds the lock. A file system without locks counts as locked by us.
  bool lock() { return ::flock(fd_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK; }
  /// True if it is certain that nobody else holds the lock.
  bool is_free() { return ::flock(fd_, LOCK_EX | LOCK_NB) == 0; }
  bool is_linked() const {
    struct stat status {};
    return ::fstat(fd_, &status) == 0 && status.st_nlink > 0;
  }

  bool close() {
    const int fd = std::exchange(fd_, -1);
    return ::close(fd) == 0;
  }

 private:
  int fd_;
};

/// What all temporary files of `target` begin with.
std::string temporary_prefix(const fs::path& target) {
  return fmt::format(".{}.", target.filename().string().substr(0, 200));
}

constexpr std::string_view TEMPORARY_SUFFIX = ".tmp";

bool is_temporary_of(const std::string& prefix, const std::string& name) {
  if (name.size() <= prefix.size() + TEMPORARY_SUFFIX.size() || !name.starts_with(prefix) ||
      !name.ends_with(TEMPORARY_SUFFIX))
    return false;
  const std::string numbers =
      name.substr(prefix.size(), name.size() - prefix.size() - TEMPORARY_SUFFIX.size());
  return numbers.find_first_not_of("0123456789-") == std::string::npos;
}

fs::path folder_of(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

void remove_left_over_temporaries(const fs::path& target) {
  const std::string prefix = temporary_prefix(target);
  std::error_code error;
  for (fs::directory_iterator entry(folder_of(target), error), end; !error && entry != end;
       entry.increment(error)) {
    if (!is_temporary_of(prefix, entry->path().filename().string())) continue;
    Descriptor file(::open(entry->path().c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
    if (file.is_open() && file.is_free()) ::unlink(entry->path().c_str());
  }
}

/// A locked temporary file beside `target`; removed with the object unless it was renamed.
class Temporary {
 public:
  /// Errors name `path`, as the user wrote it.
  Temporary(const fs::path& path, const fs::path& target) : path_(path) {
    // The process id keeps two processes apart, O_EXCL a leftover of a killed one.
    for (int attempt = 0; attempt < 100; ++attempt) {
      name_ = folder_of(target) /
              fmt::format("{}{}-{}{}", temporary_prefix(target), ::getpid(), attempt, TEMPORARY_SUFFIX);
      Descriptor file(::open(name_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
      if (!file.is_open() && errno != EEXIST) fail(path, errno);
      // Another process may take it for left over before it is locked.
      if (!file.is_open() || !file.lock() || !file.is_linked()) continue;
      descriptor_ = std::move(file);
      return;
    }
    fail(path, EEXIST);
  }
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  ~Temporary() {
    if (!name_.empty()) ::unlink(name_.c_str());
  }

  void rename_to(const fs::path& target, const std::string_view bytes) {
    const Descriptor lock = descriptor_.duplicate();  // until the new name is there
    if (!descriptor_.write(bytes) || !descriptor_.sync() || !descriptor_.close()) fail(path_, errno);
    if (::rename(name_.c_str(), target.c_str()) != 0) fail(path_, errno);
    name_.clear();
    Descriptor folder(::open(folder_of(target).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (folder.is_open()) folder.sync();  // where that is not possible the rename is as good as it gets
  }

 private:
  fs::path path_, name_;
  Descriptor descriptor_{-1};
};

void write_directly(const fs::path& path, const std::string_view bytes) {
  Descriptor file(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
  if (!file.is_open() || !file.write(bytes) || !file.close()) fail(path, errno);
}

/// Where the rename goes. @throws regulus::Error if it cannot succeed
fs::path writable_target(const fs::path& path) {
  fs::path target = follow_links(path);
  std::error_code error;
  const fs::file_status status = fs::status(target, error);
  if (status.type() == fs::file_type::none) fail(path, error.value());
  if (fs::is_directory(status)) fail(path, EISDIR);
  if (!target.has_filename()) fail(path, ENOENT);
  // A rename would replace a file that its owner protected.
  if (fs::exists(status) && ::access(target.c_str(), W_OK) != 0) fail(path, errno);
  return target;
}

}  // namespace

bool is_device_or_pipe(const fs::path& path) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

fs::path follow_links(const fs::path& path) {
  constexpr int MOST_LINKS = 40;  // as many as Linux follows
  fs::path target = path;
  std::error_code error;
  for (int i = 0; i < MOST_LINKS; ++i) {
    if (!fs::is_symlink(fs::symlink_status(target, error))) return target;
    const fs::path next = fs::read_symlink(target, error);
    if (error) fail(path, error.value());
    target = next.is_absolute() ? next : folder_of(target) / next;
  }
  fail(path, ELOOP);
}

void write_file_atomically(const fs::path& path, const std::string_view bytes) {
  if (is_device_or_pipe(path)) return write_directly(path, bytes);
  const fs::path target = writable_target(path);
  remove_left_over_temporaries(target);
  Temporary(path, target).rename_to(target, bytes);
}

void require_writable(const fs::path& path) {
  if (is_device_or_pipe(path)) {
    if (::access(path.c_str(), W_OK) != 0) fail(path, errno);
    return;
  }
  const fs::path target = writable_target(path);
  remove_left_over_temporaries(target);
  const Temporary temporary(path, target);
}

fs::path write_to_temporary_folder(const fs::path& path, const std::string_view bytes) {
  std::error_code error;
  const fs::path folder = fs::temp_directory_path(error);
  if (error) return {};
  const std::string ending = fmt::format("-{}", path.filename().string().substr(0, 200));
  std::string name = (folder / ("regulus-XXXXXX" + ending)).string();
  Descriptor file(::mkostemps(name.data(), static_cast<int>(ending.size()), O_CLOEXEC));
  if (!file.is_open()) return {};
  if (file.write(bytes) && file.sync() && file.close()) return name;
  ::unlink(name.c_str());
  return {};
}

}  // namespace regulus
