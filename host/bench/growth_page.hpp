// The report of `regulus bench growth`: JSON, and one HTML page that needs nothing beside it.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/growth.hpp"

namespace regulus::bench {

struct GrowthReport {
  std::string device;  ///< name and driver
  bool is_cpu_time;    ///< what seconds are
  std::vector<GrowthSweep> sweeps;
};

nlohmann::json growth_json(const GrowthReport& report);

/// The page, as HTML.
std::string growth_page(const GrowthReport& report);

}  // namespace regulus::bench
