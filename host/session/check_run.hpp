// A device checked against the scalar reference by all that host/check can compare.
#pragma once

#include <cstdint>
#include <functional>

#include "check/check.hpp"
#include "gpu/gpu.hpp"
#include "prepared/prepared_scene.hpp"
#include "reference/world.hpp"
#include "render/plan.hpp"

namespace regulus::session {

/// A plan with what both backends need to follow it.
class CheckedPlan {
 public:
  CheckedPlan(const PreparedScene& prepared, const render::Plan& plan);
  CheckedPlan(const CheckedPlan&) = delete;
  CheckedPlan& operator=(const CheckedPlan&) = delete;

  const check::Subject& subject() const { return subject_; }

 private:
  render::Plan plan_;
  reference::World world_;
  reference::Camera camera_;
  reference::Settings settings_;
  check::Subject subject_;
};

/// Settings that leave techniques or regularization to the plan get the plan's: one regularization for all
/// sets of techniques that are checked, what a render by these settings would do.
render::RenderSettings one_choice(const PreparedScene& prepared, render::RenderSettings settings);

using TallySink = std::function<void(const check::Tally&)>;

/// Iterations with connections of both kinds, merges and splats, until `weights` weights have been compared;
/// 0: the first two and a late one, where radius and roughness have shrunk.
/// @return whether all lines, which go to `sink`, have passed
bool check_sorted_and_connected(gpu::Device& device, const check::Subject& subject, uint64_t weights,
                                const TallySink& sink);

/// Every stage, whole paths, connections and images. Of a scene with blended surfaces the stages alone: what
/// a ray does there hangs on its bits. Lines after one whose lists are broken are left out.
/// @return likewise
bool check_everything(gpu::Device& device, const check::Subject& subject, const TallySink& sink);

}  // namespace regulus::session
