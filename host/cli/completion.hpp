// Scripts with which shells complete the command line.
#pragma once

#include <string>

#include "cli/command_tree.hpp"

namespace regulus::cli {

std::string bash_completion(const CommandEntry& root);
std::string zsh_completion(const CommandEntry& root);
std::string fish_completion(const CommandEntry& root);

}  // namespace regulus::cli
