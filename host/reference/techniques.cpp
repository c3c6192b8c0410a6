#include "reference/techniques.hpp"

#include <algorithm>
#include <cmath>

namespace regulus::reference {

using namespace interface;

namespace {

/// pt * product of P_i^-> for i = 1 .. count - 1: density of the first `count` vertices of a light walk.
Wide light_walk_pdf(const Path& path, size_t count) {
  Wide pdf = path.light.point_pdf;
  for (size_t i = 1; i < count; ++i) pdf *= static_cast<Wide>(pdf_from_light(path, i));
  return pdf;
}

/// Product of P_i^<- for i = first .. K - 1: density of a camera walk down to x_first.
Wide camera_walk_pdf(const Path& path, size_t first) {
  Wide pdf = 1;
  for (size_t i = first; i < path.length(); ++i) pdf *= static_cast<Wide>(pdf_from_camera(path, i));
  return pdf;
}

/// A path with two sets of pdfs, and which of its vertices can be connected.
struct WeighedPath {
  const Path& path;
  Path weighted;  // with the pdfs of connected_at()
  std::vector<bool> is_possible;
  std::vector<double> ratios;

  explicit WeighedPath(const Path& original)
      : path(original),
        weighted(original),
        is_possible(original.length() + 1, true),
        ratios(original.length() + 1, 1.0) {
    for (size_t i = 1; i < path.length(); ++i) {
      const ConnectedScattering connected = connected_at(path, i);
      weighted.vertices[i].forward = connected.forward;
      weighted.vertices[i].reverse = connected.reverse;
      is_possible[i] = connected.is_possible;
      ratios[i] = connected.ratio;
    }
  }
};

/// A technique whose light walk has `light` vertices and whose camera walk goes down to x_camera.
Technique technique(const WeighedPath& paths, uint32_t kind, size_t vertex, double samples, size_t light,
                    size_t camera) {
  const auto density = [&](const Path& path) {
    const Wide light_pdf = light == 0              ? Wide{1}
                           : kind == TECHNIQUE_NEE ? static_cast<Wide>(path.light.connect_pdf)
                                                   : light_walk_pdf(path, light);
    return static_cast<Wide>(samples) * light_pdf * camera_walk_pdf(path, camera);
  };
  return {kind, vertex, density(paths.path), density(paths.weighted)};
}

/// Connection of x_{s-1} and x_s.
Technique connection(const WeighedPath& paths, uint32_t kind, size_t s, double samples) {
  const bool is_possible = paths.is_possible[s - 1] && paths.is_possible[s];
  return technique(paths, kind, s, is_possible ? samples : 0, s, s);
}

Technique hit(const WeighedPath& paths) {
  // No walk can arrive at a light that is not a surface.
  return technique(paths, TECHNIQUE_HIT, 0, can_be_hit(paths.path.light.kind) ? 1 : 0, 0, 0);
}

Technique merge(const WeighedPath& paths, size_t j, const TechniqueSet& set) {
  const double samples = paths.is_possible[j] ? set.light_paths * set.merge_area : 0;
  return technique(paths, TECHNIQUE_MERGE, j, samples, j + 1, j);
}

/// The unregularized copy of a connection or merge. Its I = f / p is greater than the other's f^ / p by the
/// ratios of the vertices where they differ, in the terms of weights.
Technique plain_copy(const WeighedPath& paths, Technique technique) {
  const size_t s = technique.vertex;
  const double ratio =
      technique.kind == TECHNIQUE_MERGE ? paths.ratios[s] : paths.ratios[s - 1] * paths.ratios[s];
  technique.weight_density *= static_cast<Wide>(ratio);
  technique.is_plain = true;
  return technique;
}

std::vector<Technique> of_one_edge(const WeighedPath& paths, const TechniqueSet& set) {
  if ((set.bits & TECHNIQUE_HIT) != 0) return {hit(paths)};
  if ((set.bits & TECHNIQUE_SPLAT) != 0) return {connection(paths, TECHNIQUE_SPLAT, 1, set.light_paths)};
  return {};
}

}  // namespace

std::vector<Technique> list_techniques(const Path& path, const TechniqueSet& set) {
  const size_t length = path.length();
  const WeighedPath paths(path);
  std::vector<Technique> all;
  if (length == 1) {
    all = of_one_edge(paths, set);
  } else {
    if ((set.bits & TECHNIQUE_HIT) != 0) all.push_back(hit(paths));
    if ((set.bits & TECHNIQUE_NEE) != 0) all.push_back(connection(paths, TECHNIQUE_NEE, 1, 1));
    if ((set.bits & TECHNIQUE_CONNECT) != 0)
      for (size_t s = 2; s < length; ++s)
        all.push_back(connection(paths, TECHNIQUE_CONNECT, s, set.connections));
    if ((set.bits & TECHNIQUE_SPLAT) != 0)
      all.push_back(connection(paths, TECHNIQUE_SPLAT, length, set.light_paths));
    if ((set.bits & TECHNIQUE_MERGE) != 0)
      for (size_t j = 1; j < length; ++j) all.push_back(merge(paths, j, set));
  }
  if (set.is_both && length > 1) {
    const size_t count = all.size();
    for (size_t i = 0; i < count; ++i)
      if (all[i].kind != TECHNIQUE_HIT) all.push_back(plain_copy(paths, all[i]));
  }
  std::erase_if(all, [](const Technique& t) { return !(t.weight_density > 0); });
  return all;
}

double sampler_quality(const Path& path, const TechniqueSet& set) {
  constexpr double MOST = 1e30;
  const size_t length = path.length();
  const auto bound_at = [&](size_t i) {
    return i == 0 ? path.light.bound : i == length ? path.camera_bound : path.vertices[i].bound;
  };
  const auto length_of = [&](size_t i) {
    const bool is_endless =
        (i == 0 && is_distant(path.light.kind)) || (i + 1 == length && path.camera.is_parallel);
    return is_endless ? path.longest_edge : std::min(path.edges[i].distance, path.longest_edge);
  };
  double worst = MOST;
  double whole = 0;
  for (size_t i = 0; i < length; ++i) {
    const double distance = length_of(i);
    whole += distance;
    const uint32_t kind = i == 0 ? TECHNIQUE_NEE : i + 1 == length ? TECHNIQUE_SPLAT : TECHNIQUE_CONNECT;
    if ((set.bits & kind) != 0)
      worst = std::min(worst, bound_at(i) * bound_at(i + 1) / (distance * distance));
  }
  if ((set.bits & TECHNIQUE_MERGE) != 0)
    for (size_t j = 1; j < length; ++j)
      worst = std::min(worst, bound_at(j) / (set.light_paths * set.merge_area));
  return std::min(worst * whole * whole, MOST);
}

double regularized_share(const Path& path, const TechniqueSet& set) {
  if (set.quality == SAMPLER_QUALITY_OFF) return 1;
  const double quality = sampler_quality(path, set);
  if (set.quality == SAMPLER_QUALITY_ON) return quality < set.enough_quality ? 0 : 1;
  constexpr double HALF_WIDTH = 2;  // of the transition, in natural logarithms
  const double excess = std::log(quality / set.enough_quality);
  const double t = std::clamp((excess + HALF_WIDTH) / (2 * HALF_WIDTH), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

const Technique* find_technique(const std::vector<Technique>& techniques, uint32_t kind, size_t vertex) {
  for (const Technique& technique : techniques)
    if (technique.kind == kind && technique.vertex == vertex) return &technique;
  return nullptr;
}

double mis_weight(const std::vector<Technique>& techniques, const Technique& used) {
  Wide sum = 0;
  for (const Technique& technique : techniques) sum += technique.weight_density;
  return static_cast<double>(used.weight_density / sum);
}

glm::dvec3 unweighted_contribution(const Path& path, const Technique& used) {
  // x_{s-1} and x_s of a connection, x_j of a merge; the ends of a path are never regularized.
  const size_t s = used.vertex;
  const bool is_merge = used.kind == TECHNIQUE_MERGE;
  const size_t first = std::max<size_t>(is_merge ? s : s - 1, 1);
  const WideColor f = used.kind == TECHNIQUE_HIT || used.is_plain ? measured_function(path)
                                                                  : measured_function(path, first, s);
  return glm::dvec3(f / used.density);
}

}  // namespace regulus::reference
