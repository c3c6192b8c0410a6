// What the page of `regulus view` asks for.
#pragma once

#include <array>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "render/settings.hpp"
#include "view/orbit.hpp"

namespace regulus::view {

/// What of a picture is looked at.
enum class Shown { Picture, Denoised, Deviation };  // the last: the standard deviation of each pixel

/// How one of the two pictures is rendered and shown.
struct Side {
  std::string techniques = "pt";  ///< an integrator, or techniques separated by commas
  double tau = 0;                 ///< 1/sr
  bool is_regularized = true;     ///< as the techniques suggest; false: not at all
  Shown shown = Shown::Picture;
  bool operator==(const Side&) const = default;
};

struct Wanted {
  std::array<Side, 2> sides;
  bool is_split = false;       ///< both sides are looked at; otherwise the first
  std::optional<Orbit> orbit;  ///< none: the scene's own camera
  bool operator==(const Wanted&) const = default;
};

nlohmann::json to_json(const Wanted& wanted);

/// @throws regulus::Error (BadUsage) that names what is missing, of the wrong kind or out of range
Wanted parse_wanted(const std::string& text);

/// The settings of a side: `base` with what the side says, and AOVs that what is shown needs.
/// @throws regulus::Error (BadUsage)
render::RenderSettings settings_of(const Side& side, render::RenderSettings base);

/// Hands what is wanted from the threads of the server to the one that renders.
class Mailbox {
 public:
  explicit Mailbox(Wanted first) : wanted_(std::move(first)) {}
  /// Returns the number of this state: each has a larger one.
  uint64_t put(const Wanted& wanted);
  std::pair<Wanted, uint64_t> get() const;
  /// Waits for a number other than `known`, or until the time is up.
  void wait(uint64_t known, std::chrono::milliseconds time) const;

 private:
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  Wanted wanted_;
  uint64_t number_ = 1;
};

}  // namespace regulus::view
