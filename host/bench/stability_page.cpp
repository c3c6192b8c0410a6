#include "bench/stability_page.hpp"

#include "bench/page_text.hpp"
#include "pages.hpp"

namespace regulus::bench {
namespace {

nlohmann::json sweep_json(const stability::Sweep& sweep) {
  nlohmann::json points = nlohmann::json::array();
  for (const stability::SweepPoint& point : sweep.points())
    points.push_back({{"parameter", point.parameter},
                      {"cases", point.cases},
                      {"device", number(point.device_error)},
                      {"reference", number(point.reference_error)},
                      {"bound", number(point.bound)}});
  const auto [from, to] = sweep.accurate_range(0.01);
  const nlohmann::json accurate = from > 0 ? nlohmann::json({from, to}) : nlohmann::json(nullptr);
  return {{"family", sweep.text().family},
          {"name", sweep.text().name},
          {"parameter", sweep.text().parameter},
          {"bound_source", sweep.text().bound},
          {"cases", sweep.cases()},
          {"device", number(sweep.worst_device())},
          {"device_ratio", number(sweep.device_ratio())},
          {"reference", number(sweep.worst_reference())},
          {"reference_ratio", number(sweep.reference_ratio())},
          {"accurate", accurate},
          {"non_finite_device", sweep.non_finite_device()},
          {"non_finite_reference", sweep.non_finite_reference()},
          {"lost", sweep.lost()},
          {"worst_case", sweep.worst_case()},
          {"holds", sweep.holds()},
          {"points", points}};
}

}  // namespace

nlohmann::json stability_json(const stability::Report& report) {
  nlohmann::json sweeps = nlohmann::json::array();
  for (const stability::Sweep& sweep : report.sweeps) sweeps.push_back(sweep_json(sweep));
  return {{"title", "Regulus: numerical stability"},
          {"device", report.device},
          {"driver", report.driver},
          {"extent", report.extent},
          {"holds", report.holds()},
          {"sweeps", sweeps}};
}

std::string stability_page(const stability::Report& report) {
  return filled_page(STABILITY_PAGE, stability_json(report));
}

}  // namespace regulus::bench
