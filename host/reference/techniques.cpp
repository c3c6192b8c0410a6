#include "reference/techniques.hpp"

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

/// connected_ratio of an interior vertex; the ends of a path are never regularized.
double ratio_at(const Path& path, size_t i) {
  return i == 0 || i == path.length() ? 1.0 : path.vertices[i].connected_ratio;
}

/// Connection of x_{s-1} and x_s.
Technique connection(const Path& path, uint32_t kind, size_t s, double samples) {
  return {kind, s, samples * light_walk_pdf(path, s) * camera_walk_pdf(path, s),
          ratio_at(path, s - 1) * ratio_at(path, s)};
}

Technique hit(const Path& path) {
  // No walk arrives at the point of a light that is no surface.
  const bool is_possible = path.light.kind == LIGHT_TRIANGLE;
  return {TECHNIQUE_HIT, 0, is_possible ? camera_walk_pdf(path, 0) : 0, 1};
}

Technique merge(const Path& path, size_t j, const TechniqueSet& set) {
  return {TECHNIQUE_MERGE, j,
          set.light_paths * set.merge_area * light_walk_pdf(path, j + 1) * camera_walk_pdf(path, j),
          ratio_at(path, j)};
}

std::vector<Technique> of_one_edge(const Path& path, const TechniqueSet& set) {
  if ((set.bits & TECHNIQUE_HIT) != 0) return {hit(path)};
  if ((set.bits & TECHNIQUE_SPLAT) != 0) return {connection(path, TECHNIQUE_SPLAT, 1, set.light_paths)};
  return {};
}

}  // namespace

std::vector<Technique> list_techniques(const Path& path, const TechniqueSet& set) {
  const size_t length = path.length();
  std::vector<Technique> all;
  if (length == 1) {
    all = of_one_edge(path, set);
  } else {
    if ((set.bits & TECHNIQUE_HIT) != 0) all.push_back(hit(path));
    if ((set.bits & TECHNIQUE_NEE) != 0) all.push_back(connection(path, TECHNIQUE_NEE, 1, 1));
    if ((set.bits & TECHNIQUE_CONNECT) != 0)
      for (size_t s = 2; s < length; ++s)
        all.push_back(connection(path, TECHNIQUE_CONNECT, s, set.connections));
    if ((set.bits & TECHNIQUE_SPLAT) != 0)
      all.push_back(connection(path, TECHNIQUE_SPLAT, length, set.light_paths));
    if ((set.bits & TECHNIQUE_MERGE) != 0)
      for (size_t j = 1; j < length; ++j) all.push_back(merge(path, j, set));
  }
  std::erase_if(all, [](const Technique& t) { return !(t.density > 0) || t.ratio == 0; });
  return all;
}

const Technique* find_technique(const std::vector<Technique>& techniques, uint32_t kind, size_t vertex) {
  for (const Technique& technique : techniques)
    if (technique.kind == kind && technique.vertex == vertex) return &technique;
  return nullptr;
}

double mis_weight(const std::vector<Technique>& techniques, const Technique& used) {
  const auto measured = [](const Technique& t) { return t.density / static_cast<Wide>(t.ratio); };
  Wide sum = 0;
  for (const Technique& technique : techniques) sum += measured(technique);
  return static_cast<double>(measured(used) / sum);
}

glm::dvec3 unweighted_contribution(const Path& path, const Technique& used) {
  return glm::dvec3(measured_function(path) * (static_cast<Wide>(used.ratio) / used.density));
}

}  // namespace regulus::reference
