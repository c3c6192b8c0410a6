// Parses the command line and turns every error into one line and an exit status.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <new>
#include <sstream>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/standard_streams.hpp"
#include "base/version.hpp"
#include "cli/arguments.hpp"
#include "cli/bench_kernels.hpp"
#include "cli/commands.hpp"
#include "cli/diff.hpp"
#include "cli/help.hpp"

namespace {

// The process's, for the error that ends it.
int exit_status(regulus::ErrorCode code) {
  switch (code) {
    case regulus::ErrorCode::Failed:
      return 1;
    case regulus::ErrorCode::BadUsage:
      return 2;
    case regulus::ErrorCode::BadFile:
      return 3;
    case regulus::ErrorCode::NoDevice:
      return 4;
    case regulus::ErrorCode::Interrupted:
      return 130;
  }
  return 1;
}

// One line on stderr, whatever the message contains.
int fail(std::string message, regulus::ErrorCode code) {
  std::replace(message.begin(), message.end(), '\n', ' ');
  std::fprintf(stderr, "regulus: error: %s\n", message.c_str());
  return exit_status(code);
}

int run(int argc, char** argv) {
  CLI::App app{"Regulus: renders glTF scenes with robust light transport on any Vulkan device", "regulus"};
  app.set_version_flag("--version", fmt::format("regulus {} (commit {}, {}, {})", regulus::VERSION,
                                                regulus::COMMIT, regulus::COMPILER, regulus::BUILD_TYPE));
  app.formatter(std::make_shared<regulus::cli::HelpFormatter>());
  app.require_subcommand(1);
  regulus::cli::add_render_command(app);
  regulus::cli::add_inspect_command(app);
  regulus::cli::add_plan_command(app);
  regulus::cli::add_view_command(app);
  regulus::cli::add_check_command(app);
  regulus::cli::add_devices_command(app);
  regulus::cli::add_diff_command(app);
  regulus::cli::add_merge_command(app);
  regulus::cli::add_denoise_command(app);
  regulus::cli::add_farm_command(app);
  regulus::cli::add_bench_command(app);
  regulus::cli::add_doctor_command(app);
  regulus::cli::add_completion_commands(app);
  regulus::cli::refuse_empty_values(app);
  const std::vector<std::string> arguments = regulus::cli::read_arguments(app, argc, argv);
  try {
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));  // CLI11 takes the last first
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {  // --help, --version
      std::ostringstream text;
      app.exit(error, text, text);
      regulus::say_text(text.str());
    } else {
      return fail(regulus::cli::describe_usage_error(app, arguments, error) + " (see --help)",
                  regulus::ErrorCode::BadUsage);
    }
  }
  regulus::finish_stdout();
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    regulus::prepare_streams();
    return run(argc, argv);
  } catch (const regulus::SettingError& error) {
    return fail(std::string("--") + error.what(), error.code());  // settings are options here
  } catch (const regulus::Error& error) {
    return fail(error.what(), error.code());
  } catch (const std::bad_alloc&) {
    return fail("out of memory", regulus::ErrorCode::Failed);
  } catch (const std::exception& error) {
    return fail(error.what(), regulus::ErrorCode::Failed);
  }
}
