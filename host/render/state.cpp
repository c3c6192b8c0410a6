#include "render/state.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.hpp"
#include "render/scan.hpp"
#include "render/strategies.hpp"

namespace regulus::render {

using namespace interface;

namespace {

// On a CPU device a small wave stays in cache, and always has the same size. A GPU wants enough paths to fill
// it at the last bounces too.
constexpr uint64_t SOFTWARE_WAVE_PATHS = 1u << 16, HARDWARE_WAVE_PATHS = 1u << 21;

// Before any light path was walked there is room for this many vertices of each.
constexpr uint64_t EXPECTED_VERTICES = 2;

bool has(const Plan& plan, uint32_t techniques) {
  return (plan.techniques & techniques) != 0;
}

uint64_t pairs_per_path(const Plan& plan) {
  return has(plan, TECHNIQUE_CONNECT) ? plan.connections_per_vertex : 0;
}

// Without `hit` the first bounce holds the emitter's own splat, too.
uint64_t splats_per_path(const Plan& plan) {
  if (!has(plan, TECHNIQUE_SPLAT)) return 0;
  return has(plan, TECHNIQUE_HIT) ? 1 : 2;
}

uint64_t light_paths_of(const Plan& plan, uint64_t paths) {
  if (!plan.keeps(STATE_VERTICES)) return 0;
  return plan.is_per_wave ? paths : plan.light_paths;
}

// Number of elements of PER_*.
uint64_t count(uint32_t per, const Plan& plan, const StateSizes& sizes) {
  switch (per) {
    case PER_RENDER:
      return 1;
    case PER_PATH:
      return sizes.paths;
    case PER_CAMERA_VERTEX:
      return plan.keeps(STATE_VERTICES) ? sizes.paths : 0;
    case PER_CANDIDATE:
      return sizes.paths + sizes.pairs;
    case PER_PAIR:
      return sizes.pairs;
    case PER_SPLAT:
      return sizes.paths * splats_per_path(plan);
    case PER_BOUNCE:
      return uint64_t{plan.max_depth} + 1;
    case PER_LIGHT_PATH:
      return light_paths_of(plan, sizes.paths);
    case PER_LIGHT_PATH_SUM:
      return Scan::words_needed(light_paths_of(plan, sizes.paths));
    case PER_LIGHT_VERTEX:
      return sizes.light_vertices;
    case PER_CELL_SUM:
      return Scan::words_needed(sizes.grid_cells + 1);
    case PER_PIXEL:
      return plan.window().pixels();
    case PER_STRATEGY_PIXEL:
      return 2 * list_strategies(plan.techniques, plan.max_depth).size() * plan.window().pixels();
    case PER_STRATEGY_PLACE:
      return strategy_layers(list_strategies(plan.techniques, plan.max_depth), plan.max_depth).size();
    case PER_LAYER_PIXEL:
      return (has(plan, TECHNIQUE_SPLAT) ? 2 : 1) * plan.layers.names.size() * plan.window().pixels();
    case PER_LIGHT:
      return plan.layers.group_of_light.size();
    default:
      throw std::logic_error(fmt::format("state table: there is no PER_ {}", per));
  }
}

bool is_kept(const StateArray& array, const Plan& plan) {
  return array.when == STATE_ALWAYS || plan.keeps(array.when);
}

// The sizes that one path slot adds. What an iteration's light vertices allow fewer pairs is not known before
// they are walked.
StateSizes sizes_of_a_path(const Plan& plan) {
  const uint64_t own = plan.is_per_wave ? expected_light_vertices(plan, 1) : 0;
  return {.paths = 1, .light_vertices = own, .pairs = plan.is_per_wave ? own : pairs_per_path(plan)};
}

// True if the array grows with the number of paths in flight.
bool is_per_path(const StateArray& array, const Plan& plan) {
  switch (array.per) {
    case PER_PATH:
    case PER_CAMERA_VERTEX:
    case PER_CANDIDATE:
    case PER_PAIR:
    case PER_SPLAT:
      return true;
    case PER_LIGHT_PATH:
    case PER_LIGHT_VERTEX:
      return plan.is_per_wave;
    default:
      return false;
  }
}

// True if the array grows with the light vertices; where camera paths connect to their own ones, what holds
// pairs does.
bool is_per_light_vertex(const StateArray& array, const Plan& plan) {
  const bool is_of_pairs = array.per == PER_PAIR || array.per == PER_CANDIDATE;
  return array.per == PER_LIGHT_VERTEX || (is_of_pairs && connects_own_paths(plan));
}

}  // namespace

uint32_t choose_state(const Plan& plan) {
  uint32_t state = STATE_ALWAYS;
  const auto keep = [&](uint32_t bits, bool is_wanted) { state |= is_wanted ? bits : 0; };
  const bool has_light_subpaths = has(plan, LIGHT_SUBPATH_TECHNIQUES);
  const bool has_diffusion = (plan.regularization & REGULARIZATION_DIFFUSION) != 0;
  const bool has_hit = has(plan, TECHNIQUE_HIT), has_nee = has(plan, TECHNIQUE_NEE);
  keep(STATE_VERTICES, has(plan, TECHNIQUE_CONNECT | TECHNIQUE_MERGE));
  keep(STATE_ESCAPES, has_hit && (plan.features.bits & FEATURE_ENVIRONMENT) != 0);
  keep(STATE_RECEIVERS, has_hit && has_nee && plan.light_sampling == LIGHT_SAMPLING_BVH);
  keep(STATE_HISTORIES,
       plan.regularization != REGULARIZATION_NONE &&
           (plan.sampler_quality != SAMPLER_QUALITY_OFF || (plan.regularization & REGULARIZATION_BOTH) != 0));
  keep(STATE_FOOTPRINTS, has_diffusion && !has_light_subpaths);
  keep(STATE_SHARP, has_diffusion && has_light_subpaths);
  keep(STATE_STRATEGIES, plan.has_strategy_images);
  keep(STATE_LAYERS, !plan.layers.names.empty());
  keep(STATE_CANDIDATES, has(plan, TECHNIQUE_NEE | TECHNIQUE_CONNECT));
  keep(STATE_SPLATS, has(plan, TECHNIQUE_SPLAT));
  keep(STATE_CACHE, has(plan, TECHNIQUE_CONNECT) && plan.cache_connections != 0);
  keep(STATE_MERGES, has(plan, TECHNIQUE_MERGE));
  keep(STATE_MEDIA, (plan.features.bits & FEATURE_CONTACTS) != 0);
  keep(STATE_VARYING_STARTS, plan.features.has_varying_starts);
  keep(STATE_SQUARES, (plan.aovs & AOV_VARIANCE) != 0);
  keep(STATE_SURFACES, (plan.aovs & SURFACE_AOVS) != 0);
  keep(STATE_IDS, (plan.aovs & CRYPTO_AOVS) != 0);
  keep(STATE_SIGMA, (plan.aovs & AOV_SIGMA) != 0);
  return state;
}

// At least one edge of a path leads to the camera.
uint64_t vertices_per_path(const Plan& plan) {
  return std::max(plan.max_depth, 2u) - 1;
}

bool connects_own_paths(const Plan& plan) {
  return has(plan, TECHNIQUE_CONNECT) && plan.cache_connections == 0 &&
         plan.light_paths >= uint64_t{plan.width} * plan.height;
}

StateSizes sizes_of(const Plan& plan, uint64_t paths, uint64_t light_vertices) {
  uint64_t pairs = paths * pairs_per_path(plan);
  if (connects_own_paths(plan)) pairs = std::min(pairs, light_vertices);
  return {.paths = paths, .light_vertices = light_vertices, .pairs = pairs};
}

uint64_t expected_light_vertices(const Plan& plan, uint64_t light_paths) {
  return plan.keeps(STATE_VERTICES) ? light_paths * std::min(vertices_per_path(plan), EXPECTED_VERTICES) : 0;
}

uint64_t bytes_of_array(const StateArray& array, const Plan& plan, const StateSizes& sizes) {
  return is_kept(array, plan) ? array.bytes * count(array.per, plan, sizes) : 0;
}

uint64_t bytes_per_path(const Plan& plan) {
  return bytes_per_path(plan, sizes_of_a_path(plan));
}

uint64_t bytes_per_path(const Plan& plan, const StateSizes& sizes) {
  uint64_t bytes = 0;
  for (const StateArray& array : STATE_ARRAYS)
    if (is_per_path(array, plan)) bytes += bytes_of_array(array, plan, sizes);
  return (bytes + sizes.paths - 1) / sizes.paths;
}

uint64_t bytes_per_light_vertex(const Plan& plan) {
  uint64_t bytes = 0;
  for (const StateArray& array : STATE_ARRAYS)
    if (is_per_light_vertex(array, plan))
      bytes += bytes_of_array(array, plan, {.light_vertices = 1, .pairs = 1});
  return bytes;
}

PixelBytes bytes_per_pixel(const Plan& plan) {
  PixelBytes bytes{0, 0};
  for (const StateArray& array : STATE_ARRAYS) {
    if ((array.per != PER_PIXEL && array.per != PER_LAYER_PIXEL) || !is_kept(array, plan)) continue;
    const uint64_t own = array.bytes * (count(array.per, plan, {}) / plan.window().pixels());
    bytes.all += own;
    bytes.largest = std::max(bytes.largest, own);
  }
  return bytes;
}

uint64_t most_paths(const Plan& plan, uint64_t most_groups, uint64_t most_bytes) {
  const StateSizes one = sizes_of_a_path(plan);
  uint64_t items = 1, bytes = 1;
  for (const uint32_t per : {PER_CANDIDATE, PER_PAIR, PER_SPLAT})
    items = std::max(items, count(per, plan, one));
  for (const StateArray& array : STATE_ARRAYS)
    if (is_per_path(array, plan)) bytes = std::max(bytes, bytes_of_array(array, plan, one));
  const uint64_t most_items = std::min<uint64_t>(most_groups * WORKGROUP_SIZE, UINT32_MAX);
  return std::min(most_items / items, most_bytes / bytes);
}

uint64_t most_light_vertices(const Plan& plan, uint64_t paths, uint64_t most_groups, uint64_t most_bytes) {
  uint64_t most = UINT32_MAX;
  for (const StateArray& array : STATE_ARRAYS) {
    if (!is_kept(array, plan) || !is_per_light_vertex(array, plan)) continue;
    uint64_t elements = most_bytes / array.bytes;
    if (array.per != PER_LIGHT_VERTEX) elements = std::min(elements, most_groups * WORKGROUP_SIZE);
    // Candidates hold a light sample of each path, too.
    if (array.per == PER_CANDIDATE) elements -= std::min(elements, paths);
    most = std::min(most, elements);
  }
  return most;
}

uint32_t choose_capacity(const gpu::DeviceInfo& device, uint64_t free_bytes, const Plan& plan,
                         uint64_t total_paths) {
  uint64_t paths = plan.wave_paths;
  if (paths == 0) {
    paths = device.kind == gpu::DeviceKind::Software ? SOFTWARE_WAVE_PATHS : HARDWARE_WAVE_PATHS;
    paths = std::min(paths, free_bytes / 2 / bytes_per_path(plan));
  }
  const auto groups_of = [](uint64_t items) { return (items + WORKGROUP_SIZE - 1) / WORKGROUP_SIZE; };
  const uint64_t most_groups =
      most_paths(plan, device.max_groups, device.max_allocation_bytes) / WORKGROUP_SIZE;
  // A wave is cut where its light paths leave too much; a group of paths is not.
  const uint64_t most_of_group =
      plan.is_per_wave && plan.keeps(STATE_VERTICES) ? WORKGROUP_SIZE * vertices_per_path(plan) : 0;
  if (most_groups == 0 || most_of_group > most_light_vertices(plan, WORKGROUP_SIZE, device.max_groups,
                                                              device.max_allocation_bytes))
    throw Error(
        ErrorCode::Failed,
        fmt::format("device {} runs {} groups at once and allocates {} MiB: too little for {} "
                    "connections of each path; use fewer, or shorter paths",
                    device.name, device.max_groups, device.max_allocation_bytes >> 20, pairs_per_path(plan)));
  const uint64_t groups = std::clamp<uint64_t>(groups_of(std::min(paths, total_paths)), 1, most_groups);
  return static_cast<uint32_t>(groups * WORKGROUP_SIZE);
}

}  // namespace regulus::render
