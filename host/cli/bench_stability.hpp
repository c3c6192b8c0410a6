// `regulus bench stability`: where the arithmetic of device and reference ends.
#pragma once

#include <CLI/CLI.hpp>

namespace regulus::cli {

/// Registers the suite with the command `bench`.
void add_bench_stability_command(CLI::App& bench);

}  // namespace regulus::cli
