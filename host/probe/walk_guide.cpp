#include "probe/walk_guide.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <utility>

#include "probe/guide_tree.hpp"
#include "probe/walk_cells.hpp"
#include "reference/parallel.hpp"
#include "reference/sampling.hpp"
#include "scene/light_power.hpp"

namespace regulus::probe {

using glm::dvec3;
using namespace interface;

namespace {

constexpr uint32_t PATHS_AT_A_TIME = 256;    // that a thread takes at a time
constexpr uint32_t PATHS_OF_A_BATCH = 8192;  // light paths
constexpr size_t ENOUGH_ARRIVALS = 1 << 17;
// A lobe that is chosen more rarely is not guided.
constexpr double LEAST_DIFFUSE = 0.05;
// The guide's bounds reach beyond all visits by these shares: planes at round numbers are then no borders of
// cells, where rounding would decide.
constexpr double BELOW = 0.0237, ABOVE = 0.0311;
constexpr double FLAT = 1e-3;  // of the longest extent: the least one

/// Where something met a surface that scatters diffusely. normal: geometric, on the side of `w`.
struct Met {
  dvec3 position, normal, w;
  double cosine, weight;
  bool is_second;
};

double luminance_of(const dvec3& color) {
  return scene::luminance(color);
}

/// A vertex as the guide sees it, if its diffuse lobe matters.
std::optional<Met> met_at(const reference::WalkVertex& vertex) {
  const dvec3 seen = to_material(vertex.surface, as_seen(vertex.surface, vertex.w_back));
  if (vertex.bsdf.diffuse_probability(seen) < LEAST_DIFFUSE) return std::nullopt;
  const double cosine = dot(vertex.w_back, vertex.surface.geometric_normal);
  return Met{vertex.surface.position,
             cosine < 0 ? -vertex.surface.geometric_normal : vertex.surface.geometric_normal,
             vertex.w_back,
             std::abs(cosine),
             0,
             false};
}

/// In the order of their numbers, what `walk` notes of each.
std::vector<Met> walk_all(uint32_t count, const std::function<void(uint32_t, std::vector<Met>&)>& walk) {
  std::vector<std::vector<Met>> parts((count + PATHS_AT_A_TIME - 1) / PATHS_AT_A_TIME);
  reference::parallel_ranges(count, PATHS_AT_A_TIME, 0, [&](uint32_t begin, uint32_t end) {
    for (uint32_t i = begin; i < end; ++i) walk(i, parts[begin / PATHS_AT_A_TIME]);
  });
  std::vector<Met> all;
  for (const std::vector<Met>& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

std::vector<Met> walk_from_lens(const reference::World& world, const reference::Settings& settings) {
  const reference::Camera camera(
      scene::make_camera(world.scene().cameras.at(settings.camera), settings.width, settings.height),
      settings.width, settings.height);
  const uint32_t pixels = settings.width * settings.height;
  return walk_all(pixels * settings.samples, [&](uint32_t i, std::vector<Met>& found) {
    const reference::CameraSubpath path =
        walk_from_camera(world, camera, settings, i % pixels, settings.first_sample + i / pixels);
    for (size_t k = 0; k < path.vertices.size() && k + 2 <= settings.max_depth; ++k)
      if (const auto met = met_at(path.vertices[k])) found.push_back(*met);
  });
}

/// What is left for a camera walk to find of the light that goes on from the light itself to the first
/// vertex: its weight beside next-event estimation, for a walk that goes by the cosine.
double left_of_direct(const reference::LightSubpath& path, const reference::Settings& settings,
                      double cosine) {
  if (!reference::can_be_hit(path.point.kind) || (settings.techniques & TECHNIQUE_HIT) == 0) return 0;
  if ((settings.techniques & TECHNIQUE_NEE) == 0) return 1;
  const reference::Edge& edge = path.vertices.front().edge;
  double connect = path.end.connect_pdf;
  if (!path.point.is_distant()) connect *= edge.distance * edge.distance / std::max(edge.cos_light_end, 1e-9);
  const double walk = cosine / std::numbers::pi;
  return walk > 0 ? walk / (walk + connect) : 0;
}

/// Mirrors and clear glass lead light from points and parallel light to where no walk finds it, unless
/// regularized next-event estimation does at the glass.
bool is_found(const reference::LightSubpath& path, size_t vertex, const reference::Settings& settings) {
  if (reference::can_be_hit(path.point.kind) || (settings.regularization & REGULARIZATION_ROUGHNESS) != 0)
    return true;
  return !std::ranges::all_of(path.vertices.begin(),
                              path.vertices.begin() + static_cast<std::ptrdiff_t>(vertex),
                              [](const reference::WalkVertex& before) { return before.scattering.is_delta; });
}

std::vector<Met> walk_from_lights(const reference::World& world, const reference::Settings& settings,
                                  uint32_t batch) {
  return walk_all(PATHS_OF_A_BATCH, [&](uint32_t i, std::vector<Met>& found) {
    const reference::LightSubpath path = walk_from_light(world, settings, batch * PATHS_OF_A_BATCH + i, 0);
    for (size_t k = 0; k < path.vertices.size(); ++k) {
      std::optional<Met> met = met_at(path.vertices[k]);
      if (!met || !(met->cosine > 0)) continue;
      met->weight = luminance_of(path.vertices[k].throughput);
      if (k == 0)
        met->weight *= left_of_direct(path, settings, met->cosine);
      else if (!is_found(path, k, settings))
        met->weight = 0;
      met->is_second = i % 2 != 0;
      if (met->weight > 0 && std::isfinite(met->weight)) found.push_back(*met);
    }
  });
}

scene::WalkGuide bounds_of(const std::vector<Met>& visits) {
  dvec3 least = visits.front().position;
  dvec3 most = least;
  for (const Met& visit : visits) {
    least = glm::min(least, visit.position);
    most = glm::max(most, visit.position);
  }
  const dvec3 extent = most - least;
  const double longest = std::max({extent.x, extent.y, extent.z, 1e-6});
  const dvec3 size = glm::max(extent, dvec3(FLAT * longest));
  const dvec3 middle = 0.5 * (least + most);
  const dvec3 corner = middle - (0.5 + BELOW) * size;
  return {{}, glm::vec3(corner), glm::vec3(1.0 / ((1 + BELOW + ABOVE) * size))};
}

/// Where camera walks have been, coarsely: light that arrives elsewhere tells them nothing.
class Visited {
 public:
  void add(const CellKey& key) {
    for (int i = 0; i < 27; ++i) {
      const std::array<int, 3> step{i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
      size_t index = key.sides;
      bool is_inside = true;
      for (size_t axis = 0; axis < 3; ++axis) {
        const int place = (key.place[axis] >> SHIFT) + step[axis];
        is_inside = is_inside && place >= 0 && place < static_cast<int>(SIDE);
        index = index * SIDE + static_cast<size_t>(std::clamp(place, 0, static_cast<int>(SIDE) - 1));
      }
      if (is_inside) cells_[index] = true;
    }
  }

  bool holds(const CellKey& key) const {
    size_t index = key.sides;
    for (const uint16_t place : key.place) index = index * SIDE + (place >> SHIFT);
    return cells_[index];
  }

 private:
  static constexpr size_t SIDE = 64;
  static constexpr uint32_t SHIFT = GUIDE_HALVINGS - 6;
  std::vector<bool> cells_ = std::vector<bool>((SIDE * SIDE * SIDE) << SIDE_BITS);
};

bool is_within(const scene::WalkGuide& bounds, const dvec3& position) {
  const dvec3 place = (position - dvec3(bounds.corner)) * dvec3(bounds.scale);
  return glm::all(glm::greaterThanEqual(place, dvec3(0))) && glm::all(glm::lessThan(place, dvec3(1)));
}

Arrival arrival_of(const scene::WalkGuide& bounds, const Met& met, double mean) {
  constexpr double CELLS = 1u << GUIDE_HALVINGS;
  Arrival arrival;
  arrival.key = cell_key(bounds, met.position, met.normal);
  const glm::dvec2 numbers = reference::sphere_numbers(met.w);
  for (int axis = 0; axis < 2; ++axis)
    arrival.direction[static_cast<size_t>(axis)] =
        static_cast<uint16_t>(std::clamp(numbers[axis] * CELLS, 0.0, CELLS - 1));
  arrival.cosine = static_cast<float>(met.cosine);
  arrival.weight = whole_weight(met.weight, mean);
  arrival.is_second = met.is_second;
  return arrival;
}

}  // namespace

TrainedWalkGuide train_walk_guide(const reference::World& world, const reference::Settings& settings) {
  if (world.scene().lights.empty()) return {};
  const std::vector<Met> visits = walk_from_lens(world, settings);
  if (visits.empty()) return {};
  const scene::WalkGuide bounds = bounds_of(visits);
  Visited visited;
  std::vector<CellKey> keys;
  for (const Met& visit : visits) {
    keys.push_back(cell_key(bounds, visit.position, visit.normal));
    visited.add(keys.back());
  }
  std::vector<Met> light;
  const uint32_t batches = settings.paths_per_iteration() / PATHS_OF_A_BATCH;
  for (uint32_t batch = 0; batch < batches && light.size() < ENOUGH_ARRIVALS; ++batch)
    for (const Met& met : walk_from_lights(world, settings, batch))
      if (is_within(bounds, met.position) && visited.holds(cell_key(bounds, met.position, met.normal)))
        light.push_back(met);
  if (light.empty()) return {};
  double mean = 0;
  for (const Met& met : light) mean += met.weight / static_cast<double>(light.size());
  std::vector<Arrival> arrivals;
  arrivals.reserve(light.size());
  for (const Met& met : light) arrivals.push_back(arrival_of(bounds, met, mean));
  MadeWalkGuide made = make_walk_guide(bounds, std::move(keys), std::move(arrivals));
  return {std::make_shared<scene::WalkGuide>(std::move(made.guide)), made.gain};
}

}  // namespace regulus::probe
