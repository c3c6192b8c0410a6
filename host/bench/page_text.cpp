#include "bench/page_text.hpp"

#include <cmath>

namespace regulus::bench {
namespace {

// JSON inside a script element, which "</" would end: "<\/" means the same.
std::string script_safe(std::string_view text) {
  std::string safe;
  for (const char c : text) {
    if (c == '/' && !safe.empty() && safe.back() == '<') safe += '\\';
    safe += c;
  }
  return safe;
}

}  // namespace

std::string base64(std::string_view bytes) {
  constexpr std::string_view DIGITS = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t group = 0;
    for (size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? static_cast<uint8_t>(bytes[i + k]) : 0u);
    for (size_t k = 0; k < 4; ++k) text += k <= bytes.size() - i ? DIGITS[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

std::string data_url(std::string_view png) {
  return "data:image/png;base64," + base64(png);
}

nlohmann::json number(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

std::string filled_page(std::string_view page, const nlohmann::json& report) {
  constexpr std::string_view MARK = "\"REPORT\"";
  std::string text(page);
  text.replace(text.find(MARK), MARK.size(),
               script_safe(report.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)));
  return text;
}

}  // namespace regulus::bench
