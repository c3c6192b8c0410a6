// Displays and views of OpenColorIO (opencolorio.org), where Regulus was built with it.
#pragma once

#include <array>
#include <memory>
#include <string>

namespace regulus::image {

/// True if this program was built with OpenColorIO.
bool has_color_configs();

/// What a config makes of linear light for one of its displays.
class ColorTransform {
 public:
  /// @param config a file (.ocio), or the name of one that the library has built in ("ocio://default", from
  ///   version 2.2 on)
  /// @param display empty: the config's default one
  /// @param view empty: the display's default one
  /// @throws regulus::Error (BadUsage, BadFile) that names the config, and lists what there is where a name
  ///   is unknown or no color space for linear Rec. 709 can be found
  ColorTransform(const std::string& config, const std::string& display, const std::string& view);
  ~ColorTransform();
  ColorTransform(const ColorTransform&) = delete;
  ColorTransform& operator=(const ColorTransform&) = delete;

  /// Linear Rec. 709 to what the display shows, each channel within [0, 1]; NaN becomes 0.
  std::array<float, 3> operator()(const std::array<float, 3>& linear) const;

  /// "display / view", as they were chosen.
  const std::string& name() const { return name_; }
  /// What had to be assumed of the config, which may not be so; empty: nothing.
  const std::string& warning() const { return warning_; }

 private:
  struct Impl;
  std::unique_ptr<const Impl> impl_;
  std::string name_;
  std::string warning_;
};

}  // namespace regulus::image
