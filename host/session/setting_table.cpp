// Every setting by name: what it takes, and where it goes.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <vector>

#include "base/error.hpp"
#include "base/near_names.hpp"
#include "base/printable.hpp"
#include "render/aov.hpp"
#include "scene/film_limits.hpp"
#include "session/request.hpp"

namespace regulus::session {

namespace {

using namespace interface;
namespace names = render::names;
using render::RenderSettings;
using Problem = std::optional<std::string>;
using Take = std::function<Problem(Request&, const std::string&)>;

template <typename Number>
std::optional<Number> parse(const std::string& text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// A field of the request, or of its render settings.
template <typename Value>
Value& at(Request& request, Value Request::*field) {
  return request.*field;
}
template <typename Value, typename Part>
Value& at(Request& request, Value Part::*field) {
  return request.settings.*field;
}

/// A whole number of [least, most].
template <typename Field>
Take whole(Field field, uint64_t least, uint64_t most) {
  return [=](Request& request, const std::string& text) -> Problem {
    const std::optional<uint64_t> value = parse<uint64_t>(text);
    if (!value || *value < least || *value > most)
      return fmt::format("\"{}\" is not a whole number from {} to {}", text, least, most);
    at(request, field) = static_cast<uint32_t>(*value);
    return std::nullopt;
  };
}

/// A number for which `is_valid`, which `range` says in words.
template <typename Field, typename IsValid>
Take number(Field field, const std::string& range, IsValid is_valid) {
  return [=](Request& request, const std::string& text) -> Problem {
    const std::optional<double> value = parse<double>(text);
    if (!value || std::isnan(*value) || !is_valid(*value))
      return fmt::format("\"{}\" is not a number {}", text, range);
    auto& target = at(request, field);
    if constexpr (std::is_same_v<std::decay_t<decltype(target)>, std::optional<double>>)
      target = *value;
    else
      target = static_cast<float>(*value);
    return std::nullopt;
  };
}

template <typename Field>
Take number_in(Field field, double least, double most) {
  return number(field, fmt::format("from {:g} to {:g}", least, most),
                [=](double value) { return value >= least && value <= most; });
}

template <typename Field>
Take positive_or_infinite(Field field) {
  return number(field, "above 0, or inf", [](double value) { return static_cast<float>(value) > 0; });
}

template <typename Field>
Take choice(Field field, render::Names table) {
  return [=](Request& request, const std::string& text) -> Problem {
    const render::Name* found = find_name(table, text);
    if (found == nullptr) return unknown_name(text, names_of(table));
    at(request, field) = found->value;
    return std::nullopt;
  };
}

template <typename Field>
Take flag(Field field) {
  return [=](Request& request, const std::string& text) -> Problem {
    if (text != "true" && text != "false") return fmt::format("\"{}\" is neither true nor false", text);
    at(request, field) = text == "true";
    return std::nullopt;
  };
}

/// Text that is understood when the scene is known.
template <typename Field>
Take text_for(Field field) {
  return [=](Request& request, const std::string& text) -> Problem {
    if (text.empty()) return "the value is empty";
    at(request, field) = text;
    return std::nullopt;
  };
}

std::string list_of(render::Names table) {
  return fmt::format("{}", fmt::join(names_of(table), ", "));
}

/// One of the names of a table, kept as text.
template <typename Field>
Take name_in(Field field, render::Names table) {
  return [=](Request& request, const std::string& text) -> Problem {
    if (find_name(table, text) == nullptr) return unknown_name(text, names_of(table));
    at(request, field) = text;
    return std::nullopt;
  };
}

std::vector<Setting> make_table() {
  return {
      {"integrator", list_of(names::INTEGRATORS), name_in(&Request::integrator, names::INTEGRATORS)},
      {"techniques", "a list of " + list_of(names::TECHNIQUES), text_for(&Request::techniques)},
      {"settings-from", "an OpenEXR picture of a render", text_for(&Request::settings_from)},
      {"light-paths", "per iteration, 1 to 2^28", whole(&RenderSettings::light_paths, 1, 1u << 28)},
      {"light-sampling", list_of(names::LIGHT_SAMPLING),
       choice(&RenderSettings::light_sampling, names::LIGHT_SAMPLING)},
      {"guide", list_of(names::LIGHT_GUIDE), choice(&RenderSettings::walk_guide, names::LIGHT_GUIDE)},
      {"guide-light", list_of(names::LIGHT_GUIDE), choice(&RenderSettings::light_guide, names::LIGHT_GUIDE)},
      {"shadow-roulette", "off, auto, or a radiance above 0", text_for(&Request::shadow_roulette)},
      {"connections", "paired, or cache:M with M from 1 to 1024", text_for(&Request::connections)},
      {"merge-radius", "metres, or percent of the extent seen, as in 0.3%", text_for(&Request::merge_radius)},
      {"merge-reduction", "0 to 0.5", number_in(&RenderSettings::merge_reduction, 0, 0.5)},
      {"regularization", list_of(names::REGULARIZATION),
       choice(&Request::regularization, names::REGULARIZATION)},
      {"tau", "1/sr, above 0, or inf", positive_or_infinite(&RenderSettings::tau)},
      {"bound", list_of(names::BOUND), choice(&RenderSettings::bound, names::BOUND)},
      {"tau-schedule", list_of(names::TAU_SCHEDULE), choice(&Request::tau_schedule, names::TAU_SCHEDULE)},
      {"diffusion", list_of(names::DIFFUSION), choice(&Request::diffusion, names::DIFFUSION)},
      {"sampler-quality", list_of(names::SAMPLER_QUALITY),
       choice(&RenderSettings::sampler_quality, names::SAMPLER_QUALITY)},
      {"mis", list_of(names::MIS), choice(&RenderSettings::mis, names::MIS)},
      {"clamp", "above 0, or inf", positive_or_infinite(&RenderSettings::largest_contribution)},
      {"spp", fmt::format("1 to {}", MAX_SAMPLES), whole(&RenderSettings::samples, 1, MAX_SAMPLES)},
      {"samples", "FIRST:COUNT", text_for(&Request::sample_range)},
      {"time", "seconds", number_in(&Request::time_limit, 0, 1e9)},
      {"noise", "relative error, 0 to 1000", number_in(&Request::noise_target, 0, 1e3)},
      {"size", fmt::format("WIDTHxHEIGHT, pixels, sides up to {}", scene::MAX_FILM_SIDE),
       text_for(&Request::size)},
      {"crop", "x0,y0,x1,y1, pixels from the top left, x1 and y1 excluded", text_for(&Request::crop)},
      {"aov", fmt::format("a list of {}", fmt::join(render::known_aovs(), ", ")), text_for(&Request::aovs)},
      {"camera", "name or index", text_for(&Request::camera)},
      {"max-depth", "path edges, 1 to 1024", whole(&RenderSettings::max_depth, 1, 1024)},
      {"seed", "0 to 2^32 - 1", whole(&RenderSettings::seed, 0, UINT32_MAX)},
      {"sampler", list_of(names::SAMPLER), choice(&RenderSettings::sampler, names::SAMPLER)},
      {"ndf", list_of(names::NDF), choice(&RenderSettings::ndf, names::NDF)},
      {"shadowing", list_of(names::SHADOWING), choice(&RenderSettings::shadowing, names::SHADOWING)},
      {"energy-compensation", "true or false", flag(&RenderSettings::has_energy_compensation)},
      {"filter", list_of(names::FILTER), choice(&RenderSettings::filter, names::FILTER)},
      {"filter-radius", "pixels, 0 to 16", number_in(&Request::filter_radius, 0, 16)},
      {"rays", list_of(names::RAYS), choice(&RenderSettings::rays, names::RAYS)},
      {"wave", "paths in flight, 0: chosen for the device",
       whole(&RenderSettings::wave_paths, 0, UINT32_MAX)},
      {"band", "pixels rendered at once, 0: as the device's buffers hold",
       whole(&Request::band_pixels, 0, UINT32_MAX)},
  };
}

// Which samples, and how they are rendered: not a scene's business.
const std::set<std::string_view> NOT_OF_SCENES = {"samples", "rays", "wave", "settings-from"};
// What the loader reads of scenes[].extras.regulus, and what only the command line has.
const std::set<std::string_view> READ_ELSEWHERE = {"environment", "variant", "animation", "at",
                                                   "frames",      "fps",     "exposure"};

std::vector<std::string> setting_names() {
  std::vector<std::string> result;
  for (const Setting& setting : known_settings()) result.emplace_back(setting.name);
  return result;
}

bool asks_for_stop(const std::map<std::string, std::string>& values) {
  return values.contains("time") || values.contains("noise");
}

}  // namespace

std::span<const Setting> known_settings() {
  static const std::vector<Setting> table = make_table();
  return table;
}

const Setting& find_setting(const std::string& name) {
  for (const Setting& setting : known_settings())
    if (setting.name == name) return setting;
  throw SettingError(name, "", "there is no such setting" + suggest(name, setting_names()));
}

Request make_request(const std::map<std::string, std::string>& values) {
  Request request;
  for (const auto& [name, value] : values)
    if (const Problem problem = find_setting(name).take(request, value))
      throw SettingError(name, "", *problem);
  request.has_no_sample_limit =
      asks_for_stop(values) && !values.contains("spp") && !values.contains("samples");
  return request;
}

std::map<std::string, std::string> with_scene_settings(std::map<std::string, std::string> values,
                                                       const scene::Scene& scene,
                                                       std::vector<std::string>& warnings) {
  const bool has_own_stop = asks_for_stop(values) || values.contains("samples");
  for (const auto& [name, value] : scene.settings) {
    if (READ_ELSEWHERE.contains(name) || values.contains(name)) continue;
    const auto table = known_settings();
    const auto found = std::ranges::find(table, std::string_view(name), &Setting::name);
    if (found == table.end() || NOT_OF_SCENES.contains(name)) {
      warnings.push_back(
          printable(fmt::format("extras.regulus: \"{}\" is not a setting of a scene; ignored{}", name,
                                suggest(name, setting_names()))));
      continue;
    }
    Request scratch;
    if (const Problem problem = found->take(scratch, value))
      throw Error(ErrorCode::BadFile,
                  fmt::format("{}: extras.regulus.{}: {}", scene.path.string(), name, *problem));
    if (name == "spp" && has_own_stop) continue;
    values.emplace(name, value);
  }
  return values;
}

}  // namespace regulus::session
