// What option values must be. Unlike those of CLI11 these refuse what is not a number (nan), and tell those
// who mistype a name which one is near.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "render/names.hpp"

namespace regulus::cli {

/// A finite number of [least, most].
CLI::Validator number_in(double least, double most);

/// A whole number of [least, most], in decimal digits.
CLI::Validator whole_number_in(uint64_t least, uint64_t most);

/// A finite number that is not negative.
CLI::Validator not_negative();

/// One of the names.
CLI::Validator one_of(const std::vector<std::string>& names);

/// The names with | between them, as help shows what an option takes.
std::string listed(render::Names names);

}  // namespace regulus::cli
