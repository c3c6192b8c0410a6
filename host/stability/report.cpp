#include "stability/report.hpp"

#include <algorithm>

#include "stability/families.hpp"

namespace regulus::stability {
namespace {

struct Family {
  const char* name;
  std::vector<Sweep> (*sweep)(gpu::Device&, Extent);
};

constexpr Family FAMILIES[] = {{"bsdf", sweep_bsdf},
                               {"weights", sweep_weights},
                               {"geometry", sweep_geometry},
                               {"lights", sweep_lights},
                               {"film", sweep_film},
                               {"pictures", sweep_pictures},
                               {"connections", sweep_connections}};

}  // namespace

bool Report::holds() const {
  return std::all_of(sweeps.begin(), sweeps.end(), [](const Sweep& sweep) { return sweep.holds(); });
}

std::vector<std::string> family_names() {
  std::vector<std::string> names;
  for (const Family& family : FAMILIES) names.emplace_back(family.name);
  return names;
}

Report measure(gpu::Device& device, Extent extent, const std::vector<std::string>& families,
               const std::function<bool()>& is_interrupted) {
  Report report{device.info().name, device.info().driver, extent == Extent::Quick ? "quick" : "full", {}};
  for (const Family& family : FAMILIES) {
    if (!families.empty() && std::find(families.begin(), families.end(), family.name) == families.end())
      continue;
    if (is_interrupted && is_interrupted()) break;
    for (Sweep& sweep : family.sweep(device, extent)) report.sweeps.push_back(std::move(sweep));
  }
  return report;
}

}  // namespace regulus::stability
