#include "session/request.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "base/error.hpp"
#include "base/near_names.hpp"
#include "image/image.hpp"
#include "render/aov.hpp"
#include "scene/film_limits.hpp"

namespace regulus::session {

namespace {

using namespace interface;
namespace names = render::names;

glm::uvec2 parse_size(const std::string& text) {
  glm::uvec2 size{0};
  const size_t x = text.find('x');
  const auto parse = [](std::string_view part, uint32_t& value) {
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    return error == std::errc{} && end == part.data() + part.size() && value >= 1 &&
           value <= scene::MAX_FILM_SIDE;
  };
  if (x == std::string::npos || !parse(std::string_view(text).substr(0, x), size.x) ||
      !parse(std::string_view(text).substr(x + 1), size.y))
    throw SettingError(
        "size", text,
        fmt::format("expected WIDTHxHEIGHT with sides from 1 to {}, such as 1280x720", scene::MAX_FILM_SIDE));
  return size;
}

/// `count` whole numbers with `separator` between them; none if the text is anything else.
std::vector<uint32_t> parse_numbers(const std::string& text, char separator, size_t count) {
  std::vector<uint32_t> numbers;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (numbers.size() < count) {
    uint32_t number = 0;
    const auto [after, error] = std::from_chars(at, end, number);
    numbers.push_back(number);
    const bool is_last = numbers.size() == count;
    if (error != std::errc{} || (is_last ? after != end : after == end || *after != separator)) return {};
    at = after + 1;
  }
  return numbers;
}

void parse_sample_range(const std::string& text, render::RenderSettings& settings) {
  const std::vector<uint32_t> range = parse_numbers(text, ':', 2);
  if (range.empty() || range[1] == 0 || uint64_t{range[0]} + range[1] > MAX_SAMPLES)
    throw SettingError("samples", text,
                       fmt::format("expected FIRST:COUNT, such as 64:32, of samples below {}", MAX_SAMPLES));
  settings.first_sample = range[0];
  settings.samples = range[1];
}

uint32_t find_camera(const std::string& wanted, const scene::Scene& scene) {
  constexpr size_t MOST_LISTED = 20;
  std::string list;
  std::vector<std::string> names;
  for (uint32_t i = 0; i < scene.cameras.size(); ++i) {
    if (wanted == scene.cameras[i].name || wanted == std::to_string(i)) return i;
    names.push_back(scene.cameras[i].name);
    if (i < MOST_LISTED) list += fmt::format("{}{} \"{}\"", i == 0 ? "" : ", ", i, names.back());
  }
  if (names.size() > MOST_LISTED) list += fmt::format(" and {} more", names.size() - MOST_LISTED);
  throw SettingError("camera", wanted,
                     fmt::format("{} has {}{}", scene.path.string(), list, suggest(wanted, names)));
}

uint32_t parse_techniques(const std::string& list) {
  uint32_t techniques = 0;
  std::istringstream stream(list);
  for (std::string name; std::getline(stream, name, ',');) {
    const render::Name* found = find_name(names::TECHNIQUES, name);
    if (found == nullptr)
      throw SettingError("techniques", list, unknown_name(name, names_of(names::TECHNIQUES)));
    techniques |= found->value;
  }
  if (techniques == 0) throw SettingError("techniques", list, "the list is empty");
  return techniques;
}

uint32_t parse_connections(const std::string& text) {
  constexpr std::string_view CACHE = "cache:";
  if (text == "paired") return 0;
  uint32_t count = 0;
  if (text.starts_with(CACHE)) {
    const auto [end, error] = std::from_chars(text.data() + CACHE.size(), text.data() + text.size(), count);
    if (error == std::errc{} && end == text.data() + text.size() && count >= 1 && count <= 1024) return count;
  }
  throw SettingError("connections", text, "expected paired or cache:M with M from 1 to 1024");
}

std::optional<float> parse_shadow_roulette(const std::string& text) {
  if (text == "off") return 0.0f;
  if (text == "auto") return std::nullopt;
  float value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc{} && end == text.data() + text.size() && std::isfinite(value) && value > 0)
    return value;
  throw SettingError("shadow-roulette", text, "expected off, auto or a radiance above 0");
}

void parse_merge_radius(const std::string& text, render::RenderSettings& settings) {
  float value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const std::string_view unit(end, static_cast<size_t>(text.data() + text.size() - end));
  if (error != std::errc{} || !(unit.empty() || unit == "%") || !std::isfinite(value) || !(value > 0))
    throw SettingError("merge-radius", text,
                       "expected metres, such as 0.01, or percent of the extent seen, such as 0.3%");
  if (unit == "%")
    settings.merge_radius_share = 0.01f * value;
  else
    settings.merge_radius = value;
}

/// What is open of techniques and regularization becomes what the header of a picture says.
void repeat_choice(const std::string& file, render::RenderSettings& settings) {
  image::Attributes attributes;
  image::read_exr(file, &attributes);
  const auto techniques = attributes.find("regulus:techniques");
  const auto regularization = attributes.find("regulus:regularization");
  const auto list = techniques == attributes.end()
                        ? nlohmann::json()
                        : nlohmann::json::parse(techniques->second, nullptr, false);
  const render::Name* kind =
      regularization == attributes.end() ? nullptr : find_name(names::REGULARIZATION, regularization->second);
  uint32_t bits = 0;
  for (const nlohmann::json& name : list.is_array() ? list : nlohmann::json::array()) {
    const render::Name* found =
        name.is_string() ? find_name(names::TECHNIQUES, name.get<std::string>()) : nullptr;
    if (found != nullptr) bits |= found->value;
  }
  if (bits == 0 || kind == nullptr)
    throw Error(ErrorCode::BadFile,
                fmt::format("settings-from {}: its header does not say how it was rendered; give an OpenEXR "
                            "picture that `regulus render` wrote",
                            file));
  if (settings.techniques) return;
  settings.techniques = bits;
  if (!settings.regularization) settings.regularization = kind->value;
}

}  // namespace

