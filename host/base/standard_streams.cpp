#include "base/standard_streams.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <system_error>

#include "base/error.hpp"

namespace regulus {

namespace {

int stdout_error = 0;  // of the first write to stdout that failed; 0: none did
bool is_forgiven = false;

void remember_failure() {
  if (stdout_error == 0) stdout_error = errno != 0 ? errno : EIO;
}

}  // namespace

void prepare_streams() {
  for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    // Opened the wrong way round, it cannot be used either.
    if (::fcntl(fd, F_GETFD) < 0 && errno == EBADF)
      ::open("/dev/null", fd == STDIN_FILENO ? O_WRONLY : O_RDONLY);
  }
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

void say_text(const std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) < text.size()) remember_failure();
}

void flush_stdout() {
  if (std::fflush(stdout) != 0) remember_failure();
}

void finish_stdout() {
  flush_stdout();
  const bool is_reader_gone = stdout_error == EPIPE || stdout_error == EIO;
  if (stdout_error == 0 || is_reader_gone || is_forgiven) return;
  throw Error(ErrorCode::Failed,
              fmt::format("stdout: cannot be written ({}); choose another place or make room",
                          std::generic_category().message(stdout_error)));
}

void forgive_stdout() {
  is_forgiven = true;
}

}  // namespace regulus
