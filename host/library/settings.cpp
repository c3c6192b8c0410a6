#include "regulus/settings.hpp"

#include <fmt/format.h>

#include "regulus/error.hpp"
#include "session/request.hpp"

namespace regulus {

Settings& Settings::set(const std::string& name, const std::string& value) {
  session::make_request({{name, value}});
  values_[name] = value;
  return *this;
}

Settings& Settings::set(const std::string& name, double value) {
  return set(name, fmt::format("{}", value));
}

Settings& Settings::unset(const std::string& name) {
  session::find_setting(name);
  values_.erase(name);
  return *this;
}

std::vector<SettingDescription> Settings::known() {
  std::vector<SettingDescription> result;
  for (const session::Setting& setting : session::known_settings())
    result.push_back({std::string(setting.name), setting.values});
  return result;
}

}  // namespace regulus