render::Window parse_window(const std::string& setting, const std::string& text, const glm::uvec2& size) {
  const std::vector<uint32_t> edges = parse_numbers(text, ',', 4);
  if (edges.empty() || edges[0] >= edges[2] || edges[1] >= edges[3] || edges[2] > size.x || edges[3] > size.y)
    throw SettingError(
        setting, text,
        fmt::format("expected x0,y0,x1,y1 with 0 <= x0 < x1 <= {} and 0 <= y0 < y1 <= {}, in pixels from the "
                    "top left, x1 and y1 excluded",
                    size.x, size.y));
  return {edges[0], edges[1], edges[2] - edges[0], edges[3] - edges[1]};
}

uint32_t parse_technique_set(const std::string& text) {
  const render::Name* integrator = find_name(names::INTEGRATORS, text);
  return integrator != nullptr ? integrator->value : parse_techniques(text);
}

render::RenderSettings resolve_settings(const Request& request, const scene::Scene& scene) {
  render::RenderSettings settings = request.settings;
  if (request.has_no_sample_limit) settings.samples = MAX_SAMPLES;
  settings.has_strategy_images = request.has_strategy_images;
  settings.keeps_doublings = request.noise_target.has_value();
  settings.camera = request.camera.empty() ? 0 : find_camera(request.camera, scene);
  const glm::uvec2 size =
      request.size.empty() ? scene::default_film_size(scene, settings.camera) : parse_size(request.size);
  settings.width = size.x;
  settings.height = size.y;
  if (!request.crop.empty()) settings.crop = parse_window("crop", request.crop, size);
  if (!request.sample_range.empty()) parse_sample_range(request.sample_range, settings);
  settings.aovs = render::parse_aovs(request.aovs);
  const uint32_t techniques =
      parse_technique_set(request.techniques.empty() ? request.integrator : request.techniques);
  settings.techniques = techniques == 0 ? std::nullopt : std::optional(techniques);
  settings.regularization = request.regularization;
  if (!request.settings_from.empty()) repeat_choice(request.settings_from, settings);
  settings.regularization_modes = request.tau_schedule | request.diffusion;
  settings.cache_connections = parse_connections(request.connections);
  settings.shadow_roulette = parse_shadow_roulette(request.shadow_roulette);
  if (!request.merge_radius.empty()) parse_merge_radius(request.merge_radius, settings);
  settings.filter_radius = request.filter_radius.value_or(settings.filter == FILTER_BOX ? 0.5f : 1.5f);
  settings.filter_sigma = settings.filter_radius / 3;
  return settings;
}

}  // namespace regulus::session
