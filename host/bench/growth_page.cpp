#include "bench/growth_page.hpp"

#include "bench/page_text.hpp"
#include "pages.hpp"

namespace regulus::bench {
namespace {

nlohmann::json fit_json(const GrowthSweep& sweep, double GrowthPoint::*quantity) {
  const PowerFit fit = fit_of(sweep, quantity);
  return {
      {"exponent", number(fit.exponent)}, {"deviation", number(fit.deviation)}, {"last", number(fit.last)}};
}

nlohmann::json sweep_json(const GrowthSweep& sweep) {
  nlohmann::json points = nlohmann::json::array();
  for (const GrowthPoint& point : sweep.points)
    points.push_back({{"size", number(point.size)},
                      {"prepare_seconds", number(point.prepare_seconds)},
                      {"render_seconds", number(point.render_seconds)},
                      {"device_bytes", number(point.device_bytes)}});
  return {{"name", sweep.name},
          {"text", sweep.text},
          {"points", points},
          {"prepare", fit_json(sweep, &GrowthPoint::prepare_seconds)},
          {"render", fit_json(sweep, &GrowthPoint::render_seconds)},
          {"memory", fit_json(sweep, &GrowthPoint::device_bytes)},
          {"n_log_n", number(log_linear_exponent(sweep))}};
}

}  // namespace

nlohmann::json growth_json(const GrowthReport& report) {
  nlohmann::json sweeps = nlohmann::json::array();
  for (const GrowthSweep& sweep : report.sweeps) sweeps.push_back(sweep_json(sweep));
  return {{"title", "Regulus: growth"},
          {"device", report.device},
          {"seconds", report.is_cpu_time ? "CPU seconds" : "seconds"},
          {"sweeps", sweeps}};
}

std::string growth_page(const GrowthReport& report) {
  return filled_page(GROWTH_PAGE, growth_json(report));
}

}  // namespace regulus::bench
