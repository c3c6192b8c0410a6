// Connections, merges and splats one by one, weights included: what each of the device's carries against the
// path's definition. The reference follows the device's walks from surface point to surface point, so that
// its paths are the device's and only the errors of what is judged here remain.
#include "check/connection_checker.hpp"

namespace regulus::check {

std::vector<Tally> ConnectionChecker::run() {
  Tally pairs("connection pairs", 0);
  Tally choices("choices of a light", 0);
  std::vector<Item> hit, escaped, nee, connected, merged;
  for (uint32_t i = 0; i < recording_.bounces.size(); ++i) {
    const RecordedConnections& bounce = recording_.bounces[i];
    check_pairs(bounce, i, pairs);
    for (const uint32_t slot : bounce.slots) {
      const bool has_left = bounce.hits[slot].triangle == INVALID_INDEX;
      const size_t followed = iterations_.front().camera[slot].vertices.size();
      if (has_left ? followed == i : followed > i)
        (has_left ? escaped : hit).push_back({TECHNIQUE_HIT, slot, i + 1, 0, 0, dvec3(bounce.met[slot])});
      if (!is_same_walk(bounce, slot, i)) continue;
      const dvec3 sum = bounce.merged[slot];
      if (bounce.camera_vertices[slot].edges != 0)
        merged.push_back({TECHNIQUE_MERGE, slot, i + 1, 0, 0, sum});
    }
    for (const VisibilityCandidate& candidate : bounce.light_samples)
      if (is_same_walk(bounce, candidate.receiver, i))
        nee.push_back(light_sample_item(candidate, i, choices));
    gather_connections(bounce, i, connected);
  }
  Tally weights(WEIGHTS, WEIGHT_BOUND, ALLOWED);
  std::vector<Tally> tallies{check_walks(), check_stored_vertices(), pairs, choices};
  tallies.push_back(judge("hit", hit, weights));
  if (!escaped.empty()) tallies.push_back(judge("escape", escaped, weights));
  tallies.push_back(judge("light samples", nee, weights));
  tallies.push_back(judge("connect", connected, weights));
  tallies.push_back(judge("merge", merged, weights));
  Tally on_one_side("found by one side only", 0, ALLOWED);
  tallies.push_back(judge("splats", splats(on_one_side), weights));
  find_missing_light_samples(on_one_side);
  tallies.push_back(on_one_side);
  tallies.push_back(weights);
  tallies.push_back(check_splat_film());
  return tallies;
}

void ConnectionChecker::gather_walks() {
  const auto append = [](const std::vector<Hit>& hits, auto& walks) {
    for (size_t i = 0; i < walks.size(); ++i)
      if (hits[i].triangle != INVALID_INDEX) walks[i].push_back({hits[i].triangle, {hits[i].u, hits[i].v}});
  };
  camera_hits_.resize(size_t{settings_.width} * settings_.height);
  light_hits_.resize(settings_.paths_per_iteration());
  for (const RecordedConnections& bounce : recording_.bounces) append(bounce.hits, camera_hits_);
  for (const std::vector<Hit>& hits : recording_.light_hits) append(hits, light_hits_);
}

Tally ConnectionChecker::check_walks() const {
  Tally tally("walks followed", 0, ALLOWED);
  const auto compare = [&](const char* kind, const auto& walks, const auto& given) {
    for (size_t i = 0; i < walks.size(); ++i) {
      if (walks[i].vertices.size() == given[i].size()) {
        tally.add_error(0);
        continue;
      }
      tally.add_difference(Difference::Real);
      tally.describe(
          fmt::format("{} path {}: {} of {} vertices", kind, i, walks[i].vertices.size(), given[i].size()));
    }
  };
  compare("camera", iterations_.front().camera, camera_hits_);
  compare("light", iterations_.front().light.subpaths(), light_hits_);
  return tally;
}

Iteration ConnectionChecker::walk(uint32_t pattern) const {
  reference::Settings settings = settings_;
  settings.rounding_pattern = pattern;
  std::vector<reference::CameraSubpath> camera(size_t{settings.width} * settings.height);
  std::vector<reference::LightSubpath> light(settings.paths_per_iteration());
  reference::parallel_ranges(static_cast<uint32_t>(camera.size()), 256, 0, [&](uint32_t begin, uint32_t end) {
    for (uint32_t i = begin; i < end; ++i)
      camera[i] = walk_from_camera(subject_.world, subject_.camera, settings, i, sample_, &camera_hits_[i]);
  });
  reference::parallel_ranges(static_cast<uint32_t>(light.size()), 256, 0, [&](uint32_t begin, uint32_t end) {
    for (uint32_t i = begin; i < end; ++i)
      light[i] = walk_from_light(subject_.world, settings, i, sample_, &light_hits_[i]);
  });
  return {std::move(camera), estimator_->light_cache(std::move(light), sample_)};
}

uint32_t ConnectionChecker::numbered(uint32_t number) const {
  const auto after = std::upper_bound(recording_.path_ends.begin(), recording_.path_ends.end(), number);
  if (after == recording_.path_ends.begin()) return INVALID_INDEX;
  const auto path = static_cast<size_t>(after - recording_.path_ends.begin()) - 1;
  uint32_t vertex = recording_.heads[path].last;
  for (uint32_t k = recording_.path_ends[path]; k < number && vertex < recording_.light_vertices.size(); ++k)
    vertex = recording_.light_vertices[vertex].previous;
  return vertex < recording_.light_vertices.size() ? vertex : INVALID_INDEX;
}

std::vector<uint32_t> ConnectionChecker::drawn_vertices(uint32_t pixel, uint32_t bounce) const {
  const auto cached = static_cast<uint32_t>(recording_.light_vertices.size());
  std::vector<uint32_t> drawn;
  for (uint32_t k = 0; cached > 0 && k < settings_.cache_connections; ++k) {
    const uint32_t block = DIMENSION_BLOCK_CACHE + bounce * 256 + k / 4;
    const double u = random_block(settings_, pixel, sample_, block)[static_cast<int>(k % 4)];
    const auto number = static_cast<uint32_t>(static_cast<float>(u) * static_cast<float>(cached));
    const uint32_t vertex = numbered(std::min(number, cached - 1));
    if (vertex != INVALID_INDEX) drawn.push_back(vertex);
  }
  return drawn;
}

void ConnectionChecker::check_pairs(const RecordedConnections& bounce, uint32_t index, Tally& tally) const {
  std::vector<std::vector<uint32_t>> found(bounce.camera_vertices.size()), wanted(found.size());
  for (const ConnectionPair& pair : bounce.pairs) found[pair.slot].push_back(pair.vertex);
  for (const uint32_t slot : bounce.slots) {
    if (bounce.camera_vertices[slot].edges == 0 || !is_same_walk(bounce, slot, index)) continue;
    for (const uint32_t vertex :
         settings_.cache_connections == 0 ? own_vertices_[slot] : drawn_vertices(slot, index)) {
      const uint32_t edges = recording_.light_vertices[vertex].edges & PATH_VERTEX_EDGES;
      if (index + 1 + edges + 1 <= settings_.max_depth) wanted[slot].push_back(vertex);
    }
    std::sort(found[slot].begin(), found[slot].end());
    std::sort(wanted[slot].begin(), wanted[slot].end());
    if (found[slot] == wanted[slot]) {
      tally.add_error(0);
      continue;
    }
    tally.add_difference(Difference::Real);
    tally.describe(fmt::format("pixel {} vertex {}: {} pairs against {}", slot, index + 1, found[slot].size(),
                               wanted[slot].size()));
  }
}

void ConnectionChecker::gather_connections(const RecordedConnections& bounce, uint32_t index,
                                           std::vector<Item>& items) const {
  std::vector<std::vector<uint32_t>> paired(bounce.camera_vertices.size());  // light vertices
  for (const ConnectionPair& pair : bounce.pairs) paired[pair.slot].push_back(pair.vertex);
  // A candidate tells of its light vertex only where it lies. Of those that its camera vertex is paired with
  // it is the nearest, for light paths that a guide leads may all arrive within a hair's breadth of the
  // scene's size.
  std::map<std::pair<uint32_t, uint32_t>, dvec3> contributions;  // by camera vertex and light vertex
  for (const VisibilityCandidate& candidate : bounce.connections) {
    const dvec3 end = dvec3(candidate.origin) + double{candidate.t_max} * dvec3(candidate.direction);
    double nearest = 1e-3 * subject_.world.radius();
    uint32_t vertex = INVALID_INDEX;
    for (const uint32_t other : paired[candidate.receiver]) {
      const double distance = length(end - dvec3(recording_.light_vertices[other].position));
      if (distance < nearest) {
        nearest = distance;
        vertex = other;
      }
    }
    if (vertex != INVALID_INDEX) contributions[{candidate.receiver, vertex}] = dvec3(candidate.contribution);
  }
  for (const ConnectionPair& pair : bounce.pairs) {
    if (!is_same_walk(bounce, pair.slot, index) || !is_same_light_walk(pair.vertex)) continue;
    Item item{TECHNIQUE_CONNECT, pair.slot, index + 1, owner_[pair.vertex],
              recording_.light_vertices[pair.vertex].edges & PATH_VERTEX_EDGES};
    const auto found = contributions.find({pair.slot, pair.vertex});
    if (found != contributions.end()) item.found = found->second;
    items.push_back(item);
  }
}

Item ConnectionChecker::light_sample_item(const VisibilityCandidate& candidate, uint32_t bounce,
                                          Tally& choices) const {
  const uint32_t pixel = candidate.receiver;
  const reference::WalkVertex& vertex = iterations_.front().camera[pixel].vertices[bounce];
  const SampledLight sampled =
      sampled_light(subject_.world, receiver_at(subject_.world, vertex.surface, vertex.w_back),
                    light_numbers(pixel, bounce), candidate);
  switch (sampled.choice) {
    case LightChoice::Same:
      choices.add_error(0);
      break;
    case LightChoice::Tie:
      choices.add_difference(Difference::Tie);
      break;
    case LightChoice::Unexplained:
      choices.add_difference(Difference::Real);
      choices.describe(
          fmt::format("pixel {}, {} edges: no light that can be chosen lies there", pixel, bounce + 1));
  }
  return {TECHNIQUE_NEE, pixel, bounce + 1, 0, 0, dvec3(candidate.contribution), sampled.light};
}

std::optional<Expected> ConnectionChecker::expected(const Iteration& iteration, const Item& item) const {
  const auto& subpaths = iteration.light.subpaths();
  if (item.technique == TECHNIQUE_SPLAT) {
    std::optional<Expected> result;
    estimator_->light_sample(subpaths[item.light_path], item.light_path, sample_,
                             [&](const reference::Contribution& found) {
                               if (found.sampled.vertex == item.light_edges + 1)
                                 add({found.unweighted, found.weight}, result);
                             });
    return result;
  }
  const reference::CameraSubpath& camera = iteration.camera[item.pixel];
  if (item.technique == TECHNIQUE_HIT) {
    const auto met = item.camera_edges <= camera.vertices.size()
                         ? hit_light(subject_.world, camera, item.camera_edges)
                         : hit_environment(subject_.world, camera);
    return met ? by_definition(*met) : Expected{};
  }
  if (item.camera_edges > camera.vertices.size()) return std::nullopt;
  if (item.technique == TECHNIQUE_MERGE) return merges(iteration, camera, item.camera_edges);
  std::optional<reference::SampledPath> sampled;
  double scale = 1;
  if (item.technique == TECHNIQUE_NEE) {
    sampled = light_sample(camera, item);
  } else {
    const reference::LightSubpath& light = subpaths[item.light_path];
    if (item.light_edges > light.vertices.size()) return std::nullopt;
    sampled = connect_vertices(subject_.world, light, item.light_edges, camera, item.camera_edges);
    if (settings_.cache_connections != 0)
      scale = static_cast<double>(recording_.light_vertices.size()) / recording_.expected_vertices;
  }
  if (!sampled) return std::nullopt;
  Expected result = by_definition(*sampled);
  result.unweighted *= scale;
  return result;
}

Expected ConnectionChecker::merges(const Iteration& iteration, const reference::CameraSubpath& camera,
                                   size_t edges) const {
  std::vector<Expected> all;
  for (const auto [path, m] : iteration.light.near(camera.vertices[edges - 1].surface.position)) {
    if (edges + m > settings_.max_depth) continue;
    const auto sampled = merge_vertices(iteration.light.subpaths()[path], m, camera, edges);
    if (sampled) all.push_back(by_definition(*sampled));
  }
  if (all.size() == 1) return all.front();
  Expected sum{dvec3(0), 1, false};
  for (const Expected& one : all) sum.unweighted += one.value();
  return sum;
}

std::pair<double, double> ConnectionChecker::spread(const Item& item, const Expected& exact, double floor) {
  for (auto pattern = static_cast<uint32_t>(iterations_.size()); pattern <= ROUNDING_PATTERNS; ++pattern)
    iterations_.push_back(walk(pattern));
  double of_value = 0;
  double of_weight = 0;
  for (uint32_t pattern = 1; pattern <= ROUNDING_PATTERNS; ++pattern) {
    const std::optional<Expected> moved = expected(iterations_[pattern], item);
    const Expected other = moved.value_or(Expected{dvec3(0), 0});
    of_value = std::max(of_value, relative(other.value(), exact.value(), floor));
    of_weight = std::max(of_weight, std::abs(other.weight - exact.weight) +
                                        exact.weight * relative(other.unweighted, exact.unweighted, 0));
  }
  return {of_value, of_weight};
}

std::string ConnectionChecker::class_of(const Item& item) const {
  const Iteration& iteration = iterations_.front();
  const auto at = [](const auto& walk, size_t edges) {
    return edges >= 1 && edges <= walk.vertices.size() ? vertex_class(walk.vertices[edges - 1]) : "end";
  };
  const auto& lights = subject_.prepared.scene.lights;
  if (item.technique == TECHNIQUE_SPLAT || item.technique == TECHNIQUE_CONNECT) {
    const reference::LightSubpath& light = iteration.light.subpaths()[item.light_path];
    const std::string text = at(light, item.light_edges) + ", " + light_class(light.point.kind);
    return item.technique == TECHNIQUE_SPLAT
               ? text
               : at(iteration.camera[item.pixel], item.camera_edges) + ", " + text;
  }
  const reference::CameraSubpath& camera = iteration.camera[item.pixel];
  if (item.technique == TECHNIQUE_HIT) return at(camera, item.camera_edges - 1);
  const std::string text = at(camera, item.camera_edges);
  return item.light == INVALID_INDEX ? text : text + ", " + light_class(lights[item.light].kind);
}

Tally ConnectionChecker::judge(const char* name, const std::vector<Item>& items, Tally& weights) {
  Tally tally(name, VALUE_BOUND, ALLOWED);
  std::vector<std::optional<Expected>> exact;
  double mean = 0;
  for (const Item& item : items) {
    exact.push_back(expected(iterations_.front(), item));
    if (exact.back()) mean += largest_magnitude(exact.back()->value()) / static_cast<double>(items.size());
  }
  const double floor = 0.01 * mean;
  for (size_t i = 0; i < items.size(); ++i)
    if (exact[i]) judge_item(items[i], *exact[i], floor, name, tally, weights);
  return tally;
}

std::vector<Tally> check_connections(const Subject& subject, uint32_t sample,
                                     const ConnectionRecording& recording) {
  return ConnectionChecker(subject, sample, recording).run();
}

}  // namespace regulus::check
