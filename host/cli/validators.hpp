// What option values must be. Unlike those of CLI11 these refuse what is not a number (nan), and tell those
// who mistype a name which one is near.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace regulus::cli {

/// A finite number of [least, most].
CLI::Validator number_in(double least, double most);

/// A number above 0, also as a float; inf is one.
CLI::Validator positive_or_infinite();

/// A finite number that is not negative.
CLI::Validator not_negative();

/// One of the names; the value becomes its number.
CLI::Validator choice(const std::map<std::string, uint32_t>& names);

/// One of the names.
CLI::Validator one_of(const std::vector<std::string>& names);

/// The keys of a map from names.
template <typename Map>
std::vector<std::string> names_of(const Map& map) {
  std::vector<std::string> names;
  names.reserve(map.size());
  for (const auto& [name, ignored] : map) names.emplace_back(name);
  return names;
}

}  // namespace regulus::cli
