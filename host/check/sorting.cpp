#include "check/sorting.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

namespace regulus::check {

using namespace interface;
using render::ConnectionRecording;

namespace {

void judge(bool is_right, Tally& tally, const std::string& words) {
  if (is_right) {
    tally.add_error(0);
    return;
  }
  tally.add_difference(Difference::Real);
  tally.describe(words);
}

Tally check_counts(const ConnectionRecording& recording) {
  Tally tally("light_path_counts", 0);
  const std::vector<uint32_t> owner = light_paths_of(recording);
  std::vector<uint32_t> counted(recording.heads.size(), 0);
  for (const uint32_t path : owner)
    if (path != INVALID_INDEX) ++counted[path];
  for (size_t i = 0; i < counted.size(); ++i)
    judge(counted[i] == recording.path_counts[i], tally,
          fmt::format("light path {}: {} against {} vertices", i, recording.path_counts[i], counted[i]));
  for (size_t v = 0; v < owner.size(); ++v)
    judge(owner[v] != INVALID_INDEX, tally, fmt::format("light vertex {} is on no path's list", v));
  return tally;
}

Tally check_scan(const char* name, const std::vector<uint32_t>& counts, const std::vector<uint32_t>& ends) {
  Tally tally(name, 0);
  uint32_t sum = 0;
  for (size_t i = 0; i < counts.size(); ++i) {
    judge(ends[i] == sum, tally, fmt::format("word {}: {} against {}", i, ends[i], sum));
    sum += counts[i];
  }
  return tally;
}

/// Every cell has as many vertices as were counted, and they took its places one each.
Tally check_grid_count(const ConnectionRecording& recording, const std::vector<uint32_t>& cell_of) {
  Tally tally("grid_count", 0);
  std::vector<std::vector<bool>> taken(recording.cell_counts.size());
  for (size_t c = 0; c < taken.size(); ++c) taken[c].resize(recording.cell_counts[c], false);
  for (size_t v = 0; v < cell_of.size(); ++v) {
    const uint32_t rank = recording.ranks[v];
    const bool is_free =
        cell_of[v] != INVALID_INDEX && rank < taken[cell_of[v]].size() && !taken[cell_of[v]][rank];
    judge(is_free, tally, fmt::format("light vertex {}: cell {}, place {}", v, cell_of[v], rank));
    if (is_free) taken[cell_of[v]][rank] = true;
  }
  return tally;
}

/// Each vertex stands once in the grid, at its place in a cell, and those of one cube in one cell.
Tally check_grid_scatter(const Subject& subject, const ConnectionRecording& recording,
                         std::vector<uint32_t>& cell_of) {
  Tally tally("grid_scatter", 0);
  cell_of.assign(recording.light_vertices.size(), INVALID_INDEX);
  std::map<std::array<int64_t, 3>, uint32_t> cells;
  for (uint32_t place = 0; place < recording.entries.size(); ++place) {
    const GridEntry& entry = recording.entries[place];
    const auto after = std::upper_bound(recording.cell_ends.begin(), recording.cell_ends.end(), place);
    const auto cell = static_cast<uint32_t>(after - recording.cell_ends.begin()) - 1;
    const bool is_new =
        cell != INVALID_INDEX && entry.vertex < cell_of.size() && cell_of[entry.vertex] == INVALID_INDEX;
    judge(is_new && entry.position == recording.light_vertices[entry.vertex].position, tally,
          fmt::format("place {}: light vertex {}", place, entry.vertex));
    if (!is_new) continue;
    cell_of[entry.vertex] = cell;
    const glm::dvec3 cubes =
        (glm::dvec3(entry.position) - subject.world.center()) / (2.0 * recording.merge_radius);
    const glm::dvec3 cube = glm::floor(cubes);
    const glm::dvec3 middle = glm::abs(cubes - cube - 0.5);
    if (std::max({middle.x, middle.y, middle.z}) > 0.499) continue;  // single precision may see the next cube
    const auto [found, is_first] = cells.try_emplace(
        {static_cast<int64_t>(cube.x), static_cast<int64_t>(cube.y), static_cast<int64_t>(cube.z)}, cell);
    judge(is_first || found->second == cell, tally,
          fmt::format("light vertex {}: cell {} against {}", entry.vertex, cell, found->second));
  }
  for (size_t v = 0; v < cell_of.size(); ++v)
    judge(cell_of[v] != INVALID_INDEX, tally, fmt::format("light vertex {} is not in the grid", v));
  return tally;
}

}  // namespace

std::vector<uint32_t> light_paths_of(const ConnectionRecording& recording) {
  const std::vector<LightVertex>& vertices = recording.light_vertices;
  std::vector<uint32_t> owner(vertices.size(), INVALID_INDEX);
  for (uint32_t path = 0; path < recording.heads.size(); ++path) {
    uint32_t v = recording.heads[path].last;
    while (v < vertices.size() && owner[v] == INVALID_INDEX) {
      owner[v] = path;
      v = vertices[v].previous;
    }
  }
  return owner;
}

std::vector<Tally> check_sorting(const Subject& subject, const ConnectionRecording& recording) {
  std::vector<uint32_t> cell_of;
  const Tally scatter = check_grid_scatter(subject, recording, cell_of);
  return {check_counts(recording), check_scan("scan_light_paths", recording.path_counts, recording.path_ends),
          check_grid_count(recording, cell_of),
          check_scan("scan_grid", recording.cell_counts, recording.cell_ends), scatter};
}

}  // namespace regulus::check
