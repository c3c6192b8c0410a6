// The report of a render (`render --report`): one HTML page that needs nothing beside it.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "image/image.hpp"

namespace regulus::bench {

/// What is known of a render while it ran.
struct ConvergencePoint {
  double seconds = 0, samples = 0;  ///< of rendering; per pixel
  double error = 0;                 ///< estimated, relative
};

struct RenderReport {
  std::string title, about;  ///< plain text
  std::string summary;       ///< size, samples, seconds, error in words
  const image::Image& image;
  const image::Channels& channels;
  float exposure_ev = 0;      ///< that the picture is shown with at first
  nlohmann::json statistics;  ///< as --stats has them, or only the header's attributes
  nlohmann::json candidates;  ///< sets of techniques as `plan --json` has them; an empty array: none
  std::vector<ConvergencePoint> convergence;
  std::vector<std::string> warnings;
};

/// The page, as HTML. @throws regulus::Error (Failed)
std::string render_page(const RenderReport& report);

}  // namespace regulus::bench
