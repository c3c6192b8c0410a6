// This process and its environment.
#pragma once

#include <unistd.h>

#include <cstdlib>

namespace regulus {

/// A number that no other running process has.
inline int process_number() {
  return static_cast<int>(::getpid());
}

/// Gives a variable of the environment a value unless it has one. Not while other threads read the
/// environment.
inline void set_default_variable(const char* name, const char* value) {
  ::setenv(name, value, 0);
}

}  // namespace regulus
