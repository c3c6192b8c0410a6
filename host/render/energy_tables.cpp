#include "render/energy_tables.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "interface/energy.h"
#include "interface/wavefront.h"
#include "render/shaders.hpp"
#include "scene/interfaces.hpp"

namespace regulus::render {

using namespace interface;

namespace {

// The indices of refraction that get tables, ascending: all of the scene's, or some of them evenly.
std::vector<float> choose_indices(std::vector<float> all) {
  if (all.size() <= ENERGY_MAX_INDICES) return all;
  std::vector<float> chosen;
  chosen.reserve(ENERGY_MAX_INDICES);
  for (size_t i = 0; i < ENERGY_MAX_INDICES; ++i)
    chosen.push_back(all[i * (all.size() - 1) / (ENERGY_MAX_INDICES - 1)]);
  return chosen;
}

// 2 int f(cos) cos dcos of a row of a plane, whose nodes lie at the cosines that `cosine_of` gives, as
// piecewise linear.
template <typename Cosine>
float mean_of_row(const std::vector<float>& words, size_t row, const Cosine& cosine_of) {
  double sum = 0;
  for (uint32_t node = 0; node + 1 < ENERGY_NODES; ++node) {
    const double c0 = cosine_of(node), c1 = cosine_of(node + 1);
    const double f0 = words[row + node], f1 = words[row + node + 1];
    // Exact for f linear in the cosine.
    sum += (c1 - c0) * (f0 * (2 * c0 + c1) + f1 * (c0 + 2 * c1)) / 3;
  }
  return static_cast<float>(sum);
}

double fraction(uint32_t node) {
  return static_cast<double>(node) / (ENERGY_NODES - 1);
}

// Means by roughness of the plane at word `plane`, to word `means`.
void add_means(std::vector<float>& words, size_t plane, size_t means, bool is_by_position) {
  for (uint32_t r = 0; r < ENERGY_NODES; ++r) {
    const double alpha = std::max(fraction(r) * fraction(r), 1e-6);
    const auto cosine_of = [&](uint32_t node) {
      const double x = fraction(node);
      if (!is_by_position || node + 1 == ENERGY_NODES) return x;
      const double cotangent = alpha * x / (1 - x);
      return cotangent / std::sqrt(1 + cotangent * cotangent);
    };
    words[means + r] = mean_of_row(words, plane + size_t{r} * ENERGY_NODES, cosine_of);
  }
}

// Means of the rows of a cover from outside, whose nodes are linear in u = sqrt(cos): 2 int f cos dcos = int
// f 4 u^3 du.
void add_outside_means(std::vector<float>& words, size_t side) {
  const auto power = [](double x, int n) { return std::pow(x, n); };
  for (uint32_t row = 0; row < COVER_ROWS; ++row)
    for (size_t word = 0; word < 2; ++word) {
      double sum = 0;
      for (uint32_t node = 0; node + 1 < ENERGY_NODES; ++node) {
        const size_t here = side + 2 * (size_t{row} * ENERGY_NODES + node) + word;
        const double a = fraction(node), b = fraction(node + 1);
        const double fourth = power(b, 4) - power(a, 4), fifth = power(b, 5) - power(a, 5);
        const double slope = (double{words[here + 2]} - words[here]) / (b - a);
        sum += words[here] * fourth + slope * (0.8 * fifth - a * fourth);
      }
      words[side + 2 * (COVER_NODES + size_t{row}) + word] = static_cast<float>(sum);
    }
}

// Cosine at place `x` among the columns of a cover from inside (cover_cosine in shaders/lib/cover.glsl).
double inside_cosine(double x, double critical) {
  const double from_critical = x - COVER_CRITICAL_NODE;
  if (from_critical >= 0) {
    const double part = from_critical / (ENERGY_NODES - 1 - COVER_CRITICAL_NODE);
    return critical + (1 - critical) * part * part;
  }
  const double part = x / COVER_CRITICAL_NODE, rest = 1 - part;
  return critical * part * part / (part * part + rest * rest);
}

// int cos^2 dx from one column to the next, by Gauss and Legendre's rule of five points.
double integral_of_square(uint32_t column, double critical) {
  constexpr double PLACES[] = {0.0469100770306680, 0.2307653449471585, 0.5, 0.7692346550528415,
                               0.9530899229693320};
  constexpr double WEIGHTS[] = {0.1184634425280945, 0.2393143352496832, 0.2844444444444444,
                                0.2393143352496832, 0.1184634425280945};
  double sum = 0;
  for (int i = 0; i < 5; ++i) {
    const double cosine = inside_cosine(column + PLACES[i], critical);
    sum += WEIGHTS[i] * cosine * cosine;
  }
  return sum;
}

// Means of the rows of a cover from inside, linear from column to column, by parts:
// 2 int f cos dcos = [f cos^2] - int f' cos^2 dx.
void add_inside_means(std::vector<float>& words, size_t side, double ior) {
  const double critical = std::sqrt((ior - 1) * (ior + 1)) / ior;
  std::array<double, ENERGY_NODES - 1> integrals;
  for (uint32_t column = 0; column + 1 < ENERGY_NODES; ++column)
    integrals[column] = integral_of_square(column, critical);
  for (uint32_t row = 0; row < COVER_ROWS; ++row)
    for (size_t word = 0; word < 2; ++word) {
      const auto value = [&](uint32_t column) {
        return double{words[side + 2 * (size_t{row} * ENERGY_NODES + column) + word]};
      };
      double sum = value(ENERGY_NODES - 1);  // the cosine is 0 at the first column, 1 at the last
      for (uint32_t column = 0; column + 1 < ENERGY_NODES; ++column)
        sum -= (value(column + 1) - value(column)) * integrals[column];
      words[side + 2 * (COVER_NODES + size_t{row}) + word] = static_cast<float>(sum);
    }
}

}  // namespace

gpu::Buffer make_energy_tables(gpu::Device& device, const std::vector<Material>& materials,
                               const CommonSettings& settings, const EnergyUses& uses, bool has_contacts) {
  const std::vector<float> indices = choose_indices(scene::interface_indices(materials, has_contacts));
  const size_t count = ENERGY_PER_INDEX + indices.size() * ENERGY_INDEX_WORDS;
  gpu::Buffer tables = device.create_buffer(count * sizeof(float), "energy tables");
  const gpu::Kernel kernel =
      device.create_kernel({"energy_tables",
                            stage_spirv(device, Stage::EnergyTables),
                            {{SPEC_NDF, settings.ndf}, {SPEC_SHADOWING, settings.shadowing}}});
  // One submission each: together they might take too long for a watchdog.
  const auto fill = [&](size_t first, uint32_t quantity, float ior) {
    gpu::CommandList commands(device);
    const EnergyArguments arguments{device_address(tables.address()), static_cast<uint32_t>(first), quantity,
                                    ior};
    const uint32_t nodes =
        quantity >= ENERGY_COVER_OUT ? COVER_NODES : ENERGY_PLANE_WORDS;  // refracted as covers
    commands.dispatch(kernel, gpu::bytes_of(arguments), nodes / WORKGROUP_SIZE);
    gpu::Submission submission = device.submit(std::move(commands));
    device.wait(submission);
  };
  const auto first_of = [](size_t i) { return ENERGY_PER_INDEX + i * ENERGY_INDEX_WORDS; };
  if (uses.has_compensation || uses.raises_lobes) fill(ENERGY_COMMON, ENERGY_REFLECTED, 1.5f);
  if (uses.has_compensation) {
    for (size_t i = 0; i < indices.size(); ++i)
      for (const uint32_t quantity : {ENERGY_FRESNEL, ENERGY_SCATTERED_OUT, ENERGY_SCATTERED_IN})
        fill(first_of(i) + (quantity - 1) * ENERGY_PLANE_WORDS, quantity, indices[i]);
  }
  if (uses.has_rough_bases) {
    const bool has_inside = std::ranges::any_of(materials, scene::may_show_base_inside);
    for (size_t i = 0; i < indices.size(); ++i) {
      fill(first_of(i) + ENERGY_COVERS, ENERGY_COVER_OUT, indices[i]);
      if (has_inside) fill(first_of(i) + ENERGY_COVERS + COVER_SIDE_WORDS, ENERGY_COVER_IN, indices[i]);
    }
  }
  if (uses.raises_lobes && std::ranges::any_of(materials, scene::bounds_solids)) {
    for (size_t i = 0; i < indices.size(); ++i) {
      fill(first_of(i) + ENERGY_REFRACTED, ENERGY_REFRACTED_OUT, indices[i]);
      fill(first_of(i) + ENERGY_REFRACTED + REFRACTED_SIDE_WORDS, ENERGY_REFRACTED_IN, indices[i]);
    }
  }

  std::vector<float> words = gpu::download_all<float>(device, tables, count);
  words[0] = std::bit_cast<float>(static_cast<uint32_t>(indices.size()));
  std::ranges::copy(indices, words.begin() + ENERGY_INDICES);
  if (uses.has_compensation) add_means(words, ENERGY_COMMON, ENERGY_COMMON + ENERGY_PLANE_WORDS, true);
  for (size_t i = 0; i < indices.size(); ++i) {
    const size_t first = first_of(i);
    if (uses.has_compensation) {
      add_means(words, first, first + 3 * ENERGY_PLANE_WORDS, false);
    }
    if (uses.has_rough_bases) {
      add_outside_means(words, first + ENERGY_COVERS);
      add_inside_means(words, first + ENERGY_COVERS + COVER_SIDE_WORDS, indices[i]);
    }
  }
  device.upload(tables, 0, gpu::bytes_of(words));
  return tables;
}

}  // namespace regulus::render
