// `regulus bench error`, `bench reference` and `bench talk`: error against time.
#pragma once

#include <CLI/CLI.hpp>

namespace regulus::cli {

/// Registers the three suites with the command `bench`.
void add_bench_error_commands(CLI::App& bench);

}  // namespace regulus::cli
