#include "session/sample_split.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "base/error.hpp"

namespace regulus::session {

namespace {

// A range that is interrupted or lost with its device has been rendered in vain.
constexpr double MOST_SECONDS = 20;

bool starts_before(const Share& a, const Share& b) {
  return a.range.first < b.range.first;
}

/// Reads a number and the character behind it; nothing if there is no such.
bool read(std::string_view& text, char end, uint64_t& value) {
  const auto [at, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (status != std::errc{} || value > UINT32_MAX) return false;
  text.remove_prefix(static_cast<size_t>(at - text.data()));
  if (end == '\0') return text.empty() || text.front() == ',';
  if (!text.starts_with(end)) return false;
  text.remove_prefix(1);
  return true;
}

}  // namespace

std::vector<SampleRange> ranges_of(std::vector<Share> shares) {
  std::ranges::sort(shares, starts_before);
  std::vector<SampleRange> ranges;
  for (const Share& share : shares) {
    if (!ranges.empty() && ranges.back().first + ranges.back().count == share.range.first)
      ranges.back().count += share.range.count;
    else
      ranges.push_back(share.range);
  }
  return ranges;
}

std::string format_split(std::vector<Share> shares) {
  std::ranges::sort(shares, starts_before);
  std::vector<Share> joined;
  for (const Share& share : shares) {
    if (!joined.empty() && joined.back().device == share.device &&
        joined.back().range.first + joined.back().range.count == share.range.first)
      joined.back().range.count += share.range.count;
    else
      joined.push_back(share);
  }
  std::string text;
  for (const Share& share : joined)
    text += fmt::format("{}{}={}:{}", text.empty() ? "" : ",", share.device, share.range.first,
                        share.range.count);
  return text;
}

std::vector<Share> parse_split(std::string_view text) {
  const auto fail = [whole = text] {
    throw Error(
        ErrorCode::BadUsage,
        fmt::format("--split {}: expected DEVICE=FIRST:COUNT,... as a picture's header has it", whole));
  };
  std::vector<Share> shares;
  while (true) {
    uint64_t device = 0;
    SampleRange range;
    if (!read(text, '=', device) || !read(text, ':', range.first) || !read(text, '\0', range.count)) fail();
    if (range.count == 0) fail();
    shares.push_back({device, range});
    if (text.empty()) return shares;
    text.remove_prefix(1);
  }
}

void require_whole(const std::vector<Share>& shares, const SampleRange& all, size_t devices) {
  std::vector<Share> sorted = shares;
  std::ranges::sort(sorted, starts_before);
  uint64_t next = all.first;
  for (const Share& share : sorted) {
    if (share.device >= devices)
      throw Error(ErrorCode::BadUsage,
                  fmt::format("--split: device {} of {}; they count from 0 in the order of --device",
                              share.device, devices));
    if (share.range.first != next)
      throw Error(ErrorCode::BadUsage,
                  fmt::format("--split: sample {} is given to none or to several devices",
                              std::min(next, share.range.first)));
    next += share.range.count;
  }
  if (next != all.first + all.count)
    throw Error(ErrorCode::BadUsage, fmt::format("--split: ends at sample {}, the render at sample {}", next,
                                                 all.first + all.count));
}

SampleSplit::SampleSplit(const SampleRange& all, size_t devices, std::vector<Share> earlier)
    : is_fixed_(false), speeds_(devices, 0), finished_(std::move(earlier)) {
  uint64_t next = all.first;
  const auto leave_until = [&](uint64_t end) {
    if (end > next) left_.push_back({next, end - next});
  };
  for (const SampleRange& done : ranges_of(finished_)) {
    leave_until(done.first);
    next = done.first + done.count;
  }
  leave_until(all.first + all.count);
}

SampleSplit::SampleSplit(std::vector<Share> shares, size_t devices)
    : is_fixed_(true), fixed_(std::move(shares)), speeds_(devices, 0) {}

std::optional<SampleRange> SampleSplit::take_returned() {
  if (back_.empty()) return std::nullopt;
  const SampleRange range = back_.back();
  back_.pop_back();
  return range;
}

// Those whose speed is not known yet count as the device itself.
uint64_t SampleSplit::part_of(size_t device, double seconds_left) const {
  const double own = speeds_[device];
  if (own <= 0) return 1;
  double all = 0;
  for (const double speed : speeds_) all += speed == 0 ? own : std::max(speed, 0.0);
  uint64_t left = 0;
  for (const SampleRange& range : left_) left += range.count;
  const double part =
      std::min(0.5 * own / all * static_cast<double>(left), own * std::min(MOST_SECONDS, 0.5 * seconds_left));
  return std::max<uint64_t>(1, static_cast<uint64_t>(part));
}

std::optional<SampleRange> SampleSplit::take_given(size_t device) {
  const auto own = std::ranges::find(fixed_, device, &Share::device);
  if (own == fixed_.end()) return take_returned();
  const SampleRange range = own->range;
  fixed_.erase(own);
  return range;
}

std::optional<SampleRange> SampleSplit::take_by_speed(size_t device, double seconds_left) {
  const double sample_seconds = speeds_[device] > 0 ? 1 / speeds_[device] : 0;
  const bool has_begun = under_way_ != 0 || !finished_.empty();
  if (has_begun && seconds_left <= sample_seconds) return std::nullopt;
  if (auto range = take_returned()) return range;
  if (left_.empty()) return std::nullopt;
  SampleRange& rest = left_.front();
  const SampleRange range{rest.first, std::min(part_of(device, seconds_left), rest.count)};
  rest = {rest.first + range.count, rest.count - range.count};
  if (rest.count == 0) left_.erase(left_.begin());
  return range;
}

std::optional<SampleRange> SampleSplit::take(size_t device, double seconds_left) {
  const std::lock_guard lock(mutex_);
  const auto range = is_fixed_ ? take_given(device) : take_by_speed(device, seconds_left);
  if (range) ++under_way_;
  return range;
}

void SampleSplit::finish(size_t device, const SampleRange& range, double seconds) {
  const std::lock_guard lock(mutex_);
  --under_way_;
  speeds_[device] = static_cast<double>(range.count) / std::max(seconds, 1e-9);
  finished_.push_back({device, range});
}

void SampleSplit::lose(size_t device, const std::optional<SampleRange>& range) {
  const std::lock_guard lock(mutex_);
  speeds_[device] = -1;
  if (range) {
    back_.push_back(*range);
    --under_way_;
  }
  const auto is_own = [&](const Share& share) { return share.device == device; };
  for (const Share& share : fixed_)
    if (is_own(share)) back_.push_back(share.range);
  std::erase_if(fixed_, is_own);
}

std::vector<Share> SampleSplit::finished() const {
  const std::lock_guard lock(mutex_);
  return finished_;
}

}  // namespace regulus::session
