#include "gpu/specialize.hpp"

#include <spirv-tools/optimizer.hpp>
#include <string>
#include <unordered_map>

namespace regulus::gpu {
namespace {

constexpr size_t HEADER_WORDS = 5;
constexpr uint32_t OP_ENTRY_POINT = 15, OP_EXECUTION_MODE = 16, OP_CAPABILITY = 17;
constexpr uint32_t CAPABILITY_SIGNED_ZERO_INF_NAN_PRESERVE = 4466;
constexpr uint32_t MODE_SIGNED_ZERO_INF_NAN_PRESERVE = 4461;
constexpr uint32_t FLOAT_BITS = 32;

constexpr uint32_t first_word(uint32_t operation, uint32_t words) {
  return words << 16 | operation;
}

/// The module with the declaration. Capabilities stand first in a module, execution modes behind entry
/// points.
std::vector<uint32_t> with_special_values(const std::vector<uint32_t>& module) {
  std::vector<uint32_t> result(module.begin(), module.begin() + HEADER_WORDS);
  result.insert(result.end(), {first_word(OP_CAPABILITY, 2), CAPABILITY_SIGNED_ZERO_INF_NAN_PRESERVE});
  for (size_t at = HEADER_WORDS; at < module.size();) {
    const uint32_t operation = module[at] & 0xFFFFu;
    const uint32_t words = module[at] >> 16;
    if (words == 0 || at + words > module.size()) return module;  // not SPIR-V
    result.insert(result.end(), module.begin() + static_cast<ptrdiff_t>(at),
                  module.begin() + static_cast<ptrdiff_t>(at + words));
    if (operation == OP_ENTRY_POINT)
      result.insert(result.end(), {first_word(OP_EXECUTION_MODE, 4), module[at + 2],
                                   MODE_SIGNED_ZERO_INF_NAN_PRESERVE, FLOAT_BITS});
    at += words;
  }
  return result;
}

/// Variables become values, and branches that known values decide go. Functions are left to the driver to
/// inline: that would need their early returns merged, which makes cold compilations longer.
void register_values(spvtools::Optimizer& optimizer) {
  constexpr uint32_t MOST_MEMBERS = 100;  // of a structure that is taken apart
  optimizer.RegisterPass(spvtools::CreateLocalSingleBlockLoadStoreElimPass())
      .RegisterPass(spvtools::CreateLocalSingleStoreElimPass())
      .RegisterPass(spvtools::CreateScalarReplacementPass(MOST_MEMBERS))
      .RegisterPass(spvtools::CreateLocalAccessChainConvertPass())
      .RegisterPass(spvtools::CreateAggressiveDCEPass())
      .RegisterPass(spvtools::CreateSSARewritePass())
      .RegisterPass(spvtools::CreateCCPPass())
      .RegisterPass(spvtools::CreateDeadBranchElimPass())
      .RegisterPass(spvtools::CreateAggressiveDCEPass())
      .RegisterPass(spvtools::CreateEliminateDeadFunctionsPass())
      .RegisterPass(spvtools::CreateBlockMergePass());
}

}  // namespace

std::vector<uint32_t> specialize(const KernelDescription& kernel, bool keeps_special_values) {
  std::unordered_map<uint32_t, std::vector<uint32_t>> values;
  for (const auto& [id, value] : kernel.constants) values[id] = {value};
  spvtools::Optimizer optimizer(SPV_ENV_VULKAN_1_2);
  // Passes that find something odd call the consumer, even if there is none.
  optimizer.SetMessageConsumer([](spv_message_level_t, const char*, const spv_position_t&, const char*) {});
  optimizer.RegisterPass(spvtools::CreateSetSpecConstantDefaultValuePass(values))
      .RegisterPass(spvtools::CreateFreezeSpecConstantValuePass())
      .RegisterPass(spvtools::CreateFoldSpecConstantOpAndCompositePass())
      .RegisterPass(spvtools::CreateDeadBranchElimPass())
      .RegisterPass(spvtools::CreateEliminateDeadFunctionsPass());
  register_values(optimizer);
  // The modules are glslang's own; lint validates them.
  spvtools::OptimizerOptions options;
  options.set_run_validator(false);
  std::vector<uint32_t> result;
  if (!optimizer.Run(kernel.spirv.data(), kernel.spirv.size(), &result, options))
    result.assign(kernel.spirv.begin(), kernel.spirv.end());
  return keeps_special_values && result.size() > HEADER_WORDS ? with_special_values(result) : result;
}

}  // namespace regulus::gpu
