// How much tests do.
#pragma once

#include <cstdlib>

namespace regulus::test {

/// Whether statistics shall find small errors, however long that takes (`cmake/bootstrap test --full` sets
/// REGULUS_FULL_TESTS); otherwise those that a wrong factor makes, within the time of continuous integration.
inline bool is_full_run() {
  return std::getenv("REGULUS_FULL_TESTS") != nullptr;
}

/// Whether another driver has the same tests in this run of all: tests/support/run-on-drivers sets
/// REGULUS_TESTS_REPEATED, but for --full. Cases that only vary settings, and compile kernels for minutes,
/// are left out.
inline bool is_repeated_run() {
  return std::getenv("REGULUS_TESTS_REPEATED") != nullptr;
}

}  // namespace regulus::test
