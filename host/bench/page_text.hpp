// What the pages of benchmarks share: a report in JSON inside a page that needs nothing beside it.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace regulus::bench {

/// A number in JSON, which has no infinities and no NaN: these become null.
nlohmann::json number(double value);

/// RFC 4648.
std::string base64(std::string_view bytes);

/// The address of a PNG that is part of the page.
std::string data_url(std::string_view png);

/// A page of host/bench/page with its report.
std::string filled_page(std::string_view page, const nlohmann::json& report);

}  // namespace regulus::bench
