#include "cli/bench_talk.hpp"

namespace regulus::cli {

std::vector<BenchComparison> talk_comparisons(const std::string& folder) {
  const auto scene = [&](const char* name) { return folder + "/" + name + "/" + name + ".gltf"; };
  const std::string none = " --regularization none", roughness = " --regularization roughness";
  return {
      {"Path tracing, without and with regularization",
       "Light that reaches a diffuse surface through a mirror or glass from a small lamp is what path "
       "tracing does "
       "not find.",
       scene("watch"),
       {{"pt", "-i pt" + none}, {"pt, roughness", "-i pt" + roughness}}},
      {"Bidirectional path tracing: without, and regularized",
       "Connections to specular vertices become possible.",
       scene("watch"),
       {{"bpt", "-i bpt" + none}, {"bpt, roughness", "-i bpt" + roughness}}},
      {"Weights",
       "Several techniques find the same regularized path. Weights that ignore it count its light several "
       "times; "
       "corrected ones nearly conserve it, blended ones do.",
       scene("mirrors"),
       {{"unmodified", "-i bpt --mis unmodified" + roughness},
        {"corrected", "-i bpt --mis corrected" + roughness},
        {"blended", "-i bpt --mis blended" + roughness}}},
      {"Path tracing, bidirectional path tracing, vertex connection and merging",
       "Equal time, without and with regularization.",
       scene("pool"),
       {{"pt", "-i pt" + none},
        {"pt, roughness", "-i pt" + roughness},
        {"bpt", "-i bpt" + none},
        {"bpt, roughness", "-i bpt" + roughness},
        {"vcm", "-i vcm" + none},
        {"vcm, roughness", "-i vcm" + roughness}}},
  };
}

}  // namespace regulus::cli
