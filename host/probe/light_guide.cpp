#include "probe/light_guide.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "probe/guide_tree.hpp"
#include "reference/light_choice.hpp"
#include "reference/light_guide.hpp"
#include "reference/parallel.hpp"
#include "scene/light_power.hpp"

namespace regulus::probe {

using glm::dvec3;
using namespace interface;

namespace {

constexpr uint32_t PIXELS_AT_A_TIME = 64;  // pixels that a thread takes at a time

/// A deposit before the mean is known.
struct Found {
  uint32_t light;
  glm::dvec4 numbers;
  double weight;
};

bool transmits(const reference::World& world, const reference::Surface& surface) {
  return world.scene().materials[surface.material].material_class == MATERIAL_CLASS_TRANSMISSIVE;
}

class Trainer {
 public:
  Trainer(const reference::World& world, const reference::Settings& settings)
      : world_(world),
        settings_(settings),
        camera_(
            scene::make_camera(world.scene().cameras.at(settings.camera), settings.width, settings.height),
            settings.width, settings.height) {}

  /// What the camera paths of one sample of every pixel find.
  std::vector<Found> find(uint32_t sample) const {
    const uint32_t pixels = settings_.width * settings_.height;
    std::vector<std::vector<Found>> parts((pixels + PIXELS_AT_A_TIME - 1) / PIXELS_AT_A_TIME);
    reference::parallel_ranges(pixels, PIXELS_AT_A_TIME, 0, [&](uint32_t begin, uint32_t end) {
      for (uint32_t pixel = begin; pixel < end; ++pixel)
        follow(pixel, sample, parts[begin / PIXELS_AT_A_TIME]);
    });
    std::vector<Found> all;
    for (const std::vector<Found>& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
  }

 private:
  void follow(uint32_t pixel, uint32_t sample, std::vector<Found>& found) const {
    const reference::CameraSubpath path = walk_from_camera(world_, camera_, settings_, pixel, sample);
    bool has_diffused = false;
    for (size_t i = 0; i < path.vertices.size(); ++i) {
      const reference::WalkVertex& vertex = path.vertices[i];
      if (i + 2 <= settings_.max_depth) look_for_light(pixel, sample, i, vertex, found);
      // Light that mirrors and clear glass lead to something else, which no light sample meets.
      const bool is_led = i > 0 && path.vertices[i - 1].scattering.is_delta;
      if (is_led && has_diffused)
        if (const auto point = reference::light_point_at(vertex.surface))
          note(*point, vertex.w_back, vertex.surface.position, luminance_of(vertex.throughput), found);
      has_diffused = has_diffused || !vertex.scattering.is_delta;
    }
    if (!path.escape || path.vertices.empty() || !has_diffused) return;
    const reference::WalkVertex& last = path.vertices.back();
    if (!last.scattering.is_delta) return;
    if (const auto point = reference::environment_point(world_, path.escape->direction))
      note(*point, -path.escape->direction, last.surface.position, luminance_of(last.throughput), found);
  }

  static double luminance_of(const dvec3& color) { return scene::luminance(color); }

  void note(const reference::LightPoint& point, const dvec3& direction, const dvec3& at, double importance,
            std::vector<Found>& found) const {
    const double weight = importance * luminance_of(emitted(world_, point, direction));
    if (!(weight > 0) || !std::isfinite(weight)) return;
    found.push_back({point.light, start_numbers(world_, point, direction, at), weight});
  }

  /// A light sample as if the surface were white and diffuse, whatever it is: what arrives at glass goes on.
  void look_for_light(uint32_t pixel, uint32_t sample, size_t bounce, const reference::WalkVertex& vertex,
                      std::vector<Found>& found) const {
    const uint32_t block = DIMENSION_BLOCKS_FIRST +
                           static_cast<uint32_t>(bounce) * DIMENSION_BLOCKS_PER_BOUNCE +
                           DIMENSION_BLOCK_LIGHT;
    const glm::dvec4 u = random_block(settings_, pixel, sample, block);
    const reference::Surface& surface = vertex.surface;
    const std::optional<uint32_t> light =
        choose_light(world_, receiver_at(world_, surface, vertex.w_back), {u.x, u.y});
    if (!light) return;
    const reference::LightPoint point = sample_light_point(world_, *light, {u.z, u.w});
    const dvec3 way = point.is_distant() ? point.direction : point.surface.position - surface.position;
    const double distance = point.is_distant() ? 1 : length(way);
    const dvec3 w = way / distance;
    const double cosine = dot(w, surface.geometric_normal);
    if (cosine * dot(vertex.w_back, surface.geometric_normal) <= 0 && !transmits(world_, surface)) return;
    double factor = std::abs(cosine) / (std::numbers::pi * distance * distance);
    if (point.is_triangle()) factor *= std::abs(dot(w, point.surface.geometric_normal));
    factor *= range_share(world_, point, distance);
    factor /= connection_pdf(world_, point, surface, vertex.w_back);
    if (!(factor > 0)) return;
    const reference::Place place = world_.place_towards(surface, vertex.around, vertex.w_back, w);
    if (!(point.is_distant()
              ? world_.is_open(surface, place, w)
              : world_.is_visible(surface, place, point.surface.position, point.surface.triangle)))
      return;
    note(point, -w, surface.position, factor * luminance_of(vertex.throughput), found);
  }

  const reference::World& world_;
  const reference::Settings& settings_;
  reference::Camera camera_;
};

Deposit deposit_of(const Found& found, double mean) {
  Deposit deposit{found.light, {}, 0};
  constexpr double CELLS = 1u << GUIDE_HALVINGS;
  for (int axis = 0; axis < 4; ++axis)
    deposit.cell[static_cast<size_t>(axis)] =
        static_cast<uint16_t>(std::clamp(found.numbers[axis] * CELLS, 0.0, CELLS - 1));
  deposit.weight = whole_weight(found.weight, mean);
  return deposit;
}

/// See TrainedLightGuide::gain. The half that trains tells the density of what is of use, too.
double gain_of(const scene::Scene& scene, const std::vector<Deposit>& trained,
               const std::vector<Deposit>& told) {
  if (trained.empty() || told.empty()) return 1;
  const scene::LightGuide guide = make_light_guide(scene, trained);
  double by_power = 0;
  double guided = 0;
  for (const Deposit& deposit : told) {
    const double share = share_of_start(scene, guide, deposit);
    const double useful = std::max(share - DEFENSIVE_SHARE, 0.0) * static_cast<double>(deposit.weight);
    by_power += useful;
    guided += useful / share;
  }
  return guided > 0 ? by_power / guided : 1;
}

}  // namespace

TrainedLightGuide train_light_guide(const reference::World& world, const reference::Settings& settings) {
  const Trainer trainer(world, settings);
  std::vector<Found> found;
  std::vector<size_t> ends;
  for (uint32_t i = 0; i < settings.samples; ++i) {
    const std::vector<Found> part = trainer.find(settings.first_sample + i);
    found.insert(found.end(), part.begin(), part.end());
    ends.push_back(found.size());
  }
  if (found.empty()) return {};
  double mean = 0;
  for (const Found& one : found) mean += one.weight / static_cast<double>(found.size());
  std::vector<Deposit> deposits;
  deposits.reserve(found.size());
  for (const Found& one : found) deposits.push_back(deposit_of(one, mean));
  const auto half = deposits.begin() + static_cast<std::ptrdiff_t>(ends[(ends.size() - 1) / 2]);
  const double gain = gain_of(world.scene(), {deposits.begin(), half}, {half, deposits.end()});
  return {std::make_shared<scene::LightGuide>(make_light_guide(world.scene(), std::move(deposits))), gain};
}

}  // namespace regulus::probe
