// What a render is asked to do, as names and values: those of the options of `regulus render` and of
// scenes[].extras.regulus in a scene's file.
#pragma once

#include <concepts>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace regulus {

/// A setting there is.
struct SettingDescription {
  std::string name;    ///< such as "integrator"
  std::string values;  ///< what it takes, in words, with units
};

/// Settings by name. What is not set is the scene's (extras.regulus), or else the default of the command
/// line.
///
///     Settings settings;
///     settings.set("integrator", "vcm").set("spp", 64).set("size", "640x360").set("aov", "albedo,Z");
class Settings {
 public:
  /// Sets a value, in place of an earlier one. What needs a scene to be understood (camera, size, crop) is
  /// checked by make_plan(), the rest at once. @throws SettingError
  Settings& set(const std::string& name, const std::string& value);
  /// Sets a value given as text.
  Settings& set(const std::string& name, const char* value) { return set(name, std::string(value)); }
  /// Sets a flag.
  Settings& set(const std::string& name, bool value) { return set(name, value ? "true" : "false"); }
  /// Sets a whole number.
  template <std::integral Number>
  Settings& set(const std::string& name, Number value) {
    return set(name, std::to_string(value));
  }
  /// Sets a number, which keeps all its digits.
  Settings& set(const std::string& name, double value);

  /// Leaves a setting to the scene and the defaults again.
  Settings& unset(const std::string& name);

  /// What has been set.
  const std::map<std::string, std::string>& values() const { return values_; }

  /// All settings there are.
  static std::vector<SettingDescription> known();

 private:
  std::map<std::string, std::string> values_;
};

}  // namespace regulus
