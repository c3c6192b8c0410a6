#include "image/color_config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/error.hpp"
#include "base/near_names.hpp"

#ifdef REGULUS_OPENCOLORIO
#include <OpenColorIO/OpenColorIO.h>
#endif

namespace regulus::image {

#ifdef REGULUS_OPENCOLORIO

namespace {

namespace ocio = OCIO_NAMESPACE;

// What configs call linear light with the primaries of Rec. 709, and nothing else: those of the library's own
// (CG and studio configs of ACES) first, then of ACES 1.x, of Blender and of others.
constexpr const char* LINEAR_REC709[] = {
    "lin_rec709_scene",           "Linear Rec.709 (sRGB)", "lin_rec709", "Utility - Linear - sRGB",
    "Utility - Linear - Rec.709", "Linear Rec.709",        "lin_srgb"};

// What is linear with primaries that nothing tells; old configs of Blender and Nuke mean those of Rec. 709.
const char* const SOME_LINEAR[] = {"Linear", "linear", ocio::ROLE_SCENE_LINEAR};

using Matrix = std::array<double, 16>;

// To ACES2065-1, white to white by Bradford's adaptation, as OpenColorIO's own configs have it.
constexpr Matrix REC709_TO_ACES = {0.439632981919491,
                                   0.382988698151554,
                                   0.177378319928955,
                                   0,
                                   0.0897764429588424,
                                   0.813439428748981,
                                   0.0967841282921771,
                                   0,
                                   0.0175411703831727,
                                   0.111546553302387,
                                   0.87091227631444,
                                   0,
                                   0,
                                   0,
                                   0,
                                   1};

// To CIE XYZ with the white of D65 (0.3127, 0.3290), from the chromaticities of ITU-R BT.709-6, table 1.
constexpr Matrix REC709_TO_XYZ = {0.412390799265959,
                                  0.357584339383878,
                                  0.180480788401834,
                                  0,
                                  0.21263900587151,
                                  0.715168678767756,
                                  0.0721923153607337,
                                  0,
                                  0.0193308187155918,
                                  0.119194779794626,
                                  0.950532152249661,
                                  0,
                                  0,
                                  0,
                                  0,
                                  1};

/// Where linear Rec. 709 enters a config.
struct Entrance {
  std::string space;
  const Matrix* matrix;  ///< to that space; none: null
  bool is_assumed;       ///< nothing tells the space's primaries
};

[[noreturn]] void fail(ErrorCode code, const std::string& config, const std::string& problem) {
  std::string line = problem;
  std::ranges::replace(line, '\n', ' ');
  throw Error(code, fmt::format("{}: {}", config, line));
}

ocio::ConstConfigRcPtr read_config(const std::string& name) {
  if (name.starts_with("ocio://") && OCIO_VERSION_HEX < 0x02020000)
    fail(ErrorCode::BadUsage, name,
         fmt::format("OpenColorIO {} has no configs built in, which 2.2 brought; name a file", OCIO_VERSION));
  ocio::SetLoggingLevel(ocio::LOGGING_LEVEL_NONE);
  try {
    ocio::ConstConfigRcPtr config = ocio::Config::CreateFromFile(name.c_str());
    config->validate();
    return config;
  } catch (const ocio::Exception& error) {
    fail(ErrorCode::BadFile, name, fmt::format("cannot be used as an OpenColorIO config ({})", error.what()));
  }
}

/// The asked one of the names, or the config's own choice.
std::string choose(const std::string& config, const char* what, const std::string& asked,
                   const std::string& otherwise, const std::vector<std::string>& names) {
  if (asked.empty()) {
    if (otherwise.empty()) fail(ErrorCode::BadFile, config, fmt::format("has no {}", what));
    return otherwise;
  }
  if (std::ranges::find(names, asked) == names.end())
    fail(ErrorCode::BadUsage, config, fmt::format("{}: {}", what, unknown_name(asked, names)));
  return asked;
}

// Spaces by their names first; then roles that say which primaries they have: OpenColorIO's for exchange
// between configs, and the one that Blender's configs had before there was that.
Entrance find_entrance(const std::string& config_name, const ocio::Config& config) {
  for (const char* name : LINEAR_REC709)
    if (config.getColorSpace(name)) return {name, nullptr, false};
  if (config.hasRole(ocio::ROLE_INTERCHANGE_SCENE))
    return {ocio::ROLE_INTERCHANGE_SCENE, &REC709_TO_ACES, false};
  if (config.hasRole("XYZ")) return {"XYZ", &REC709_TO_XYZ, false};
  for (const char* name : SOME_LINEAR)
    if (const auto space = config.getColorSpace(name)) return {space->getName(), nullptr, true};
  fail(ErrorCode::BadFile, config_name,
       "has no color space for linear Rec. 709: neither lin_rec709 nor the roles aces_interchange and "
       "scene_linear; add one");
}

ocio::ConstTransformRcPtr from_entrance(const Entrance& entrance,
                                        const ocio::DisplayViewTransformRcPtr& view) {
  view->setSrc(entrance.space.c_str());
  if (entrance.matrix == nullptr) return view;
  const auto matrix = ocio::MatrixTransform::Create();
  matrix->setMatrix(entrance.matrix->data());
  const auto both = ocio::GroupTransform::Create();
  both->appendTransform(matrix);
  both->appendTransform(view);
  return both;
}

}  // namespace

bool has_color_configs() {
  return true;
}

struct ColorTransform::Impl {
  ocio::ConstCPUProcessorRcPtr processor;
};

ColorTransform::ColorTransform(const std::string& config_name, const std::string& display,
                               const std::string& view) {
  const ocio::ConstConfigRcPtr config = read_config(config_name);
  std::vector<std::string> displays(static_cast<size_t>(config->getNumDisplays()));
  for (size_t i = 0; i < displays.size(); ++i) displays[i] = config->getDisplay(static_cast<int>(i));
  const std::string own_display =
      choose(config_name, "display", display, config->getDefaultDisplay(), displays);
  std::vector<std::string> views(static_cast<size_t>(config->getNumViews(own_display.c_str())));
  for (size_t i = 0; i < views.size(); ++i)
    views[i] = config->getView(own_display.c_str(), static_cast<int>(i));
  const std::string own_view =
      choose(config_name, "view", view, config->getDefaultView(own_display.c_str()), views);
  name_ = own_display + " / " + own_view;
  try {
    const auto transform = ocio::DisplayViewTransform::Create();
    const Entrance entrance = find_entrance(config_name, *config);
    transform->setDisplay(own_display.c_str());
    transform->setView(own_view.c_str());
    const auto processor = config->getProcessor(from_entrance(entrance, transform));
    impl_ = std::make_unique<Impl>(Impl{processor->getDefaultCPUProcessor()});
    if (entrance.is_assumed)
      warning_ = fmt::format(
          "{}: {} is taken for linear Rec. 709, because neither a color space's name nor the role "
          "aces_interchange tells where that is",
          config_name, entrance.space);
  } catch (const ocio::Exception& error) {
    fail(ErrorCode::BadFile, config_name, fmt::format("{} cannot be made ({})", name_, error.what()));
  }
}

std::array<float, 3> ColorTransform::operator()(const std::array<float, 3>& linear) const {
  std::array<float, 3> color = linear;
  constexpr float BRIGHTEST = 1e6F;  // keeps infinity out of what follows
  for (float& value : color) value = value > 0 ? std::min(value, BRIGHTEST) : 0;  // NaN becomes 0
  impl_->processor->applyRGB(color.data());
  for (float& value : color) value = value > 0 ? std::min(value, 1.0F) : 0;
  return color;
}

#else

bool has_color_configs() {
  return false;
}

struct ColorTransform::Impl {};

ColorTransform::ColorTransform(const std::string& config_name, const std::string&, const std::string&) {
  throw Error(
      ErrorCode::Failed,
      fmt::format("{}: this regulus was built without OpenColorIO; install libopencolorio-dev and build "
                  "it again, or choose a --view",
                  config_name));
}

std::array<float, 3> ColorTransform::operator()(const std::array<float, 3>& linear) const {
  return linear;
}

#endif

ColorTransform::~ColorTransform() = default;

}  // namespace regulus::image
