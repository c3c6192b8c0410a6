// What a render has come to, written to its files and said.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "bench/render_page.hpp"
#include "cli/progress.hpp"
#include "cli/render_options.hpp"
#include "cli/render_outputs.hpp"
#include "render/technique_choice.hpp"
#include "session/render_job.hpp"

namespace regulus::cli {

struct Rendered {
  const session::Result& result;
  const PreparedScene& prepared;
  const render::Plan& plan;
  const session::Job& job;
  const RenderOptions& options;
  const RenderOutputs& outputs;
  std::vector<bench::ConvergencePoint> convergence;
};

/// Writes everything that is asked for, warns of what is wrong with it, and says what was written.
/// @param begin of work on the picture
/// @throws regulus::Error for what there is to complain of: a file that cannot be written, a render that was
/// interrupted or failed
void write_result(const Rendered& rendered, ProgressReport& progress,
                  std::chrono::steady_clock::time_point begin);

}  // namespace regulus::cli
