// Weights of multiple importance sampling: the shaders' recurrences and the reference's definition against
// products of densities in extended precision, over paths made of nothing but pdfs, distances and cosines.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "interface/wavefront.h"
#include "reference/techniques.hpp"
#include "stability/batch.hpp"
#include "stability/families.hpp"

namespace regulus::stability {

using namespace interface;

namespace {

/// What paths of one point of a sweep are made of.
struct PathKind {
  uint32_t edges = 8;
  double factor = 100;  ///< pdfs lie within this factor of 1, distances within its square root
  double drift = 1;     ///< mean factor between going on and going back, of each vertex
  double light_paths = 1e6;
  double merge_radius = 1e-3;  ///< distances are about 1
};

struct WeightsCase {
  double parameter;
  StabilityPath path;
};

/// A sweep's cases.
struct WeightsSweep {
  const char* name;
  const char* parameter;
  std::vector<WeightsCase> cases;
};

StabilityPath make_path(const PathKind& kind, std::mt19937_64& random) {
  const auto within = [&](double factor) {
    const double u = 2 * (static_cast<double>(random() >> 11) * 0x1p-53) - 1;
    return static_cast<float>(std::pow(factor, u));
  };
  StabilityPath path{};
  path.edges = kind.edges;
  path.light_paths = static_cast<float>(kind.light_paths);
  path.merge =
      static_cast<float>(kind.light_paths * std::numbers::pi * kind.merge_radius * kind.merge_radius);
  path.connect_pdf = within(kind.factor);
  path.point_pdf = within(kind.factor);
  path.direction_pdf = within(kind.factor);
  path.camera_pdf = within(kind.factor);
  for (uint32_t i = 0; i < kind.edges; ++i) {
    StabilityStep& step = path.steps[i];
    step.forward = within(kind.factor);
    step.reverse = static_cast<float>(within(kind.factor) * kind.drift);
    step.distance = within(std::sqrt(kind.factor));
    step.cos_light_end = 0.3f * within(3);
    step.cos_camera_end = 0.3f * within(3);
  }
  return path;
}

/// n p of all techniques in the order of StabilityWeights; those of no technique are 0.
std::vector<Exact> exact_densities(const StabilityPath& path) {
  const uint32_t edges = path.edges;
  const auto from_light = [&](uint32_t i) {  // area pdf of x_i, 1 <= i < K
    const StabilityStep& edge = path.steps[i - 1];
    const Exact pdf = i == 1 ? path.direction_pdf : path.steps[i - 1].forward;
    return pdf * edge.cos_camera_end / (Exact{edge.distance} * edge.distance);
  };
  const auto from_camera = [&](uint32_t i) {  // 0 <= i < K
    const StabilityStep& edge = path.steps[i];
    const Exact pdf = i + 1 == edges ? path.camera_pdf : path.steps[i + 1].reverse;
    return pdf * edge.cos_light_end / (Exact{edge.distance} * edge.distance);
  };
  std::vector<Exact> light(edges + 1, path.point_pdf), camera(edges + 1, 1);  // of the first / last vertices
  for (uint32_t i = 2; i <= edges; ++i) light[i] = light[i - 1] * from_light(i - 1);
  for (uint32_t i = edges; i-- > 0;) camera[i] = camera[i + 1] * from_camera(i);
  std::vector<Exact> densities(STABILITY_WEIGHTS, 0);
  densities[0] = camera[0];
  densities[1] = path.connect_pdf * camera[1];
  for (uint32_t s = 2; s < edges; ++s) densities[s] = light[s] * camera[s];
  densities[edges] = path.light_paths * light[edges] * camera[edges];
  for (uint32_t j = 1; j < edges; ++j)
    densities[STABILITY_MAX_EDGES + j] = path.merge * light[j + 1] * camera[j];
  return densities;
}

/// The same by the reference's list of techniques: weights, in the same order.
std::vector<double> reference_weights(const StabilityPath& path) {
  reference::Path finished;
  finished.light.point_pdf = path.point_pdf;
  finished.light.connect_pdf = path.connect_pdf;
  finished.light.density = {path.direction_pdf};
  finished.camera = {path.camera_pdf};
  finished.vertices.resize(path.edges + 1);
  for (uint32_t i = 0; i < path.edges; ++i) {
    const StabilityStep& step = path.steps[i];
    finished.vertices[i].value = glm::dvec3(1);
    finished.vertices[i].forward = step.forward;
    finished.vertices[i].reverse = step.reverse;
    finished.edges.push_back({step.distance, step.cos_light_end, step.cos_camera_end, glm::dvec3(1)});
  }
  reference::TechniqueSet set;
  set.bits = TECHNIQUE_HIT | TECHNIQUE_NEE | TECHNIQUE_SPLAT | TECHNIQUE_CONNECT | TECHNIQUE_MERGE;
  set.light_paths = path.light_paths;
  set.merge_area = double{path.merge} / path.light_paths;
  const std::vector<reference::Technique> techniques = reference::list_techniques(finished, set);
  std::vector<double> weights(STABILITY_WEIGHTS, 0);
  for (const reference::Technique& technique : techniques) {
    const size_t place =
        technique.kind == TECHNIQUE_MERGE ? STABILITY_MAX_EDGES + technique.vertex : technique.vertex;
    weights[place] = reference::mis_weight(techniques, technique);
  }
  return weights;
}

/// Cases over one member of PathKind.
template <typename Set>
WeightsSweep sweep_over(const char* name, const char* parameter, const std::vector<double>& values, int paths,
                        const Set& set) {
  WeightsSweep sweep{name, parameter, {}};
  std::mt19937_64 random(16);
  for (const double value : values)
    for (int i = 0; i < paths; ++i) {
      PathKind kind;
      set(kind, value);
      sweep.cases.push_back({value, make_path(kind, random)});
    }
  return sweep;
}

std::vector<WeightsSweep> weights_sweeps(Extent extent) {
  const bool is_quick = extent == Extent::Quick;
  const int paths = is_quick ? 8 : 64;
  const int points = is_quick ? 9 : 33;
  return {
      sweep_over("over vertices", "edges of the path", {2, 3, 4, 8, 16, 32, 48, 64}, paths,
                 [](PathKind& kind, double edges) {
                   kind.edges = static_cast<uint32_t>(edges);
                   kind.factor = 10;
                 }),
      sweep_over("over the range of pdfs", "largest pdf, 1/sr", in_equal_ratios(1, 1e12, points), paths,
                 [](PathKind& kind, double factor) { kind.factor = factor; }),
      sweep_over("over the range of pdfs along 64 edges", "largest pdf, 1/sr",
                 in_equal_ratios(1, 1e12, points), paths,
                 [](PathKind& kind, double factor) {
                   kind.edges = 64;
                   kind.factor = factor;
                 }),
      sweep_over("over drift", "pdf back over pdf forward, at each of 64 vertices",
                 in_equal_ratios(1e-12, 1e12, points), paths,
                 [](PathKind& kind, double drift) {
                   kind.edges = 64;
                   kind.factor = 4;
                   kind.drift = drift;
                 }),
      sweep_over("over light paths", "light paths", in_equal_ratios(1, 1e8, points), paths,
                 [](PathKind& kind, double light_paths) { kind.light_paths = light_paths; }),
      sweep_over("over the merge radius", "radius over distances", in_equal_ratios(1e-8, 10, points), paths,
                 [](PathKind& kind, double radius) { kind.merge_radius = radius; }),
  };
}

std::string describe(const StabilityPath& path, uint32_t technique) {
  return fmt::format("technique {} of a path with {} edges, {:.3g} light paths, merge {:.3g}", technique,
                     path.edges, path.light_paths, path.merge);
}

// All terms are positive, so nothing cancels: a weight has the rounding of its longest chain, ten a vertex.
constexpr double ROUNDINGS_PER_VERTEX = 10;
constexpr double OWN_ERROR = STABILITY_MAX_EDGES * ROUNDINGS_PER_VERTEX * 0x1p-24;
constexpr double OWN_REFERENCE_ERROR = STABILITY_MAX_EDGES * ROUNDINGS_PER_VERTEX * 0x1p-53;
// Weights below this carry next to nothing; floats keep 1e-38.
constexpr double NEGLIGIBLE = 1e-12;

}  // namespace

std::vector<Sweep> sweep_weights(gpu::Device& device, Extent extent) {
  const gpu::Kernel kernel =
      create_kernel(device, "weights",
                    {{SPEC_TECHNIQUES, TECHNIQUE_HIT | TECHNIQUE_NEE | TECHNIQUE_SPLAT | TECHNIQUE_CONNECT |
                                           TECHNIQUE_MERGE}});
  std::vector<Sweep> all;
  for (const WeightsSweep& sweep : weights_sweeps(extent)) {
    const std::string bound =
        fmt::format("{:.1e}: 10 roundings at each of 64 vertices, all terms positive", OWN_ERROR);
    Sweep weights({"weights", fmt::format("weights {}", sweep.name), sweep.parameter, bound, OWN_ERROR,
                   OWN_REFERENCE_ERROR, NEGLIGIBLE});
    Sweep sums({"weights", fmt::format("sum of weights {}", sweep.name), sweep.parameter, bound, OWN_ERROR,
                OWN_REFERENCE_ERROR, NEGLIGIBLE});
    std::vector<StabilityPath> paths;
    for (const WeightsCase& c : sweep.cases) paths.push_back(c.path);
    const auto found = map_on_device<StabilityWeights>(device, kernel, paths);
    for (size_t i = 0; i < paths.size(); ++i) {
      const StabilityPath& path = paths[i];
      const std::vector<Exact> densities = exact_densities(path);
      const std::vector<double> expected = reference_weights(path);
      Exact sum = 0;
      for (const Exact density : densities) sum += density;
      double device_sum = 0;
      double reference_sum = 0;
      for (uint32_t k = 0; k < STABILITY_WEIGHTS; ++k) {
        if (densities[k] == 0) continue;
        const double weight = found[i].weights[k];
        weights.add({sweep.cases[i].parameter, weight, expected[k], densities[k] / sum, 0},
                    [&] { return describe(path, k); });
        device_sum += weight;
        reference_sum += expected[k];
      }
      sums.add({sweep.cases[i].parameter, device_sum, reference_sum, 1, 0},
               [&] { return describe(path, 0); });
    }
    all.push_back(std::move(weights));
    all.push_back(std::move(sums));
  }
  return all;
}

}  // namespace regulus::stability
