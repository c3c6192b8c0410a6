// What holds connections, merges and splats against the reference. Internal to host/check.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/components.hpp"
#include "check/check.hpp"
#include "check/item_class.hpp"
#include "check/sampled_light.hpp"
#include "check/sorting.hpp"
#include "reference/estimator.hpp"
#include "reference/light_choice.hpp"
#include "reference/parallel.hpp"
#include "reference/rounding.hpp"

namespace regulus::check {

using glm::dvec2;
using glm::dvec3;
using namespace interface;
using render::ConnectionRecording;
using render::RecordedConnections;

inline constexpr double VALUE_BOUND = 1e-4;   // relative
inline constexpr double WEIGHT_BOUND = 1e-5;  // absolute
inline constexpr double NOISE = 1e-6;  // of the mean of all, below which a value says nothing of its weight
// Share of walks that cannot be followed because another lobe was a tie, and of sums that differ because a
// vertex lies on the merge radius or a segment on an edge.
inline constexpr double ALLOWED = 1e-3;
// Pixels: splats as near as this are the same path's.
inline constexpr double SAME_PLACE = 1e-3;
// How far rounding moves the numbers that place a point on a light.
inline constexpr double PLACE_ROUNDINGS = 32 * reference::UNIT_ROUNDOFF;
// Of the sum of four cosines that is a filter's window in one direction.
inline constexpr double WINDOW_ROUNDINGS = 8 * 0x1p-24;
// Of Settings::rounding_pattern. Errors of many roundings are nearly normal: that of all eight one is less
// than a fourth of what the device happens to have is a matter of 3e-6.
inline constexpr uint32_t ROUNDING_PATTERNS = 8;
inline constexpr double CONDITIONING = 4;

/// All walks of an iteration.
struct Iteration {
  std::vector<reference::CameraSubpath> camera;
  reference::LightCache light;
};

/// Something that the device has evaluated, and how to find it in the reference.
struct Item {
  uint32_t technique;
  uint32_t pixel;  // of the camera walk
  size_t camera_edges;
  uint32_t light_path;
  size_t light_edges;
  dvec3 found{0};
  uint32_t light = INVALID_INDEX;  // that the device sampled
};

/// The same by definition. `unweighted` times `weight` is what it contributes.
struct Expected {
  dvec3 unweighted{0};
  double weight = 1;
  bool is_one_path = true;  // false: the sum of several, whose weights cannot be told apart
  dvec3 value() const { return weight * unweighted; }
};

/// Holds an iteration of the device against the definition of its paths. The reference follows the device's
/// walks from surface point to surface point, so that its paths are the device's and only the errors of what
/// is judged remain.
class ConnectionChecker {
 public:
  ConnectionChecker(const Subject& subject, uint32_t sample, const ConnectionRecording& recording)
      : subject_(subject),
        sample_(sample),
        recording_(recording),
        settings_(subject.reference_settings),
        owner_(light_paths_of(recording)) {
    settings_.expected_light_vertices = recording.expected_vertices;
    if (recording.connections == render::Connections::Paired) settings_.cache_connections = 0;
    estimator_ = std::make_unique<reference::Estimator>(subject_.world, subject_.camera, settings_);
    set_ = estimator_->techniques(sample);
    own_vertices_.resize(recording.heads.size());
    for (uint32_t vertex = 0; vertex < owner_.size(); ++vertex)
      if (owner_[vertex] != INVALID_INDEX) own_vertices_[owner_[vertex]].push_back(vertex);
    gather_walks();
    iterations_.push_back(walk(0));
  }

  std::vector<Tally> run();

 private:
  /// Where the device's walks meet surfaces.
  void gather_walks();

  /// How many of them the reference could follow to their end.
  Tally check_walks() const;

  /// The light vertices that the device has stored against those of the reference's cache, by light path and
  /// edges.
  Tally check_stored_vertices() const;

  Iteration walk(uint32_t pattern) const;

