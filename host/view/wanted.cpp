#include "view/wanted.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "base/error.hpp"
#include "session/request.hpp"

namespace regulus::view {

namespace {

using nlohmann::json;

constexpr const char* SIDE_NAMES[] = {"a", "b"};

[[noreturn]] void fail(const std::string& what, const std::string& expected) {
  throw Error(ErrorCode::BadUsage, fmt::format("{}: expected {}", what, expected));
}

const json& member(const json& object, const char* name) {
  if (!object.is_object()) fail(name, "an object that has it");
  const auto found = object.find(name);
  if (found == object.end()) fail(name, "a value");
  return *found;
}

double number(const json& object, const char* name, double least, double most) {
  const json& value = member(object, name);
  if (!value.is_number()) fail(name, "a number");
  const auto result = value.get<double>();
  if (!(result >= least && result <= most))
    fail(name, fmt::format("a number from {:g} to {:g}", least, most));
  return result;
}

bool truth(const json& object, const char* name) {
  const json& value = member(object, name);
  if (!value.is_boolean()) fail(name, "true or false");
  return value.get<bool>();
}

constexpr const char* SHOWN_NAMES[] = {"picture", "denoised", "deviation"};  // as in Shown

Shown parse_shown(const json& value) {
  const auto found = std::ranges::find_if(
      SHOWN_NAMES, [&](const char* name) { return value.is_string() && value.get<std::string>() == name; });
  if (found == std::end(SHOWN_NAMES)) fail("shown", "picture, denoised or deviation");
  return static_cast<Shown>(found - std::begin(SHOWN_NAMES));
}

Side parse_side(const json& object) {
  Side side;
  const json& techniques = member(object, "techniques");
  if (!techniques.is_string()) fail("techniques", "a text");
  side.techniques = techniques.get<std::string>();
  session::parse_technique_set(side.techniques);
  side.tau = number(object, "tau", 1e-6, 1e9);
  side.is_regularized = truth(object, "is_regularized");
  side.shown = parse_shown(member(object, "shown"));
  return side;
}

Orbit parse_orbit(const json& object) {
  constexpr double FARTHEST = 1e9, STEEPEST = 1.57;
  Orbit orbit;
  orbit.yaw = number(object, "yaw", -1e6, 1e6);
  orbit.pitch = number(object, "pitch", -STEEPEST, STEEPEST);
  orbit.distance = number(object, "distance", 1e-9, FARTHEST);
  const char* axes[] = {"x", "y", "z"};
  for (int axis = 0; axis < 3; ++axis)
    orbit.target[axis] = number(member(object, "target"), axes[axis], -FARTHEST, FARTHEST);
  return orbit;
}

}  // namespace

json to_json(const Wanted& wanted) {
  json result = {{"is_split", wanted.is_split}, {"orbit", nullptr}};
  for (size_t i = 0; i < wanted.sides.size(); ++i) {
    const Side& side = wanted.sides[i];
    result[SIDE_NAMES[i]] = {{"techniques", side.techniques},
                             {"tau", side.tau},
                             {"is_regularized", side.is_regularized},
                             {"shown", SHOWN_NAMES[static_cast<size_t>(side.shown)]}};
  }
  if (wanted.orbit) {
    const Orbit& orbit = *wanted.orbit;
    result["orbit"] = {{"yaw", orbit.yaw},
                       {"pitch", orbit.pitch},
                       {"distance", orbit.distance},
                       {"target", {{"x", orbit.target.x}, {"y", orbit.target.y}, {"z", orbit.target.z}}}};
  }
  return result;
}

Wanted parse_wanted(const std::string& text) {
  const json object = json::parse(text, nullptr, false);
  if (object.is_discarded()) fail("state", "JSON");
  Wanted wanted;
  for (size_t i = 0; i < wanted.sides.size(); ++i)
    wanted.sides[i] = parse_side(member(object, SIDE_NAMES[i]));
  wanted.is_split = truth(object, "is_split");
  if (const json& orbit = member(object, "orbit"); !orbit.is_null()) wanted.orbit = parse_orbit(orbit);
  return wanted;
}

render::RenderSettings settings_of(const Side& side, render::RenderSettings base) {
  const uint32_t techniques = session::parse_technique_set(side.techniques);
  base.techniques = techniques == 0 ? std::nullopt : std::optional(techniques);
  base.tau = static_cast<float>(side.tau);
  if (!side.is_regularized) base.regularization = interface::REGULARIZATION_NONE;
  // A camera that moves would wait for a training at each step.
  if (base.light_guide == interface::LIGHT_GUIDE_AUTO) base.light_guide = interface::LIGHT_GUIDE_OFF;
  // Denoised pictures: what either denoiser can use.
  if (side.shown == Shown::Denoised)
    base.aovs |= render::AOV_ALBEDO | render::AOV_SHADING_NORMAL | render::AOV_EMISSION;
  if (side.shown != Shown::Picture) base.aovs |= render::AOV_VARIANCE;
  base.keeps_doublings = true;
  return base;
}

uint64_t Mailbox::put(const Wanted& wanted) {
  const std::lock_guard lock(mutex_);
  wanted_ = wanted;
  changed_.notify_all();
  return ++number_;
}

std::pair<Wanted, uint64_t> Mailbox::get() const {
  const std::lock_guard lock(mutex_);
  return {wanted_, number_};
}

void Mailbox::wait(uint64_t known, std::chrono::milliseconds time) const {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, time, [&] { return number_ != known; });
}

}  // namespace regulus::view
