// Which device renders which samples: by measured speed, or as a record says.
#pragma once

#include <cstdint>
#include <limits>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "session/part.hpp"

namespace regulus::session {

/// Samples that one of several devices rendered, or is to.
struct Share {
  size_t device = 0;  ///< its place in the list of --device
  SampleRange range;
  bool operator==(const Share&) const = default;
};

/// "0=0:4,1=4:8": DEVICE=FIRST:COUNT, in ascending order of samples, those of a device that touch as one.
std::string format_split(std::vector<Share> shares);
/// @throws regulus::Error (BadUsage) unless the text is such a list
std::vector<Share> parse_split(std::string_view text);
/// @throws regulus::Error (BadUsage) unless each sample of `all` is in one share of one of so many devices
void require_whole(const std::vector<Share>& shares, const SampleRange& all, size_t devices);

/// The samples of the shares, in ascending order, those that touch as one.
std::vector<SampleRange> ranges_of(std::vector<Share> shares);

/// Hands samples out. Thread-safe.
class SampleSplit {
 public:
  /// By speed: a device's first range is one sample; later ones are half of its part, by speed, of what is
  /// left, or what it does in 20 seconds or in half of the time that is left.
  /// @param earlier done before, of `all`
  SampleSplit(const SampleRange& all, size_t devices, std::vector<Share> earlier = {});
  /// As `shares` say, until a device is lost: its samples then go to whoever has none left.
  SampleSplit(std::vector<Share> shares, size_t devices);

  /// The next range of a device; none: all are given out, or the time is up.
  /// @param seconds_left after which nothing more is begun, nor what would take longer; by speed alone, and
  /// once
  ///   something was given out
  std::optional<SampleRange> take(size_t device,
                                  double seconds_left = std::numeric_limits<double>::infinity());
  /// A range is done and took so long.
  void finish(size_t device, const SampleRange& range, double seconds);
  /// A device is lost with the range that it had taken.
  void lose(size_t device, const std::optional<SampleRange>& range);

  /// What was finished, by whom.
  std::vector<Share> finished() const;

 private:
  std::optional<SampleRange> take_returned();
  std::optional<SampleRange> take_given(size_t device);
  std::optional<SampleRange> take_by_speed(size_t device, double seconds_left);
  uint64_t part_of(size_t device, double seconds_left) const;

  mutable std::mutex mutex_;
  bool is_fixed_;
  std::vector<SampleRange> left_;  // by speed: what was not given out yet, in ascending order
  std::vector<Share> fixed_;       // not given out yet
  std::vector<SampleRange> back_;  // of lost devices
  std::vector<double> speeds_;     // samples per second; 0: not known, negative: lost
  std::vector<Share> finished_;
  size_t under_way_ = 0;
};

}  // namespace regulus::session
