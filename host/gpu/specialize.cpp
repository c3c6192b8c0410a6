#include "gpu/specialize.hpp"

#include <spirv-tools/optimizer.hpp>
#include <string>
#include <unordered_map>

namespace regulus::gpu {

std::vector<uint32_t> specialize(const KernelDescription& kernel) {
  std::unordered_map<uint32_t, std::vector<uint32_t>> values;
  for (const auto& [id, value] : kernel.constants) values[id] = {value};
  spvtools::Optimizer optimizer(SPV_ENV_VULKAN_1_2);
  optimizer.RegisterPass(spvtools::CreateSetSpecConstantDefaultValuePass(values))
      .RegisterPass(spvtools::CreateFreezeSpecConstantValuePass())
      .RegisterPass(spvtools::CreateFoldSpecConstantOpAndCompositePass())
      .RegisterPass(spvtools::CreateDeadBranchElimPass())
      .RegisterPass(spvtools::CreateEliminateDeadFunctionsPass());
  // The modules are glslang's own; lint validates them.
  spvtools::OptimizerOptions options;
  options.set_run_validator(false);
  std::vector<uint32_t> result;
  if (!optimizer.Run(kernel.spirv.data(), kernel.spirv.size(), &result, options))
    return {kernel.spirv.begin(), kernel.spirv.end()};
  return result;
}

}  // namespace regulus::gpu
