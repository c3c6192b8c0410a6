// What drivers get to compile: the modules of all stages, specialized.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <span>
#include <spirv-tools/libspirv.hpp>
#include <string>
#include <vector>

#include "gpu/specialize.hpp"
#include "interface/wavefront.h"
#include "render/shaders.hpp"

namespace regulus::test {
namespace {

using namespace interface;

std::set<std::string> modules() {
  std::set<std::string> names;
  for (size_t stage = 0; stage < render::STAGE_COUNT; ++stage)
    for (const char* variant : {"", ".int32"})
      names.insert(std::string(file_of(static_cast<render::Stage>(stage))) + variant);
  return names;
}

/// Variables that functions have, by the words of the module (SPIR-V 1.5, sections 2.3 and 3.49.8).
size_t count_variables(std::span<const uint32_t> spirv) {
  constexpr uint32_t OP_VARIABLE = 59, STORAGE_FUNCTION = 7, HEADER_WORDS = 5;
  size_t count = 0;
  for (size_t i = HEADER_WORDS; i < spirv.size(); i += std::max(spirv[i] >> 16, 1u))
    count += (spirv[i] & 0xFFFF) == OP_VARIABLE && spirv[i + 3] == STORAGE_FUNCTION ? 1 : 0;
  return count;
}

TEST(GpuStageModules, AreValidAndHaveFewVariables) {
  std::string message;
  spvtools::SpirvTools tools(SPV_ENV_VULKAN_1_2);
  tools.SetMessageConsumer(
      [&](spv_message_level_t, const char*, const spv_position_t&, const char* text) { message = text; });
  spvtools::ValidatorOptions options;
  options.SetScalarBlockLayout(true);
  size_t before = 0, after = 0;
  for (const std::string& name : modules()) {
    const std::vector<std::pair<uint32_t, uint32_t>> constants = {
        {SPEC_FEATURES, name.ends_with(".int32") ? FEATURE_ALPHA | FEATURE_ENVIRONMENT : 0u},
        {SPEC_TECHNIQUES, TECHNIQUE_HIT | TECHNIQUE_NEE | TECHNIQUE_CONNECT},
        {SPEC_MATERIAL_CLASS, MATERIAL_CLASS_TRANSMISSIVE},
        {SPEC_STATE, name.ends_with(".int32") ? STATE_OF_KERNELS : STATE_ALWAYS}};
    const std::span<const uint32_t> spirv = shaders::spirv(name);
    const std::vector<uint32_t> specialized = gpu::specialize({name, spirv, constants}, true);
    EXPECT_TRUE(tools.Validate(specialized.data(), specialized.size(), options)) << name << ": " << message;
    before += count_variables(spirv);
    after += count_variables(specialized);
  }
  std::printf("%zu variables of %zu are left\n", after, before);
  // Parameters of functions and arrays stay, all others go.
  EXPECT_LT(after, before / 3);
}

}  // namespace
}  // namespace regulus::test
