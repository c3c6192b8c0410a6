// render --report: the page in a browser, with what it says held against the picture and the statistics.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "cli/browser.hpp"
#include "cli/process.hpp"
#include "cli/small_scenes.hpp"
#include "image/image.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

using nlohmann::json;

class Report : public testing::Test {
 protected:
  void SetUp() override {
    REGULUS_SKIP_WITHOUT_DEVICE();
    if (!Browser::is_installed()) GTEST_SKIP() << "no chromium on this machine";
    std::filesystem::create_directory(file("a <"));  // whose scene's path holds what ends a script
    write_lit_floor(file("a </script> floor.gltf"));
  }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }

  Finished render(const Arguments& more) const {
    Arguments arguments = {
        "render", file("a </script> floor.gltf"), "-o", file("a.exr"), "--report", file("page.html"),
        "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }
  std::string contents(const std::string& name) const {
    std::ifstream stream(file(name));
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  TemporaryFolder folder_;
};

size_t count(const std::string& text, const std::string& wanted) {
  size_t found = 0;
  for (size_t at = 0; (at = text.find(wanted, at)) != std::string::npos; at += wanted.size()) ++found;
  return found;
}

TEST_F(Report, ShowsThePictureAndWhatBecameOfIt) {
  ASSERT_EQ(render({"--size", "32x24", "-s", "32", "--stats", file("stats.json"), "--aov",
                    "albedo,N,Z,material,variance,samples"})
                .status,
            0);
  const json stats = json::parse(contents("stats.json"));
  const std::string page = contents("page.html");
  // Nothing to the outside but the name of SVG's namespace, which nobody fetches.
  EXPECT_EQ(count(page, "http"), count(page, "http://www.w3.org/2000/svg")) << page;
  EXPECT_EQ(count(page, "url("), 0u);

  Browser browser(folder_.path());
  browser.open("file://" + file("page.html"));
  ASSERT_TRUE(browser.wait_for("document.querySelector('#picture').width === 32"));
  if (const char* screenshot = std::getenv("REGULUS_TEST_SCREENSHOT")) browser.take_screenshot(screenshot);

  // The slider: the picture's middle as the PNG writer would show it. A mantissa of 8 bits is off by at most
  // half of 1/128, which by the sRGB curve's slope against its value (1/2.4) is 0.5 of 255; roundings of the
  // table and of bytes add 1.5.
  const image::Image image = image::read_exr(file("a.exr"));
  const size_t middle = 3 * (12 * 32 + 16);
  for (const double exposure : {0.0, 2.0, -3.0}) {
    browser.evaluate("(() => { const slider = document.querySelector('#exposure'); slider.value = " +
                     std::to_string(exposure) + "; slider.dispatchEvent(new Event('input')); })()");
    const json pixel = browser.evaluate(
        "(() => { const canvas = document.createElement('canvas'); const context = canvas.getContext('2d');"
        "context.drawImage(document.querySelector('#picture'), 0, 0);"
        "return Array.from(context.getImageData(16, 12, 1, 1).data); })()");
    const auto scale = static_cast<float>(std::exp2(exposure));
    const auto shown = image::tone_map(
        {scale * image.rgb[middle], scale * image.rgb[middle + 1], scale * image.rgb[middle + 2]});
    for (size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(pixel.at(c).get<double>(), 255 * image::srgb_encode(shown[c]), 2) << exposure;
  }

  const std::string text = browser.evaluate("document.body.innerText");
  for (const char* heading : {"Picture", "What was chosen, and why", "Convergence", "Time", "Rays and memory",
                              "Features", "Warnings"})
    EXPECT_EQ(browser.evaluate("[...document.querySelectorAll('h2')].filter(h => h.textContent === '" +
                               std::string(heading) + "').length"),
              1)
        << heading;
  EXPECT_NE(text.find("script> floor.gltf"), std::string::npos);
  EXPECT_NE(text.find(stats["settings"]["techniques_rule"].get<std::string>()), std::string::npos) << text;
  EXPECT_NE(text.find("estimated relative error"), std::string::npos) << text;
  for (const json& feature : stats["scene"]["features_absent"])
    EXPECT_EQ(browser.evaluate("document.querySelector('#skipped').textContent.includes('" +
                               feature.get<std::string>() + "')"),
              true)
        << feature;
  for (const json& stage : stats["stages"])
    EXPECT_NE(text.find(stage["name"].get<std::string>()), std::string::npos) << stage;
  // The film's states at 1, 1.5, 2.25, ... samples tell a curve.
  EXPECT_EQ(browser.evaluate("document.querySelectorAll('.curve').length"), 2);
  EXPECT_GE(browser.evaluate("report.convergence.length"), 3);
  EXPECT_EQ(browser.evaluate("report.convergence.at(-1).samples <= 32"), true);
  EXPECT_EQ(browser.evaluate("[...document.querySelectorAll('.strip figure')].map(f => "
                             "f.textContent.split(':')[0] + ' ' + f.querySelector('img').naturalWidth)"),
            json({"N 32", "Z 32", "albedo 32", "material 32", "samples 32", "variance 32"}));
  // A floor that the camera looks straight down at: its normal is +y, its albedo 0.5.
  const auto aov_pixel = [&](const char* name) {
    return browser.evaluate(
        "(() => { const canvas = document.createElement('canvas'); const context = canvas.getContext('2d');"
        "context.drawImage(document.querySelector('img[alt=\"" +
        std::string(name) +
        "\"]'), 0, 0); return Array.from(context.getImageData(16, 12, 1, 1).data).slice(0, 3); })()");
  };
  EXPECT_EQ(aov_pixel("N"), json({128, 255, 128}));
  EXPECT_EQ(aov_pixel("albedo"), json({188, 188, 188}));  // sRGB of 0.5
  EXPECT_TRUE(browser.console().empty()) << browser.console().front();
  for (const std::string& request : browser.requests())
    EXPECT_TRUE(request.starts_with("file://") || request.starts_with("data:")) << request;
}

TEST_F(Report, OfTheReferenceHasNoStages) {
  ASSERT_EQ(render({"--backend", "reference", "--size", "8x8", "-s", "1"}).status, 0);
  Browser browser(folder_.path());
  browser.open("file://" + file("page.html"));
  ASSERT_TRUE(browser.wait_for("document.querySelector('#picture').width === 8"));
  EXPECT_EQ(browser.evaluate("document.body.innerText.includes('scalar reference')"), true);
  EXPECT_TRUE(browser.console().empty()) << browser.console().front();
}

}  // namespace
}  // namespace regulus::test