  /// True if the reference's walk from that pixel meets the triangle of the device's.
  bool is_same_walk(const RecordedConnections& bounce, uint32_t pixel, uint32_t index) const {
    const auto& vertices = iterations_.front().camera[pixel].vertices;
    return index < vertices.size() &&
           vertices[index].surface.triangle == bounce.camera_vertices[pixel].triangle;
  }

  bool is_same_light_walk(uint32_t vertex) const {
    if (vertex >= owner_.size() || owner_[vertex] == INVALID_INDEX) return false;
    const LightVertex& found = recording_.light_vertices[vertex];
    const auto& vertices = iterations_.front().light.subpaths()[owner_[vertex]].vertices;
    const uint32_t edges = found.edges & PATH_VERTEX_EDGES;
    return edges <= vertices.size() && vertices[edges - 1].surface.triangle == found.triangle;
  }

  // ---- which vertices are connected

  /// The light vertex of a number, by the device's own lists; INVALID_INDEX if these are broken.
  uint32_t numbered(uint32_t number) const;

  /// Those that connections to the cache draw for a camera vertex.
  std::vector<uint32_t> drawn_vertices(uint32_t pixel, uint32_t bounce) const;

  void check_pairs(const RecordedConnections& bounce, uint32_t index, Tally& tally) const;

  /// The pairs with the candidate that each became; none: nothing, which the reference may know better.
  void gather_connections(const RecordedConnections& bounce, uint32_t index, std::vector<Item>& items) const;

  // ---- which light is sampled

  glm::dvec4 light_numbers(uint32_t pixel, size_t bounce) const {
    const auto block = static_cast<uint32_t>(bounce) * DIMENSION_BLOCKS_PER_BOUNCE + DIMENSION_BLOCK_LIGHT;
    return random_block(settings_, pixel, sample_, DIMENSION_BLOCKS_FIRST + block);
  }

  /// The light sample that became a candidate, of the light that the device chose.
  Item light_sample_item(const VisibilityCandidate& candidate, uint32_t bounce, Tally& choices) const;

  // ---- splats

  /// A splat that either side makes of a light path, for as long as it is looked for on the other.
  struct Sought {
    dvec2 film;
    double size = 0;  ///< largest channel of what it carries
    std::string of_class{};
    bool is_matched = false;
  };

  /// Whether a splat that only one side has is a difference: it carries something, and lands where rounding
  /// cannot have moved it off the film.
  bool counts(const Sought& splat, double mean) const {
    const dvec2 film_size(settings_.width, settings_.height);
    const double margin = SAME_PLACE;
    return splat.size > NOISE * mean && splat.film.x > margin && splat.film.y > margin &&
           splat.film.x < film_size.x - margin && splat.film.y < film_size.y - margin;
  }

  /// The reference's splats that the device has too, by their place on the film. What only one has goes to
  /// `on_one_side`: of the device's, those that nothing hides, since the reference has no others.
  std::vector<Item> splats(Tally& on_one_side) const;

  /// Whether something lies between the ends of the splat of this index.
  bool is_hidden(size_t splat) const {
    const VisibilityCandidate& segment = recording_.splats[splat].segment;
    const reference::Ray ray{dvec3(segment.origin), normalize(dvec3(segment.direction)), 0, segment.t_max};
    reference::Place place;
    if (!recording_.splat_media.empty())
      place = {reference::Media(recording_.splat_media[splat].around),
               recording_.splat_media[splat].triangle};
    return subject_.world.meet(ray, place).has_value();
  }

  /// Light samples that carry something by the reference and that the device has not queued.
  void find_missing_light_samples(Tally& on_one_side) const;

  /// Whether the reference's light sample of a camera vertex carries more than `least`, whichever way its
  /// numbers are rounded.
  bool is_always_lit(uint32_t pixel, uint32_t bounce, double least) const;

  /// Every splat that is not occluded, spread over the pixels whose filter reaches it.
  Tally check_splat_film() const;

  // ---- values and weights

  static double relative(const dvec3& found, const dvec3& expected, double floor) {
    const double difference = largest_magnitude(found - expected);
    return difference == 0 ? 0 : difference / std::max(largest_magnitude(expected), floor);
  }

