#include "reference/energy.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "reference/bsdf.hpp"
#include "reference/fresnel.hpp"
#include "reference/quadrature.hpp"

namespace regulus::reference {

using glm::dvec2;
using glm::dvec3;
using namespace interface;

namespace {

constexpr double LEAST_ALPHA = 1e-6;
constexpr double LEAST_POSITION = 1e-3;
constexpr uint32_t PLANES = 4;

double fraction(uint32_t node) {
  return static_cast<double>(node) / (ENERGY_NODES - 1);
}

double alpha_of_row(uint32_t row) {
  return std::max(fraction(row) * fraction(row), LEAST_ALPHA);
}

/// Cosine of the direction that lies at x = cos / (cos + alpha sin); planes of Fresnel positions go by the
/// cosine itself.
double cosine_at(uint32_t quantity, double x, double alpha) {
  if (quantity == ENERGY_FRESNEL || x >= 1) return x;
  return std::cos(std::atan2(1 - x, alpha * x));
}

/// Points of the R3 sequence in 24 bits.
dvec3 r3_point(uint32_t i) {
  const auto coordinate = [&](uint32_t step) { return ((i + 1) * step >> 8) * 0x1p-24; };
  return {coordinate(3518319155u), coordinate(2882110345u), coordinate(2360945575u)};
}

/// Where x in [0, 1] lies between nodes.
struct TablePlace {
  uint32_t node;
  double rest;
};

TablePlace place_of(double x) {
  const double scaled = std::clamp(x, 0.0, 1.0) * (ENERGY_NODES - 1);
  const uint32_t node = std::min(static_cast<uint32_t>(scaled), ENERGY_NODES - 2);
  return {node, scaled - node};
}

/// Linear in both places, of what `node(column, row)` is at the four nodes around.
template <typename Node>
auto between(const TablePlace& column, const TablePlace& row, const Node& node) {
  const auto along = [&](uint32_t r) {
    return glm::mix(node(column.node, r), node(column.node + 1, r), column.rest);
  };
  return glm::mix(along(row.node), along(row.node + 1), row.rest);
}

double position_of(double cosine, double roughness) {
  const double sine = std::sqrt(std::max(1 - cosine * cosine, 0.0));
  const double sum = cosine + roughness * roughness * sine;
  return sum > 0 ? cosine / sum : 0;
}

std::unique_ptr<std::atomic<double>[]> unknown(size_t count) {
  auto numbers = std::make_unique<std::atomic<double>[]>(count);
  for (size_t i = 0; i < count; ++i) numbers[i] = std::numeric_limits<double>::quiet_NaN();
  return numbers;
}

template <typename Function>
double remembered(std::atomic<double>& stored, const Function& compute) {
  const double known = stored.load(std::memory_order_relaxed);
  if (!std::isnan(known)) return known;
  const double value = compute();
  stored.store(value, std::memory_order_relaxed);
  return value;
}

/// The same for two numbers. The second is stored first, so that whoever finds the first one finds both.
template <typename Function>
dvec2 remembered_pair(std::atomic<double>* stored, const Function& compute) {
  const double known = stored[0].load(std::memory_order_acquire);
  if (!std::isnan(known)) return {known, stored[1].load(std::memory_order_relaxed)};
  const dvec2 value = compute();
  stored[1].store(value.y, std::memory_order_relaxed);
  stored[0].store(value.x, std::memory_order_release);
  return value;
}

std::vector<float> chosen(std::vector<float> all) {
  std::ranges::sort(all);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  if (all.size() <= ENERGY_MAX_INDICES) return all;
  std::vector<float> some;
  for (size_t i = 0; i < ENERGY_MAX_INDICES; ++i)
    some.push_back(all[i * (all.size() - 1) / (ENERGY_MAX_INDICES - 1)]);
  return some;
}

}  // namespace

EnergyTables::EnergyTables(std::vector<float> indices, uint32_t ndf, uint32_t shadowing)
    : indices_(chosen(std::move(indices))),
      ndf_(ndf),
      shadowing_(shadowing),
      nodes_(unknown(indices_.size() * PLANES * ENERGY_PLANE_WORDS)),
      means_(unknown(indices_.size() * PLANES * ENERGY_NODES)),
      cover_nodes_(unknown(indices_.size() * 4 * COVER_NODES)),
      cover_means_(unknown(indices_.size() * 4 * COVER_ROWS)),
      refracted_nodes_(unknown(indices_.size() * 2 * COVER_NODES)) {}

uint32_t EnergyTables::nearest(double ior) const {
  const auto is_nearer = [&](float a, float b) { return std::abs(a - ior) < std::abs(b - ior); };
  return static_cast<uint32_t>(std::ranges::min_element(indices_, is_nearer) - indices_.begin());
}

namespace {

/// Sums over the points of a node.
struct Scattered {
  double reflected = 0, fresnel = 0, transmitted = 0;  // `fresnel`: the reflected, times their reflectance
};

/// Scatters even light from a direction with this cosine. `eta`: n(beyond) / n(here).
Scattered scatter(const Microsurface& surface, double cosine, double eta,
                  uint32_t points = EnergyTables::NODE_POINTS) {
  const Microsurface seen = visible_normal_model(surface);
  const dvec3 wo(std::sqrt(1 - cosine * cosine), 0, cosine);
  Scattered sums;
  for (uint32_t i = 0; i < points; ++i) {
    const dvec3 u = r3_point(i);
    double u_choice = u.z;
    const dvec3 h = sample_visible_normal(surface, wo, dvec2(u), u_choice);
    if (dot(wo, h) <= 0) continue;
    const double masked = masking(seen, wo, h);
    const double fresnel = fresnel_dielectric(dot(wo, h), eta);
    const dvec3 mirrored = reflect_at(wo, h);
    if (mirrored.z > 0) {
      const double share = masking_shadowing(surface, mirrored, wo, h, Scattering::Reflection) / masked;
      sums.reflected += share;
      sums.fresnel += share * fresnel;
    }
    const dvec3 refracted = refract_at(wo, h, eta);
    if (refracted.z < 0)
      sums.transmitted +=
          (1 - fresnel) * masking_shadowing(surface, refracted, wo, h, Scattering::Transmission) / masked;
  }
  return sums;
}

double cover_roughness(uint32_t row, bool is_inside) {
  const double x = static_cast<double>(row) / (COVER_ROWS - 1);
  return is_inside ? x * x : std::lerp(COVER_BEGIN_HUNDREDTHS / 100.0, 1.0, x);
}

/// Cosine at which total reflection begins in a solid of this index.
double critical_cosine(double ior) {
  return std::sqrt(1 - 1 / (ior * ior));
}

/// Cosine at place x among the columns of a cover: from inside, beside the critical angle and beside 0, it
/// goes by the square of the distance.
double cover_cosine(double x, double ior, bool is_inside) {
  if (!is_inside) return x * x / ((ENERGY_NODES - 1.0) * (ENERGY_NODES - 1.0));
  const double critical = critical_cosine(ior);
  const double beyond = (x - COVER_CRITICAL_NODE) / (ENERGY_NODES - 1.0 - COVER_CRITICAL_NODE);
  if (beyond >= 0) return critical + (1 - critical) * beyond * beyond;
  const double odds = x / (COVER_CRITICAL_NODE - x);
  return critical * odds * odds / (1 + odds * odds);
}

/// Between which columns of a cover a direction with this cosine lies.
TablePlace cover_column(double cosine, double ior, bool is_inside) {
  const double c = std::clamp(cosine, 0.0, 1.0);
  if (!is_inside) return place_of(std::sqrt(c));
  const double critical = critical_cosine(ior);
  const double last = ENERGY_NODES - 1;
  if (c >= critical)
    return place_of(std::lerp(COVER_CRITICAL_NODE / last, 1.0, std::sqrt((c - critical) / (1 - critical))));
  const double odds = std::sqrt(c / (critical - c));
  return place_of(COVER_CRITICAL_NODE / last * odds / (1 + odds));
}

/// Where a roughness lies between the rows of a cover.
TablePlace cover_row(double roughness, bool is_inside) {
  const double begin = COVER_BEGIN_HUNDREDTHS / 100.0;
  const double x = is_inside ? std::sqrt(roughness) : (roughness - begin) / (1 - begin);
  const double scaled = std::clamp(x, 0.0, 1.0) * (COVER_ROWS - 1);
  const uint32_t row = std::min(static_cast<uint32_t>(scaled), COVER_ROWS - 2);
  return {row, scaled - row};
}

}  // namespace

double cover_share(double roughness) {
  const double begin = COVER_BEGIN_HUNDREDTHS / 100.0, full = COVER_FULL_HUNDREDTHS / 100.0;
  const double x = std::clamp((roughness - begin) / (full - begin), 0.0, 1.0);
  return x * x * (3 - 2 * x);
}

double EnergyTables::integrate_node(double ior, uint32_t quantity, uint32_t direction, uint32_t row) const {
  const double alpha = alpha_of_row(row);
  const double eta = quantity == ENERGY_SCATTERED_IN ? 1 / ior : ior;
  const double cosine = cosine_at(quantity, std::max(fraction(direction), LEAST_POSITION), alpha);
  const Scattered sums = scatter({ndf_, shadowing_, dvec2(alpha)}, cosine, eta);
  if (quantity == ENERGY_REFLECTED) return sums.reflected / NODE_POINTS;
  if (quantity == ENERGY_FRESNEL)
    return (sums.fresnel / std::max(sums.reflected, 1e-6) - fresnel_dielectric(cosine, eta)) /
           (1 - fresnel_normal_incidence(ior));
  return (sums.fresnel + sums.transmitted) / NODE_POINTS;
}

dvec2 EnergyTables::cover_node(uint32_t index, bool is_inside, uint32_t direction, uint32_t row) const {
  const size_t node = (index * 2 + is_inside) * size_t{COVER_NODES} + row * ENERGY_NODES + direction;
  return remembered_pair(&cover_nodes_[2 * node], [&] {
    const double ior{indices_[index]};
    const double eta = is_inside ? 1 / ior : ior;
    const double cosine = std::max(cover_cosine(direction, ior, is_inside), LEAST_POSITION * LEAST_POSITION);
    const double roughness = cover_roughness(row, is_inside);
    const double normal = fresnel_normal_incidence(ior);
    if (roughness == 0) return dvec2(1, (fresnel_dielectric(cosine, eta) - normal) / (1 - normal));
    const Scattered sums = scatter({ndf_, shadowing_, dvec2(roughness * roughness)}, cosine, eta);
    return dvec2(sums.reflected, (sums.fresnel - normal * sums.reflected) / (1 - normal)) /
           static_cast<double>(NODE_POINTS);
  });
}

dvec2 EnergyTables::cover(uint32_t index, double cosine, double roughness, bool is_inside) const {
  return between(cover_column(cosine, double{indices_[index]}, is_inside), cover_row(roughness, is_inside),
                 [&](uint32_t column, uint32_t row) { return cover_node(index, is_inside, column, row); });
}

dvec2 EnergyTables::cover_row_mean(uint32_t index, bool is_inside, uint32_t row) const {
  // 2 int f c dc, where f is linear in the place x between columns, by parts.
  const auto square = [&](double x) { return std::pow(cover_cosine(x, indices_[index], is_inside), 2); };
  dvec2 sum(0);
  for (uint32_t i = 0; i + 1 < ENERGY_NODES; ++i) {
    const dvec2 first = cover_node(index, is_inside, i, row);
    const dvec2 last = cover_node(index, is_inside, i + 1, row);
    sum += last * square(i + 1) - first * square(i) - (last - first) * integrate(square, i, i + 1);
  }
  return sum;
}

dvec2 EnergyTables::cover_mean(uint32_t index, double roughness, bool is_inside) const {
  const TablePlace place = cover_row(roughness, is_inside);
  const auto of_row = [&](uint32_t row) {
    return remembered_pair(&cover_means_[2 * ((index * 2 + is_inside) * size_t{COVER_ROWS} + row)],
                           [&] { return cover_row_mean(index, is_inside, row); });
  };
  return glm::mix(of_row(place.node), of_row(place.node + 1), place.rest);
}

double EnergyTables::refracted_node(uint32_t index, bool is_inside, uint32_t direction, uint32_t row) const {
  const size_t node = (index * 2 + is_inside) * size_t{COVER_NODES} + row * ENERGY_NODES + direction;
  return remembered(refracted_nodes_[node], [&] {
    const double ior{indices_[index]};
    const double eta = is_inside ? 1 / ior : ior;
    const double cosine = std::max(cover_cosine(direction, ior, is_inside), LEAST_POSITION * LEAST_POSITION);
    const double roughness = cover_roughness(row, true);
    if (roughness == 0) return 1 - fresnel_dielectric(cosine, eta);
    return scatter({ndf_, shadowing_, dvec2(roughness * roughness)}, cosine, eta, REFRACTED_POINTS)
               .transmitted /
           REFRACTED_POINTS;
  });
}

double EnergyTables::refracted(uint32_t index, double cosine, double roughness, bool is_inside) const {
  return between(
      cover_column(cosine, double{indices_[index]}, is_inside), cover_row(roughness, true),
      [&](uint32_t column, uint32_t row) { return refracted_node(index, is_inside, column, row); });
}

double EnergyTables::node(uint32_t index, uint32_t quantity, uint32_t direction, uint32_t roughness) const {
  // A perfect reflector does not depend on an index: it has one plane.
  if (quantity == ENERGY_REFLECTED) index = 0;
  const size_t row = (index * PLANES + quantity) * size_t{ENERGY_NODES} + roughness;
  return remembered(nodes_[row * ENERGY_NODES + direction],
                    [&] { return integrate_node(double{indices_[index]}, quantity, direction, roughness); });
}

double EnergyTables::plane(uint32_t index, uint32_t quantity, double x, double roughness) const {
  return between(place_of(x), place_of(roughness),
                 [&](uint32_t column, uint32_t row) { return node(index, quantity, column, row); });
}

double EnergyTables::row_mean(uint32_t index, uint32_t quantity, uint32_t row) const {
  const double alpha = alpha_of_row(row);
  double sum = 0;
  for (uint32_t i = 0; i + 1 < ENERGY_NODES; ++i) {
    const double begin = cosine_at(quantity, fraction(i), alpha);
    const double end = cosine_at(quantity, fraction(i + 1), alpha);
    const double first = node(index, quantity, i, row);
    const double last = node(index, quantity, i + 1, row);
    sum += integrate([&](double c) { return 2 * c * std::lerp(first, last, (c - begin) / (end - begin)); },
                     begin, end);
  }
  return sum;
}

double EnergyTables::mean(uint32_t index, uint32_t quantity, double roughness) const {
  const TablePlace place = place_of(roughness);
  const auto of_row = [&](uint32_t row) {
    return remembered(means_[(index * PLANES + quantity) * size_t{ENERGY_NODES} + row],
                      [&] { return row_mean(index, quantity, row); });
  };
  return std::lerp(of_row(place.node), of_row(place.node + 1), place.rest);
}

double EnergyTables::reflected(double cosine, double roughness) const {
  return plane(0, ENERGY_REFLECTED, position_of(cosine, roughness), roughness);
}

double EnergyTables::reflected_mean(double roughness) const {
  return mean(0, ENERGY_REFLECTED, roughness);
}

double EnergyTables::scattered(uint32_t index, double cosine, double roughness, bool is_inside) const {
  return plane(index, is_inside ? ENERGY_SCATTERED_IN : ENERGY_SCATTERED_OUT, position_of(cosine, roughness),
               roughness);
}

double EnergyTables::fresnel(uint32_t index, double cosine, double roughness) const {
  return plane(index, ENERGY_FRESNEL, cosine, roughness);
}

double EnergyTables::fresnel_mean(uint32_t index, double roughness) const {
  return mean(index, ENERGY_FRESNEL, roughness);
}

}  // namespace regulus::reference
