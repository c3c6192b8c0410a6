// The report of `regulus bench stability`: JSON, and one HTML page that needs nothing beside it.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "stability/report.hpp"

namespace regulus::bench {

nlohmann::json stability_json(const stability::Report& report);

/// The page, as HTML.
std::string stability_page(const stability::Report& report);

}  // namespace regulus::bench