  static void add(const Expected& more, std::optional<Expected>& sum) {
    sum = sum ? Expected{sum->value() + more.value(), 1, false} : more;
  }

  Expected by_definition(const reference::SampledPath& sampled) const {
    std::optional<Expected> result;
    contribute(sampled, set_, [&](const reference::Contribution& found) {
      add({found.unweighted, found.weight}, result);
    });
    return result.value_or(Expected{});
  }

  /// Nothing if the reference finds no such path, for instance because something is in the way.
  std::optional<Expected> expected(const Iteration& iteration, const Item& item) const;

  std::optional<reference::SampledPath> light_sample(const reference::CameraSubpath& camera,
                                                     const Item& item) const {
    if (item.light == INVALID_INDEX) return std::nullopt;
    const glm::dvec4 u = light_numbers(item.pixel, item.camera_edges - 1);
    const reference::World& world = subject_.world;
    return connect_to_light(world, sample_light_point(world, item.light, {u.z, u.w}), camera,
                            item.camera_edges);
  }

  Expected merges(const Iteration& iteration, const reference::CameraSubpath& camera, size_t edges) const;

  /// How far rounding moves what the reference finds: the value relative to itself, and the weight.
  std::pair<double, double> spread(const Item& item, const Expected& exact, double floor);

  /// Lobes at its ends, the medium before them and the kind of its light.
  std::string class_of(const Item& item) const;

  Tally judge(const char* name, const std::vector<Item>& items, Tally& weights);

  /// Resolution of the film.
  double film_unit() const {
    return std::ldexp(1.0, subject_.prepared.scene.film_exponents.radiance - int{FILM_FRACTION_BITS});
  }

  void judge_item(const Item& item, const Expected& wanted, double floor, const char* name, Tally& tally,
                  Tally& weights) {
    const double error = relative(item.found, wanted.value(), floor);
    // Two points of one plane are connected at cosines that are nothing but rounding.
    const double least = std::max(NOISE * floor, item.technique == TECHNIQUE_MERGE ? 1e6 * film_unit() : 0);
    const bool has_weight = wanted.is_one_path && largest_magnitude(wanted.value()) > least;
    const double weight =
        has_weight ? reference::luminance(item.found) / reference::luminance(wanted.unweighted) : 0;
    const double weight_error = has_weight ? std::abs(weight - wanted.weight) : 0;
    std::pair<double, double> excused(0, 0);
    if (!(error <= VALUE_BOUND && weight_error <= WEIGHT_BOUND)) excused = spread(item, wanted, floor);
    const auto words = [&] {
      return fmt::format(
          "{}: pixel {}, {} edges; light path {}, {} edges: ({:.6g} {:.6g} {:.6g}) against ({:.6g} "
          "{:.6g} {:.6g}), weight {:.6g} against {:.6g}, of which rounding explains {:.1e}",
          name, item.pixel, item.camera_edges, item.light_path, item.light_edges, item.found.x, item.found.y,
          item.found.z, wanted.value().x, wanted.value().y, wanted.value().z, weight, wanted.weight,
          CONDITIONING * excused.second);
    };
    const std::string of_class = class_of(item);
    if (!tally.add_error(error, CONDITIONING * excused.first, of_class)) tally.describe(words());
    if (has_weight && !weights.add_error(weight_error, CONDITIONING * excused.second,
                                         fmt::format("{}, {}", name, of_class)))
      weights.describe(words());
  }

  const Subject& subject_;
  uint32_t sample_;
  const ConnectionRecording& recording_;
  reference::Settings settings_;
  std::vector<uint32_t> owner_;                      // light path of each light vertex
  std::vector<std::vector<uint32_t>> own_vertices_;  // and the light vertices of each path
  std::unique_ptr<reference::Estimator> estimator_;
  reference::TechniqueSet set_;
  std::vector<std::vector<reference::GivenHit>> camera_hits_, light_hits_;  // by pixel, by light path
  std::vector<Iteration> iterations_;  // exact, then with patterns of roundings
};

}  // namespace regulus::check
