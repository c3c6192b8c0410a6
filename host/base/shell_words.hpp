// Words that a POSIX shell takes as they are.
#pragma once

#include <string>
#include <string_view>

namespace regulus {

/// The text as one word of a shell's command line, whatever it holds but NUL: in single quotes.
inline std::string shell_word(std::string_view text) {
  std::string word = "'";
  for (const char letter : text) {
    if (letter == '\'')
      word += R"('\'')";
    else
      word += letter;
  }
  return word + "'";
}

/// The name of a file that no program takes for an option: a leading dash gets "./" before it.
inline std::string not_an_option(const std::string& file) {
  return file.starts_with('-') ? "./" + file : file;
}

}  // namespace regulus
