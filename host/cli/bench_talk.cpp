#include "cli/bench_talk.hpp"

namespace regulus::cli {

std::vector<BenchComparison> talk_comparisons(const std::string& folder) {
  const auto scene = [&](const char* name) { return folder + "/" + name + "/" + name + ".gltf"; };
  const std::string none = " --regularization none", roughness = " --regularization roughness";
  // Strong enough for the eye.
  const std::string blurred = roughness + " --tau 2 --tau-schedule fixed";
  return {
      {"Path tracing, without and with regularization",
       "Light that reaches a diffuse surface through a mirror or glass from a small lamp is what path "
       "tracing does not find.",
       scene("watch"),
       {{"pt", "-i pt" + none}, {"pt, roughness", "-i pt" + roughness}}},
      {"Bidirectional path tracing: without, virtual merges, raised roughness",
       "Connections to specular vertices become possible. A virtual merge accepts what a lobe sends "
       "into a cone; raised roughness needs no tries. Both: with and without regularization at once.",
       scene("watch"),
       {{"bpt", "-i bpt" + none},
        {"virtual merge", "-i bpt --regularization virtual-merge"},
        {"roughness", "-i bpt" + roughness},
        {"both", "-i bpt --regularization both"}}},
      {"Weights",
       "The same samples, weighted in three ways. Several techniques find the same regularized path. "
       "Weights that ignore it count its light several times; corrected ones nearly conserve it, "
       "blended ones do.",
       scene("mirrors"),
       {{"unmodified", "-i bpt --mis unmodified" + roughness},
        {"corrected", "-i bpt --mis corrected" + roughness},
        {"blended", "-i bpt --mis blended" + roughness}},
       64},
      {"Path diffusion",
       "What the camera sees directly, or through surfaces that are all sharp, needs no regularization.",
       scene("cornell"),
       {{"without", "-i bpt --diffusion off" + blurred}, {"path diffusion", "-i bpt" + blurred}}},
      {"Sampler quality",
       "A caustic that light subpaths find by themselves needs none either. Both heuristics together "
       "leave alone what one of them does.",
       scene("cornell"),
       {{"bpt, none", "-i bpt" + none},
        {"path diffusion", "-i bpt" + blurred},
        {"sampler quality", "-i bpt --sampler-quality on --diffusion off" + blurred},
        {"both", "-i bpt --sampler-quality on" + blurred},
        {"both, smooth", "-i bpt --sampler-quality smooth" + blurred}}},
      {"Path tracing, bidirectional path tracing, vertex connection and merging",
       "Equal time, without and with regularization.",
       scene("pool"),
       {{"pt", "-i pt" + none},
        {"pt, roughness", "-i pt" + roughness},
        {"bpt", "-i bpt" + none},
        {"bpt, roughness", "-i bpt" + roughness},
        {"vcm", "-i vcm" + none},
        {"vcm, roughness", "-i vcm" + roughness}}},
      {"Clamping",
       "Bounding what a sample adds loses the light that regularization spreads: here the bound is the "
       "one that leaves the same variance.",
       scene("watch"),
       {{"pt, roughness", "-i pt" + roughness},
        {"pt, clamped", "-i pt" + none, "pt, roughness"},
        {"bpt, roughness", "-i bpt" + roughness},
        {"bpt, clamped", "-i bpt" + none, "bpt, roughness"}}},
  };
}

}  // namespace regulus::cli
