// `regulus bench skip`: what it saves to leave out what a scene lacks.
#pragma once

#include <CLI/CLI.hpp>

namespace regulus::cli {

/// Registers the suite with the command `bench`.
void add_bench_skip_command(CLI::App& bench);

}  // namespace regulus::cli
