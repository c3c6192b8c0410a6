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
