// Whether somebody looks.
#pragma once

#include <unistd.h>

namespace regulus {

/// stderr is a terminal, not a file or a pipe.
inline bool stderr_is_terminal() {
  return isatty(STDERR_FILENO) != 0;
}

}  // namespace regulus
