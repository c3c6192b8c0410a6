// What one side of an iteration has and the other should: light vertices, splats, light samples.
#include "check/connection_checker.hpp"

namespace regulus::check {

Tally ConnectionChecker::check_stored_vertices() const {
  using Vertex = std::pair<uint32_t, size_t>;
  std::set<Vertex> stored, wanted;
  for (uint32_t i = 0; i < recording_.light_vertices.size(); ++i)
    stored.emplace(i < owner_.size() ? owner_[i] : INVALID_INDEX,
                   recording_.light_vertices[i].edges & PATH_VERTEX_EDGES);
  const reference::LightCache& cache = iterations_.front().light;
  for (uint32_t i = 0; i < cache.size(); ++i)
    wanted.emplace(cache.numbered(i).subpath, cache.numbered(i).edges);
  Tally tally("light vertices stored", 0);
  const auto compare = [&](const std::set<Vertex>& some, const std::set<Vertex>& others, const char* who) {
    for (const auto& [path, edges] : some) {
      const bool is_followed =
          path < light_hits_.size() && cache.subpaths()[path].vertices.size() == light_hits_[path].size();
      if (!is_followed) continue;
      if (others.contains({path, edges})) {
        tally.add_error(0);
        continue;
      }
      tally.add_difference(Difference::Real);
      tally.describe(fmt::format("light path {}, {} edges: stored by {} alone", path, edges, who));
    }
  };
  compare(stored, wanted, "the device");
  compare(wanted, stored, "the reference");
  return tally;
}

std::vector<Item> ConnectionChecker::splats(Tally& on_one_side) const {
  std::vector<Item> items;
  if ((set_.bits & TECHNIQUE_SPLAT) == 0) return items;
  std::vector<Sought> ours;
  std::vector<uint32_t> by_x;
  for (uint32_t i = 0; i < recording_.splats.size(); ++i) {
    ours.push_back({dvec2(recording_.splats[i].film),
                    largest_magnitude(dvec3(recording_.splats[i].segment.contribution))});
    by_x.push_back(i);
  }
  std::ranges::sort(by_x, {}, [&](uint32_t i) { return ours[i].film.x; });
  std::vector<std::pair<Sought, std::string>> theirs;
  const auto splat_class = [](const reference::WalkVertex& vertex) {
    return "splat, " + vertex_class(vertex);
  };
  const auto& subpaths = iterations_.front().light.subpaths();
  for (uint32_t path = 0; path < subpaths.size(); ++path)
    estimator_->light_sample(subpaths[path], path, sample_, [&](const reference::Contribution& found) {
      const dvec2 film = found.sampled.film;
      const size_t edges = found.sampled.vertex - 1;
      const auto& vertices = subpaths[path].vertices;
      const std::string of_class =
          edges == 0 || edges > vertices.size() ? "" : splat_class(vertices[edges - 1]);
      std::optional<uint32_t> best;
      double nearest = SAME_PLACE;
      const auto first =
          std::ranges::lower_bound(by_x, film.x - SAME_PLACE, {}, [&](uint32_t i) { return ours[i].film.x; });
      for (auto at = first; at != by_x.end() && ours[*at].film.x < film.x + SAME_PLACE; ++at) {
        const double distance = length(ours[*at].film - film);
        if (distance >= nearest) continue;
        nearest = distance;
        best = *at;
      }
      if (!best) {
        theirs.emplace_back(
            Sought{film, largest_magnitude(found.unweighted * found.weight), of_class},
            fmt::format("splat of light path {}, {} edges, at ({:.3f} {:.3f}): the reference alone", path,
                        edges, film.x, film.y));
        return;
      }
      ours[*best].is_matched = true;
      ours[*best].of_class = of_class;
      // Of both copies of a technique there is one splat.
      if (!items.empty() && items.back().light_path == path && items.back().light_edges == edges) return;
      items.push_back(
          {TECHNIQUE_SPLAT, 0, 0, path, edges, dvec3(recording_.splats[*best].segment.contribution)});
    });
  double mean = 0;
  for (const Sought& splat : ours) mean += splat.size / static_cast<double>(ours.size());
  for (uint32_t i = 0; i < ours.size(); ++i) {
    if (ours[i].is_matched)
      on_one_side.add_error(0, 0, ours[i].of_class);
    else if (counts(ours[i], mean) && !is_hidden(i)) {
      on_one_side.add_difference(Difference::Real);
      on_one_side.describe(
          fmt::format("splat at ({:.3f} {:.3f}): the device alone", ours[i].film.x, ours[i].film.y));
    }
  }
  for (const auto& [splat, words] : theirs) {
    if (!counts(splat, mean)) continue;
    on_one_side.add_difference(Difference::Real, splat.of_class);
    on_one_side.describe(words);
  }
  return items;
}

void ConnectionChecker::find_missing_light_samples(Tally& on_one_side) const {
  if ((set_.bits & TECHNIQUE_NEE) == 0 || subject_.prepared.scene.lights.empty()) return;
  for (uint32_t i = 0; i < recording_.bounces.size() && i + 2 <= settings_.max_depth; ++i) {
    const RecordedConnections& bounce = recording_.bounces[i];
    std::vector<bool> has_sample(bounce.camera_vertices.size(), false);
    double mean = 0;
    for (const VisibilityCandidate& candidate : bounce.light_samples) {
      has_sample[candidate.receiver] = true;
      mean +=
          largest_magnitude(dvec3(candidate.contribution)) / static_cast<double>(bounce.light_samples.size());
    }
    for (const uint32_t slot : bounce.slots) {
      const auto& vertices = iterations_.front().camera[slot].vertices;
      const std::string of_class = i < vertices.size() ? "light sample, " + vertex_class(vertices[i]) : "";
      if (has_sample[slot]) {
        on_one_side.add_error(0, 0, of_class);
        continue;
      }
      if (!is_same_walk(bounce, slot, i) || !is_always_lit(slot, i, NOISE * mean)) continue;
      on_one_side.add_difference(Difference::Real, of_class);
      on_one_side.describe(
          fmt::format("pixel {}, {} edges: a light sample of the reference alone", slot, i + 1));
    }
  }
}

bool ConnectionChecker::is_always_lit(uint32_t pixel, uint32_t bounce, double least) const {
  const reference::CameraSubpath& camera = iterations_.front().camera[pixel];
  const reference::WalkVertex& vertex = camera.vertices[bounce];
  const glm::dvec4 u = light_numbers(pixel, bounce);
  const std::optional<uint32_t> light =
      choose_light(subject_.world, receiver_at(subject_.world, vertex.surface, vertex.w_back), {u.x, u.y});
  if (!light) return false;
  for (const dvec2& moved : {dvec2(0), dvec2(PLACE_ROUNDINGS), dvec2(-PLACE_ROUNDINGS)}) {
    const dvec2 at = glm::clamp(dvec2(u.z, u.w) + moved, 0.0, 1 - reference::UNIT_ROUNDOFF);
    const auto sampled =
        connect_to_light(subject_.world, sample_light_point(subject_.world, *light, at), camera, bounce + 1);
    if (!sampled || !(largest_magnitude(by_definition(*sampled).value()) > least)) return false;
  }
  return true;
}

Tally ConnectionChecker::check_splat_film() const {
  Tally tally("trace_splats", VALUE_BOUND, ALLOWED);
  if (recording_.splat_film.empty()) return tally;
  std::vector<dvec3> expected(recording_.splat_film.size(), dvec3(0));
  std::vector<double> rounding(expected.size(), 0);
  const reference::Filter& filter = settings_.filter;
  for (size_t i = 0; i < recording_.splats.size(); ++i) {
    if (is_hidden(i)) continue;
    const SplatCandidate& splat = recording_.splats[i];
    const VisibilityCandidate& segment = splat.segment;
    const dvec2 film(splat.film);
    const auto reach = static_cast<int>(std::ceil(filter.radius)) + 1;
    const glm::ivec2 at(glm::floor(film));
    for (int y = std::max(at.y - reach, 0);
         y < std::min<int>(at.y + reach + 1, static_cast<int>(settings_.height)); ++y)
      for (int x = std::max(at.x - reach, 0);
           x < std::min<int>(at.x + reach + 1, static_cast<int>(settings_.width)); ++x) {
        const size_t pixel = static_cast<size_t>(y) * settings_.width + static_cast<size_t>(x);
        const dvec2 offset = film - dvec2(x + 0.5, y + 0.5);
        expected[pixel] += filter.value(offset) * dvec3(segment.contribution);
        // A window is a sum of cosines: towards its rim they cancel, to roundings of its peak.
        if (filter.value(offset) > 0)
          rounding[pixel] += WINDOW_ROUNDINGS * largest_magnitude(dvec3(segment.contribution)) *
                             (filter.value({offset.x, 0}) + filter.value({0, offset.y}));
      }
  }
  double mean = 0;
  for (const dvec3& value : expected) mean += largest_magnitude(value) / static_cast<double>(expected.size());
  for (size_t i = 0; i < expected.size(); ++i) {
    const double excused =
        rounding[i] > 0 ? rounding[i] / std::max(largest_magnitude(expected[i]), 0.01 * mean) : 0;
    const dvec3& found = recording_.splat_film[i];
    if (!tally.add_error(relative(found, expected[i], 0.01 * mean), excused))
      tally.describe(fmt::format("pixel {}: ({:.6g} {:.6g} {:.6g}) against ({:.6g} {:.6g} {:.6g})", i,
                                 found.x, found.y, found.z, expected[i].x, expected[i].y, expected[i].z));
  }
  return tally;
}

}  // namespace regulus::check
