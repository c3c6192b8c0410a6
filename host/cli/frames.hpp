// Frames of an animation: which there are, when each of them is, and what its outputs are called.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cli/render_options.hpp"

namespace regulus::cli {

/// A frame to render.
struct Frame {
  uint64_t number = 0;
  double seconds = 0;  ///< of the animation: number / frames per second
};

/// The frames that --frames and --fps ask for, the last one included; empty: a single picture.
/// @throws regulus::Error (BadUsage) naming the option
std::vector<Frame> parse_frames(const RenderOptions& options);

/// The name of a frame's file: its number takes the place of the #s in the file's name, or else stands before
/// its extension, with at least four digits: a.exr becomes a.0007.exr, a##_b.exr becomes a07_b.exr.
std::string frame_name(const std::string& file, uint64_t frame);

/// The options with all outputs named for a frame.
RenderOptions for_frame(const RenderOptions& options, uint64_t frame);

}  // namespace regulus::cli
