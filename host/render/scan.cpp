#include "render/scan.hpp"

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
    : sums_(device.create_kernel({"scan_sums", stage_spirv(device, "scan_sums"), {}})),
      spread_(device.create_kernel({"scan_spread", stage_spirv(device, "scan_spread"), {}})) {}

uint64_t Scan::words_needed(uint64_t count) {
  const Level top = levels_of(static_cast<uint32_t>(count)).back();
  return uint64_t{top.first} + top.count;
}

void Scan::record(gpu::CommandList& commands, const gpu::Buffer& words, uint32_t count) const {
  const std::vector<Level> levels = levels_of(count);
  const auto dispatch = [&](const gpu::Kernel& kernel, const Level& level, uint32_t sums) {
    const ScanArguments arguments{device_address(words.address()), level.first, level.count, sums};
    const uint32_t per_group = WORKGROUP_SIZE * SCAN_FAN;
    commands.dispatch(kernel, gpu::bytes_of(arguments), (level.count + per_group - 1) / per_group);
  };
  for (size_t i = 0; i + 1 < levels.size(); ++i) dispatch(sums_, levels[i], levels[i + 1].first);
  dispatch(spread_, levels.back(), INVALID_INDEX);
  for (size_t i = levels.size() - 1; i-- > 0;) dispatch(spread_, levels[i], levels[i + 1].first);
}

}  // namespace regulus::render
