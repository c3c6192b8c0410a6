// Views of OpenColorIO by a config whose curves are known.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <vector>

#include "base/error.hpp"
#include "image/color_config.hpp"
#include "unit/image_files.hpp"

namespace regulus::image {
namespace {

/// Two views: the square root of light, and a quarter of it.
constexpr const char* CONFIG = R"(ocio_profile_version: 2
roles:
  default: LINEAR
  scene_linear: LINEAR
displays:
  Screen:
    - !<View> {name: Root, colorspace: root}
    - !<View> {name: Quarter, colorspace: quarter}
active_displays: [Screen]
active_views: [Root, Quarter]
colorspaces:
  - !<ColorSpace>
    name: LINEAR
  - !<ColorSpace>
    name: root
    from_scene_reference: !<ExponentTransform> {value: [0.5, 0.5, 0.5, 1]}
  - !<ColorSpace>
    name: quarter
    from_scene_reference: !<MatrixTransform> {matrix: [0.25, 0, 0, 0, 0, 0.25, 0, 0, 0, 0, 0.25, 0, 0, 0, 0, 1]}
)";

class ColorConfig : public testing::Test {
 protected:
  void SetUp() override {
    if (!has_color_configs()) GTEST_SKIP() << "built without OpenColorIO";
  }
  std::string write(const std::string& linear) {
    std::string text = CONFIG;
    const std::string place = "LINEAR";
    for (size_t at = text.find(place); at != std::string::npos; at = text.find(place, at + linear.size()))
      text.replace(at, place.size(), linear);
    std::ofstream(folder_ / "config.ocio") << text;
    return (folder_ / "config.ocio").string();
  }
  test::TemporaryFolder folder_;
};

std::string error_of(const std::string& config, const std::string& display, const std::string& view) {
  try {
    const ColorTransform transform(config, display, view);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST_F(ColorConfig, ViewsAreTheConfigs) {
  const std::string config = write("lin_rec709");
  const ColorTransform by_default(config, "", ""), quarter(config, "Screen", "Quarter");
  EXPECT_EQ(by_default.name(), "Screen / Root");
  EXPECT_EQ(quarter.name(), "Screen / Quarter");
  const auto root = by_default({0.25F, 0.04F, 0.81F});
  EXPECT_NEAR(root[0], 0.5, 1e-5);
  EXPECT_NEAR(root[1], 0.2, 1e-5);
  EXPECT_NEAR(root[2], 0.9, 1e-5);
  EXPECT_EQ(quarter({1, 2, 4}), (std::array<float, 3>{0.25F, 0.5F, 1}));
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  EXPECT_EQ(quarter({nan, -3, inf}), (std::array<float, 3>{0, 0, 1}));
}

// Whatever a config calls linear Rec. 709 is found; at last the role, and then it is said.
TEST_F(ColorConfig, LinearLightIsFoundUnderItsManyNames) {
  for (const char* name : {"Linear Rec.709 (sRGB)", "Utility - Linear - sRGB", "Linear", "any space"}) {
    const ColorTransform transform(write(name), "", "");
    EXPECT_NEAR(transform({0.25F, 0, 0})[0], 0.5, 1e-5) << name;
    const bool tells = std::string(name).find("Rec.709") != std::string::npos ||
                       std::string(name).find("sRGB") != std::string::npos;
    EXPECT_EQ(transform.warning().empty(), tells) << name;
    if (!tells) {
      EXPECT_NE(transform.warning().find(name), std::string::npos) << transform.warning();
    }
  }
}

// Configs whose scene-linear space has other primaries, and no space by a name that is known: what they say
// of the space in which light is exchanged decides. The view shows linear Rec. 709 again, by inverse
// matrices: of OpenColorIO's configs, and of IEC 61966-2-1.
TEST_F(ColorConfig, RolesTellWhereRec709Is) {
  const auto config_of = [&](const char* role, const char* to_rec709) {
    std::ofstream(folder_ / "roles.ocio") << R"(ocio_profile_version: 2
roles: {default: exchanged, scene_linear: wide, )"
                                          << role << R"(: exchanged}
displays: {Screen: [!<View> {name: Same, colorspace: same}]}
colorspaces:
  - !<ColorSpace> {name: exchanged}
  - !<ColorSpace>
    name: wide
    to_scene_reference: !<MatrixTransform> {matrix: [0.7, 0.1, 0.2, 0, 0, 0.9, 0.1, 0, 0, 0, 1, 0, 0, 0, 0, 1]}
  - !<ColorSpace>
    name: same
    from_scene_reference: !<MatrixTransform> {matrix: [)"
                                          << to_rec709 << ", 0, 0, 0, 1]}\n";
    return (folder_ / "roles.ocio").string();
  };
  const std::string from_aces =
      "2.52168618674388, -1.13413098823972, -0.387555198504164, 0, -0.276479914229922, 1.37271908766826, "
      "-0.096239173438334, 0, -0.0153780649660342, -0.152975335867399, 1.16835340083343, 0";
  const std::string from_xyz =
      "3.2409699419, -1.5373831776, -0.4986107603, 0, -0.9692436363, 1.8759675015, 0.0415550574, 0, "
      "0.0556300797, -0.2039769589, 1.0569715142, 0";
  const std::vector<std::array<float, 3>> colors = {
      {0.8F, 0, 0}, {0, 0.8F, 0}, {0, 0, 0.8F}, {0.1F, 0.5F, 1}};
  const auto expect_same = [&](const std::string& config) {
    const ColorTransform transform(config, "", "");
    EXPECT_EQ(transform.warning(), "");
    for (const auto& color : colors)
      for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(transform(color)[c], color[c], 1e-5) << c;
  };
  expect_same(config_of("aces_interchange", from_aces.c_str()));
  expect_same(config_of("XYZ", from_xyz.c_str()));
  // Without either role its scene-linear space is all there is.
  const ColorTransform other(config_of("rendering", from_aces.c_str()), "", "");
  EXPECT_NE(other.warning().find("wide is taken for linear Rec. 709"), std::string::npos) << other.warning();
}

TEST_F(ColorConfig, ErrorsNameTheConfigAndWhatThereIs) {
  const std::string config = write("lin_rec709");
  const auto expect = [](const std::string& error, std::initializer_list<const char*> words) {
    for (const char* word : words) EXPECT_NE(error.find(word), std::string::npos) << error;
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  };
  expect(error_of(config, "Screan", ""), {"config.ocio: display", "did you mean Screen?"});
  expect(error_of(config, "", "Rot"), {"config.ocio: view", "did you mean Root?"});
  expect(error_of((folder_ / "none.ocio").string(), "", ""), {"none.ocio", "OpenColorIO config"});
  std::ofstream(folder_ / "broken.ocio") << "ocio_profile_version: 2\ncolorspaces: [}\n";
  expect(error_of((folder_ / "broken.ocio").string(), "", ""), {"broken.ocio", "OpenColorIO config"});
}

// Versions before 2.2 have no configs built in.
TEST_F(ColorConfig, BuiltInConfigsAreUsedWhereThereAreSome) {
  const std::string error = error_of("ocio://default", "", "");
  if (error == "no error") {
    const ColorTransform transform("ocio://default", "", "");
    std::printf("built in: %s\n", transform.name().c_str());
    EXPECT_LT(transform({0, 0, 0})[1], 0.01F);
    EXPECT_GT(transform({1e3F, 1e3F, 1e3F})[1], 0.9F);
  } else {
    EXPECT_NE(error.find("ocio://default: OpenColorIO 2"), std::string::npos) << error;
    EXPECT_NE(error.find("name a file"), std::string::npos) << error;
  }
}

TEST(ColorConfigAbsent, SaysHowToHaveIt) {
  if (has_color_configs()) GTEST_SKIP() << "built with OpenColorIO";
  const std::string error = error_of("config.ocio", "", "");
  EXPECT_NE(error.find("libopencolorio-dev"), std::string::npos) << error;
}

}  // namespace
}  // namespace regulus::image
