#include "bench/page.hpp"

#include "bench/page_text.hpp"
#include "image/formats.hpp"
#include "pages.hpp"

namespace regulus::bench {
namespace {

nlohmann::json run_json(const ErrorRun& run) {
  nlohmann::json points = nlohmann::json::array();
  for (const ErrorPoint& point : run.points)
    points.push_back({{"seconds", number(point.seconds)},
                      {"cpu_seconds", number(point.cpu_seconds)},
                      {"samples", number(point.samples)},
                      {"relmse", number(point.relmse)}});
  return {{"name", run.name},
          {"options", run.options},
          {"mse", number(run.mse)},
          {"relmse", number(run.relmse)},
          {"trimmed_relmse", number(run.trimmed_relmse)},
          {"flip", number(run.flip)},
          {"variance", number(run.variance)},
          {"squared_bias", number(run.squared_bias)},
          {"mean_ratio", number(run.mean_ratio)},
          {"points", points}};
}

nlohmann::json section_json(const Section& section) {
  nlohmann::json runs = nlohmann::json::array();
  for (const ErrorRun& run : section.runs) runs.push_back(run_json(run));
  return {{"title", section.title},
          {"text", section.text},
          {"scene", section.scene},
          {"width", section.reference.width},
          {"height", section.reference.height},
          {"reference_relmse", number(section.reference_relmse)},
          {"runs", runs}};
}

void add_pictures(nlohmann::json& json, const Section& section) {
  json["reference_png"] =
      data_url(encode_tone_mapped(image::Format::Png, section.reference, section.exposure_ev, "reference"));
  for (size_t i = 0; i < section.runs.size(); ++i) {
    const ErrorRun& run = section.runs[i];
    json["runs"][i]["png"] =
        data_url(encode_tone_mapped(image::Format::Png, run.image, section.exposure_ev, run.name));
    json["runs"][i]["heat_png"] =
        data_url(encode_heat_map(image::Format::Png, run.image, section.reference, run.name));
  }
}

}  // namespace

nlohmann::json report_json(const Report& report) {
  nlohmann::json sections = nlohmann::json::array();
  for (const Section& section : report.sections) sections.push_back(section_json(section));
  return {{"title", report.title},
          {"device", report.device},
          {"machine_note", report.machine_note},
          {"axis", report.axis},
          {"sections", sections}};
}

std::string page_of(const Report& report) {
  nlohmann::json json = report_json(report);
  for (size_t i = 0; i < report.sections.size(); ++i) add_pictures(json["sections"][i], report.sections[i]);
  return filled_page(ERROR_PAGE, json);
}

}  // namespace regulus::bench
