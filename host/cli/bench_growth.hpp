// regulus bench growth.
#pragma once

#include <CLI/CLI.hpp>

namespace regulus::cli {

void add_bench_growth_command(CLI::App& bench);

}  // namespace regulus::cli
