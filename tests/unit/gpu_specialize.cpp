// What kernels declare before a driver sees them.
#include <gtest/gtest.h>

#include <spirv-tools/libspirv.hpp>

#include "gpu/specialize.hpp"

namespace regulus::gpu {
namespace {

constexpr const char* MODULE = R"(
  OpCapability Shader
  OpMemoryModel Logical GLSL450
  OpEntryPoint GLCompute %main "main"
  OpExecutionMode %main LocalSize 64 1 1
  %void = OpTypeVoid
  %function = OpTypeFunction %void
  %main = OpFunction %void None %function
  %entry = OpLabel
  OpReturn
  OpFunctionEnd
)";

std::string specialized(bool keeps_special_values) {
  const spvtools::SpirvTools tools(SPV_ENV_VULKAN_1_2);
  std::vector<uint32_t> module;
  EXPECT_TRUE(tools.Assemble(MODULE, &module));
  const std::vector<uint32_t> result =
      specialize({.name = "main", .spirv = module, .constants = {}}, keeps_special_values);
  EXPECT_TRUE(tools.Validate(result));
  std::string text;
  EXPECT_TRUE(tools.Disassemble(result, &text));
  return text;
}

TEST(GpuSpecialize, DeclaresThatSpecialValuesAreKeptWhereTheDeviceCan) {
  const std::string declared = specialized(true);
  EXPECT_NE(declared.find("OpCapability SignedZeroInfNanPreserve"), std::string::npos) << declared;
  EXPECT_NE(declared.find("SignedZeroInfNanPreserve 32"), std::string::npos) << declared;
  EXPECT_EQ(specialized(false).find("SignedZeroInfNanPreserve"), std::string::npos);
}

TEST(GpuSpecialize, LeavesAloneWhatIsNoModule) {
  const std::vector<uint32_t> words = {1, 2, 3, 4, 5, 6, 7, 8};
  EXPECT_EQ(specialize({.name = "no module", .spirv = words, .constants = {}}, true), words);
}

}  // namespace
}  // namespace regulus::gpu
