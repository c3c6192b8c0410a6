// The script that renders a scene in parts on a farm.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace regulus::cli {

/// What a farm is to do. Names of files are relative to `folder`.
struct FarmJob {
  std::string scheduler;             ///< slurm, parallel or shell
  std::string program;               ///< regulus
  std::string folder;                ///< where the script works, absolute
  std::string scene, output;         ///< files
  std::vector<std::string> options;  ///< words for `render` beside those
  bool has_frames = false;           ///< the parts are frames of an animation, else samples of one picture
  uint64_t first = 0, count = 0;     ///< samples or frames
  uint64_t parts = 1;                ///< of 1 to count
};

/// Where the parts of an output and their checkpoints lie.
std::string parts_folder(const std::string& output);

/// A script for a POSIX shell: without arguments it does everything, `task K` renders part K from its
/// checkpoint, `merge` joins the parts of a picture. What is done is not done again.
std::string farm_script(const FarmJob& job);

}  // namespace regulus::cli
