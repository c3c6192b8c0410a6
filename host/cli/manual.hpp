// Manual pages, in man's macros of roff.
#pragma once

#include <string>

#include "cli/command_tree.hpp"

namespace regulus::cli {

/// "regulus-bench-kernels.1"
std::string manual_name(const CommandEntry& entry);

/// The page of a command. @param root the program, for SEE ALSO
std::string manual_page(const CommandEntry& entry, const CommandEntry& root);

}  // namespace regulus::cli
