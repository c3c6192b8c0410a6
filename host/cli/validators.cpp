#include "cli/validators.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "base/near_names.hpp"

namespace regulus::cli {

namespace {

// None of the validators describes itself: the help shows what an option takes by its type's name.
constexpr const char* WITHOUT_DESCRIPTION = "";

/// A validator of numbers. @param range for the error, as in "from 0 to 1"
template <typename IsValid>
CLI::Validator number_validator(const std::string& range, const IsValid& is_valid) {
  return {[range, is_valid](std::string& text) {
            double value = 0;
            const bool is_number = CLI::detail::lexical_cast(text, value) && !std::isnan(value);
            return is_number && is_valid(value) ? std::string()
                                                : fmt::format("\"{}\" is not a number {}", text, range);
          },
          WITHOUT_DESCRIPTION};
}

}  // namespace

CLI::Validator number_in(double least, double most) {
  return number_validator(fmt::format("from {:g} to {:g}", least, most),
                          [=](double value) { return value >= least && value <= most; });
}

CLI::Validator whole_number_in(uint64_t least, uint64_t most) {
  return {[=](std::string& text) {
            uint64_t value = 0;
            const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
            const bool is_whole = error == std::errc{} && end == text.data() + text.size();
            return is_whole && value >= least && value <= most
                       ? std::string()
                       : fmt::format("\"{}\" is not a whole number from {} to {}", text, least, most);
          },
          WITHOUT_DESCRIPTION};
}

CLI::Validator not_negative() {
  return number_validator("from 0 on", [](double value) { return value >= 0 && std::isfinite(value); });
}

std::string listed(render::Names names) {
  return fmt::format("{}", fmt::join(render::names_of(names), "|"));
}

CLI::Validator one_of(const std::vector<std::string>& names) {
  return {[names](std::string& text) {
            return std::ranges::find(names, text) != names.end() ? std::string() : unknown_name(text, names);
          },
          WITHOUT_DESCRIPTION};
}

}  // namespace regulus::cli
