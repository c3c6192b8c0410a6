#include "cli/frames.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <filesystem>

#include "base/error.hpp"
#include "cli/render_outputs.hpp"

namespace regulus::cli {

namespace {

constexpr uint64_t MOST_FRAMES = 100'000, LAST_FRAME = 1'000'000'000;
constexpr int LEAST_DIGITS = 4;

/// A whole number that the text begins with, which is then taken off; none if it begins with anything else.
std::optional<uint64_t> take_number(std::string_view& text) {
  uint64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || number > LAST_FRAME) return std::nullopt;
  text.remove_prefix(static_cast<size_t>(end - text.data()));
  return number;
}

}  // namespace

std::vector<Frame> parse_frames(const RenderOptions& options) {
  if (options.frames.empty()) return {};
  if (!std::isfinite(options.frames_per_second))
    throw Error(ErrorCode::BadUsage, "--fps: expected a number of frames per second, such as 24");
  std::string_view text = options.frames;
  const auto first = take_number(text);
  const bool has_colon = first && text.starts_with(':');
  if (has_colon) text.remove_prefix(1);
  const auto last = has_colon ? take_number(text) : std::nullopt;
  if (!last || !text.empty() || *first > *last || *last - *first >= MOST_FRAMES)
    throw Error(ErrorCode::BadUsage,
                fmt::format("--frames {}: expected FIRST:LAST, such as 0:47, of at most {} frames",
                            options.frames, MOST_FRAMES));
  std::vector<Frame> frames;
  for (uint64_t number = *first; number <= *last; ++number)
    frames.push_back({number, static_cast<double>(number) / options.frames_per_second});
  return frames;
}

std::string frame_name(const std::string& file, uint64_t frame) {
  const std::filesystem::path path(file);
  std::string name = path.filename().string();
  const size_t hashes = name.find('#');
  if (hashes != std::string::npos) {
    const size_t end = std::min(name.find_first_not_of('#', hashes), name.size());
    name.replace(hashes, end - hashes, fmt::format("{:0{}}", frame, end - hashes));
  } else {
    const std::string extension = path.extension().string();
    name.insert(name.size() - extension.size(), fmt::format(".{:0{}}", frame, LEAST_DIGITS));
  }
  return (path.parent_path() / name).string();
}

RenderOptions for_frame(const RenderOptions& options, uint64_t frame) {
  RenderOptions named = options;
  if (named.output.empty()) {
    const std::filesystem::path picture = default_picture(options);
    named.output = picture.string();
    if (named.png.empty()) named.png = std::filesystem::path(picture).replace_extension(".png").string();
  }
  for (std::string* file :
       {&named.output, &named.png, &named.stats, &named.report, &named.checkpoint, &named.strategy_images})
    if (!file->empty()) *file = frame_name(*file, frame);
  return named;
}

}  // namespace regulus::cli
