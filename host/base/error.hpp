// The one exception type of Regulus and the exit status it maps to. Thrown where the problem is known,
// caught in main, printed as one line.
#pragma once

#include <stdexcept>
#include <string>

#include "base/printable.hpp"

namespace regulus {

/// Exit status of the process.
enum class ExitStatus { Done = 0, Failed = 1, BadUsage = 2, BadFile = 3, NoDevice = 4, Interrupted = 130 };

/// An error the user can act on. The message is one line that names the file or option, the offending
/// element and what to do; what it quotes of files is made printable.
class Error : public std::runtime_error {
 public:
  Error(ExitStatus status, const std::string& message)
      : std::runtime_error(printable(message)), status_(status) {}
  ExitStatus status() const { return status_; }

 private:
  ExitStatus status_;
};

}  // namespace regulus
