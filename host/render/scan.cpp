#include "render/scan.hpp"

#include <algorithm>
#include <vector>

#include "interface/wavefront.h"
#include "render/shaders.hpp"

namespace regulus::render {

using namespace interface;

namespace {

struct Level {
  uint32_t first, count;  // words
};

// The words themselves, then the sums of SCAN_FAN of each level's words, until one invocation can scan them.
std::vector<Level> levels_of(uint32_t count) {
  std::vector<Level> levels{{0, count}};
  while (levels.back().count > SCAN_FAN) {
    const Level& below = levels.back();
    levels.push_back({below.first + below.count, (below.count + SCAN_FAN - 1) / SCAN_FAN});
  }
  return levels;
}

}  // namespace

Scan::Scan(gpu::Device& device)
    : sums_(device.create_kernel({"scan_sums", stage_spirv(device, Stage::ScanSums), {}})),
      spread_(device.create_kernel({"scan_spread", stage_spirv(device, Stage::ScanSpread), {}})),
      most_groups_(device.info().max_groups) {}

uint64_t Scan::words_needed(uint64_t count) {
  const Level top = levels_of(static_cast<uint32_t>(count)).back();
  return uint64_t{top.first} + top.count;
}

void Scan::record(gpu::CommandList& commands, const gpu::Buffer& words, uint32_t count) const {
  const std::vector<Level> levels = levels_of(count);
  // Records a step of the scan, in as many dispatches as the device's limit requires.
  const auto dispatch = [&](const gpu::Kernel& kernel, const Level& level, uint32_t sums) {
    constexpr uint32_t PER_GROUP = WORKGROUP_SIZE * SCAN_FAN;
    const uint64_t most = most_groups_ * PER_GROUP;
    for (uint64_t done = 0; done < level.count; done += most) {
      const auto first = static_cast<uint32_t>(done);
      const auto here = static_cast<uint32_t>(std::min(most, level.count - done));
      const ScanArguments arguments{device_address(words.address()), level.first + first, here,
                                    sums == INVALID_INDEX ? sums : sums + first / SCAN_FAN};
      if (done > 0) commands.independent();
      commands.dispatch(kernel, gpu::bytes_of(arguments), (here + PER_GROUP - 1) / PER_GROUP);
    }
  };
  for (size_t i = 0; i + 1 < levels.size(); ++i) dispatch(sums_, levels[i], levels[i + 1].first);
  dispatch(spread_, levels.back(), INVALID_INDEX);
  for (size_t i = levels.size() - 1; i-- > 0;) dispatch(spread_, levels[i], levels[i + 1].first);
}

}  // namespace regulus::render
