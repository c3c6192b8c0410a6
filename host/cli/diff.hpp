// regulus diff A.exr REF.exr: error metrics of an image against a reference.
#pragma once

#include <CLI/CLI.hpp>

namespace regulus::cli {

void add_diff_command(CLI::App& app);

}  // namespace regulus::cli
