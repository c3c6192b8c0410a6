// The words of a command line: -o=FILE, and what those who mistype a command or an option may have meant.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace regulus::cli {

/// Makes an empty value, as of a shell's unset variable, an error of every option of the command and those
/// below it. Call when all are declared.
void refuse_empty_values(CLI::App& app);

/// The words of the command line without the program's name. "-o=x", which CLI11 would read as the value
/// "=x", becomes "--output=x" where -o is an option of the command and the word is not another's value.
std::vector<std::string> read_arguments(const CLI::App& app, int argc, char** argv);

/// One line on what is wrong with the command line that `app` refused with `error`, and near names.
std::string describe_usage_error(const CLI::App& app, const std::vector<std::string>& arguments,
                                 const CLI::ParseError& error);

}  // namespace regulus::cli
