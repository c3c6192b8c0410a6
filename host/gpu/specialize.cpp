#include "gpu/specialize.hpp"

#include <spirv-tools/optimizer.hpp>
#include <string>
#include <unordered_map>

namespace regulus::gpu {

namespace {

/// Constants get their values, and what is dead then goes.
void register_specialization(const KernelDescription& kernel, spvtools::Optimizer& optimizer) {
  std::unordered_map<uint32_t, std::vector<uint32_t>> values;
  for (const auto& [id, value] : kernel.constants) values[id] = {value};
  optimizer.RegisterPass(spvtools::CreateSetSpecConstantDefaultValuePass(values))
      .RegisterPass(spvtools::CreateFreezeSpecConstantValuePass())
      .RegisterPass(spvtools::CreateFoldSpecConstantOpAndCompositePass())
      .RegisterPass(spvtools::CreateDeadBranchElimPass())
      .RegisterPass(spvtools::CreateEliminateDeadFunctionsPass());
}

/// Variables become values, and branches that known values decide go. Functions are left to the driver to
/// inline: that would need their early returns merged, after which lavapipe rounds some sums in another
/// order.
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

std::vector<uint32_t> specialize(const KernelDescription& kernel) {
  spvtools::Optimizer optimizer(SPV_ENV_VULKAN_1_2);
  // Passes that find something odd call the consumer, even if there is none.
  optimizer.SetMessageConsumer([](spv_message_level_t, const char*, const spv_position_t&, const char*) {});
  register_specialization(kernel, optimizer);
  register_values(optimizer);
  // The modules are glslang's own; lint validates them.
  spvtools::OptimizerOptions options;
  options.set_run_validator(false);
  std::vector<uint32_t> result;
  if (!optimizer.Run(kernel.spirv.data(), kernel.spirv.size(), &result, options))
    return {kernel.spirv.begin(), kernel.spirv.end()};
  return result;
}

}  // namespace regulus::gpu
