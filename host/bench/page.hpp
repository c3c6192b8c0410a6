// The report of an error benchmark: JSON, and one HTML page that needs nothing beside it.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/error.hpp"

namespace regulus::bench {

/// One comparison: a scene, its reference and what was measured on it.
struct Section {
  std::string title;  ///< plain text
  std::string text;   ///< what it shows, plain text
  std::string scene;  ///< file
  image::Image reference;
  double reference_relmse = 0;  ///< expected error of the reference itself
  float exposure_ev = 0;        ///< of the pictures
  std::vector<ErrorRun> runs;
};

struct Report {
  std::string title, device, machine_note;
  std::vector<Section> sections;
  std::string axis = "seconds";  ///< of the curves at first: "seconds", "cpu_seconds" or "samples"
};

/// Everything but the pictures.
nlohmann::json report_json(const Report& report);

/// The page, as HTML.
std::string page_of(const Report& report);

}  // namespace regulus::bench
