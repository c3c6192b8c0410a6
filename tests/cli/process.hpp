// Runs the regulus binary as a user would and captures what it says.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace regulus::test {

using Arguments = std::vector<std::string>;
/// Variables to set on top of the test's own environment.
using Environment = std::map<std::string, std::string>;

struct Finished {
  int status = -1;  ///< exit status; -1 if a signal ended it
  int signal = 0;   ///< 0 if it ended by itself
  std::string out, err;
};

/// What the new process does to itself before it becomes regulus, such as closing a stream or setting a
/// limit.
using Preparation = std::function<void()>;

/// A running regulus with its output going to files, and signals as a shell leaves them. Killed with the
/// object if it still runs.
class Process {
 public:
  explicit Process(const Arguments& arguments, const Environment& environment = {},
                   const Preparation& preparation = {});
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  /// Waits until the process catches `signal` itself, which says that rendering has begun. False if it ended
  /// before that or a minute passed.
  bool wait_for_handler(int signal);
  /// Whether it catches `signal` itself.
  bool catches(int signal) const;
  void send(int signal);
  /// Processor time of all its threads so far, user and system, to a tick of the system (10 ms).
  double processor_seconds() const;
  /// What it has written to stdout so far.
  std::string said() const;
  Finished wait();

 private:
  pid_t pid_ = -1;
  std::filesystem::path out_, err_;
};

/// Runs to the end.
Finished run(const Arguments& arguments, const Environment& environment = {},
             const Preparation& preparation = {});

size_t count_lines(const std::string& text);

/// Fails the calling test unless the process ended with `status`, printed nothing on stdout, and one line on
/// stderr that begins as errors do and contains each of `mentions`.
void expect_error(const Finished& finished, int status, const std::vector<std::string>& mentions = {});

}  // namespace regulus::test
