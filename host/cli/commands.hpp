// The subcommands. Each function registers one with CLI11; the callback does the work and throws
// regulus::Error, which main turns into one line and an exit status.
#pragma once

#include <CLI/CLI.hpp>

namespace regulus::cli {

void add_render_command(CLI::App& app);
void add_plan_command(CLI::App& app);
void add_view_command(CLI::App& app);
void add_check_command(CLI::App& app);
void add_inspect_command(CLI::App& app);
void add_devices_command(CLI::App& app);
void add_merge_command(CLI::App& app);
void add_denoise_command(CLI::App& app);
void add_farm_command(CLI::App& app);
void add_doctor_command(CLI::App& app);

/// `completion` and `man`, which describe all commands of `app` that are there when they run.
void add_completion_commands(CLI::App& app);

}  // namespace regulus::cli
