#include "cli/help.hpp"

#include <fmt/format.h>

#include <utility>

namespace regulus::cli {

namespace {

// Wide enough for most options with what they take; longer ones have their description on the next line.
constexpr size_t OPTIONS_COLUMN_WIDTH = 34;
constexpr size_t DESCRIPTION_WIDTH = 76;

/// The text with line breaks instead of spaces, so that lines have `width` characters at most where words
/// allow.
std::string wrapped(std::string text, size_t width) {
  size_t line = 0, space = std::string::npos;
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] == ' ') space = i;
    if (i - line >= width && space != std::string::npos) {
      text[space] = '\n';
      line = space + 1;
      space = std::string::npos;
    }
  }
  return text;
}

}  // namespace

HelpFormatter::HelpFormatter() {
  column_width(OPTIONS_COLUMN_WIDTH);
}

std::string HelpFormatter::make_option_opts(const CLI::Option* option) const {
  if (option->get_type_size() == 0) return "";
  const bool takes_many = option->get_expected_max() == CLI::detail::expected_max_vector_size;
  return fmt::format(" {}{}", option->get_type_name(), takes_many ? " ..." : "");
}

std::string HelpFormatter::make_option_desc(const CLI::Option* option) const {
  std::string text = option->get_description();
  if (!option->get_default_str().empty() && option->get_type_size() != 0)
    text += fmt::format(" (default: {})", option->get_default_str());
  // Hidden options have no name here.
  for (const CLI::Option* other : option->get_needs())
    if (!other->get_name().empty()) text += fmt::format(" (only with {})", other->get_name());
  for (const CLI::Option* other : option->get_excludes())
    if (!other->get_name().empty()) text += fmt::format(" (not with {})", other->get_name());
  return wrapped(std::move(text), DESCRIPTION_WIDTH);
}

}  // namespace regulus::cli
