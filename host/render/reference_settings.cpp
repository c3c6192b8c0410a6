#include "render/reference_settings.hpp"

#include <cmath>

#include "base/error.hpp"

namespace regulus::render {

reference::Settings reference_settings(const Plan& plan) {
  // With and without regularization are two contributions in the reference, and a single one on the device.
  if (std::isfinite(plan.largest_contribution) &&
      ((plan.regularization & interface::REGULARIZATION_BOTH) != 0 ||
       plan.sampler_quality != interface::SAMPLER_QUALITY_OFF))
    throw Error(ErrorCode::BadUsage,
                "the scalar reference cannot clamp with regularization both or sampler quality");
  if ((plan.aovs & AOV_SIGMA) != 0) throw Error(ErrorCode::BadUsage, "the scalar reference has no aov sigma");
  reference::Settings result;
  result.width = plan.width;
  result.height = plan.height;
  result.crop = {plan.crop.x, plan.crop.y, plan.crop.width, plan.crop.height};
  result.largest_contribution = static_cast<double>(plan.largest_contribution);
  result.shadow_roulette = plan.shadow_roulette;
  result.camera = plan.camera;
  result.first_sample = plan.first_sample;
  result.samples = plan.samples;
  result.max_depth = plan.max_depth;
  result.seed = plan.seed;
  result.sampler = plan.sampler;
  result.techniques = plan.techniques;
  result.light_paths = plan.light_paths;
  result.merge_radius = plan.merge_radius;
  result.merge_reduction = plan.merge_reduction;
  result.cache_connections = plan.cache_connections;
  result.regularization = plan.regularization;
  result.bound = plan.bound;
  result.mis = plan.mis;
  result.tau = plan.tau;
  result.sampler_quality = plan.sampler_quality;
  result.ndf = plan.ndf;
  result.shadowing = plan.shadowing;
  result.layers = static_cast<uint32_t>(plan.layers.names.size());
  result.kind_layers = plan.layers.of_kind;
  result.first_group_layer = plan.layers.first_group;
  result.group_of_light = plan.layers.group_of_light;
  result.filter = {plan.filter, plan.filter_radius, plan.filter_sigma};
  return result;
}

}  // namespace regulus::render
