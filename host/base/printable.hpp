// Text of unknown origin made fit for a terminal.
#pragma once

#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>

namespace regulus {

/// The text in one line, with everything that a terminal could obey written out: line breaks and tabs become
/// spaces, other control characters (C0, DEL, C1), those that turn or split lines (U+2028 to 202E, 2066 to
/// 2069) and bytes that are no UTF-8 become \x1b and the like, byte by byte.
inline std::string printable(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  const auto byte_at = [&](size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  for (size_t i = 0; i < text.size();) {
    const unsigned lead = byte_at(i);
    const size_t length = lead < 0x80       ? 1
                          : lead >> 5 == 6  ? 2
                          : lead >> 4 == 14 ? 3
                          : lead >> 3 == 30 ? 4
                                            : 0;
    uint32_t code = length <= 1 ? lead : lead & (0x7Fu >> length);
    bool is_plain = length != 0;
    for (size_t k = 1; k < length; ++k) {
      is_plain = is_plain && byte_at(i + k) >> 6 == 2;
      code = code << 6 | (byte_at(i + k) & 0x3Fu);
    }
    constexpr uint32_t LEAST[] = {0, 0, 0x80, 0x800, 0x10000};
    const bool is_control = code < 0x20 || (code >= 0x7F && code < 0xA0) ||
                            (code >= 0x2028 && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069);
    is_plain = is_plain && !is_control && code >= LEAST[length] && code <= 0x10FFFF &&
               (code < 0xD800 || code > 0xDFFF);
    if (lead == '\n' || lead == '\r' || lead == '\t') {
      result += ' ';
      ++i;
    } else if (is_plain) {
      result += text.substr(i, length);
      i += length;
    } else {
      char written[5];
      std::snprintf(written, sizeof written, "\\x%02x", lead);
      result += written;
      ++i;
    }
  }
  return result;
}

}  // namespace regulus
