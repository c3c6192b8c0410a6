// Views, automatic exposure and OpenEXR with fewer bits.
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "image/encoding.hpp"
#include "image/formats.hpp"
#include "unit/image_files.hpp"

namespace regulus::image {
namespace {

std::vector<View> all_views() {
  std::vector<View> views;
  for (const std::string& name : view_names()) views.push_back(view_of(name));
  return views;
}

TEST(Views, AreWithinTheScreenAndNeverFallWithLight) {
  for (const View view : all_views()) {
    float before = -1;
    for (int step = -200; step <= 200; ++step) {
      const float value = std::exp2(0.1F * static_cast<float>(step));
      const auto grey = display(view, {value, value, value});
      for (const float channel : grey) {
        EXPECT_GE(channel, 0);
        EXPECT_LE(channel, 1);
        EXPECT_NEAR(channel, grey[0], 2e-3) << "grey stays grey";
      }
      EXPECT_GE(grey[1], before - 1e-5F) << value;
      before = grey[1];
    }
    EXPECT_LT(display(view, {0, 0, 0})[1], 0.004F) << "black is black";
    EXPECT_GT(display(view, {1e30F, 1e30F, 1e30F})[1], 0.97F) << "the brightest light is white";
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    for (const float strange : {nan, -inf, inf, -3.0F})
      for (const float channel : display(view, {strange, 0.5F, strange}))
        EXPECT_TRUE(channel >= 0 && channel <= 1);
  }
}

// sRGB's curve takes 0.18 to 0.4613, 0.5 to 0.7354 (IEC 61966-2-1); Hable's takes 11.2 / 2 to white.
TEST(Views, HaveTheirKnownValues) {
  EXPECT_NEAR(display(View::Standard, {0.18F, 0.5F, 7})[0], 0.4613, 1e-4);
  EXPECT_NEAR(display(View::Standard, {0.18F, 0.5F, 7})[1], 0.7354, 1e-4);
  EXPECT_NEAR(display(View::Standard, {0.18F, 0.5F, 7})[2], 1, 1e-6);
  EXPECT_EQ(display(View::Neutral, {0.18F, 0.5F, 0.7F})[0], display(View::Standard, {0.18F, 0.5F, 0.7F})[0]);
  EXPECT_EQ(display(View::Raw, {0.25F, 0.5F, 7}), (std::array<float, 3>{0.25F, 0.5F, 1}));
  EXPECT_NEAR(display(View::Filmic, {5.6F, 5.6F, 5.6F})[0], 1, 1e-5);
  EXPECT_LT(display(View::Filmic, {5.5F, 5.5F, 5.5F})[0], 1);
}

// AgX: middle grey is near half of the encoded range, as in Sobotka's own transform; a bright primary turns
// towards white, where cutting off would leave it as it is.
TEST(Views, AgxTakesColourOffHighlights) {
  const float grey = display(View::Agx, {0.18F, 0.18F, 0.18F})[1];
  std::printf("AgX: 0.18 is shown as %.4f\n", static_cast<double>(grey));
  EXPECT_NEAR(grey, 0.4894, 0.008);
  const auto red = display(View::Agx, {20, 0, 0}), dim = display(View::Agx, {0.2F, 0, 0});
  EXPECT_GT(red[1], 0.4F);
  EXPECT_LT(dim[1], 0.2F);
  EXPECT_EQ(display(View::Standard, {20, 0, 0})[1], 0);
}

TEST(Exposure, BringsTheMeanLogarithmToMiddleGrey) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  // 0.09, 0.72: their mean logarithm is that of 0.2545..., and black and NaN do not count.
  const Image image{4, 1, {0.09F, 0.09F, 0.09F, 0.72F, 0.72F, 0.72F, 0, 0, 0, nan, 1, 1}};
  EXPECT_NEAR(automatic_exposure(image), std::log2(0.18 / std::sqrt(0.09 * 0.72)), 1e-5);
  EXPECT_EQ(automatic_exposure({1, 1, {0, 0, 0}}), 0);
}

TEST(Storage, HalvesRoundColoursAndKeepTheRest) {
  const test::TemporaryFolder folder;
  const std::vector<float> depths = {1.0F + 1e-6F, 1e6F};
  Image image{2, 1, {1.0F + 1e-6F, 1e6F, 0.333333F, -1e6F, 3, 65504}};
  const Channels channels = {{"Z", depths},
                             {"albedo.R", std::vector<float>{0.1F, 0.2F}},
                             {"CryptoObject00.R", std::vector<float>{-4.084619e15F, 2.790186e15F}},
                             {"material", std::vector<uint32_t>{7, 70'000}}};
  Encoding encoding;
  encoding.storage.has_half_floats = true;
  const auto file = folder.path() / "half.exr";
  test::write_bytes(
      file, encode_picture(Format::Exr, image, encoding, {{"regulus:seed", "3"}}, channels, {}, "half"));
  const Imf::InputFile stored(file.c_str());
  EXPECT_EQ(stored.header().channels()["albedo.R"].type, Imf::HALF);
  EXPECT_EQ(stored.header().channels()["CryptoObject00.R"].type, Imf::FLOAT) << "the bits are an id";
  Attributes attributes;
  const Image read = read_exr(file, &attributes);
  EXPECT_EQ(read.largest_finite, 65504) << "all colours are halves";
  EXPECT_EQ(attributes.at("regulus:seed"), "3");
  for (size_t i = 0; i < image.rgb.size(); ++i) {
    const float wanted = std::clamp(image.rgb[i], -65504.0F, 65504.0F);
    EXPECT_NEAR(read.rgb[i], wanted, std::abs(wanted) / 2048) << i;  // 11 bits, rounded
  }
}

TEST(Storage, DwaaIsSmallerAndNear) {
  Image image{64, 64, std::vector<float>(3 * 64 * 64)};
  for (size_t i = 0; i < image.rgb.size(); ++i)
    image.rgb[i] = 1 + 0.02F * std::sin(12.9898F * static_cast<float>(i));  // as noise: nothing repeats
  Encoding lossy;
  lossy.storage = {.has_half_floats = true, .is_dwaa = true};
  const std::string plain = encode_picture(Format::Exr, image, {}, {}, {}, {}, "a"),
                    small = encode_picture(Format::Exr, image, lossy, {}, {}, {}, "b");
  EXPECT_LT(small.size(), plain.size() / 2);
  const Image read = decode_exr("b", {reinterpret_cast<const unsigned char*>(small.data()), small.size()});
  for (size_t i = 0; i < image.rgb.size(); ++i) ASSERT_NEAR(read.rgb[i], image.rgb[i], 0.04F);
}

}  // namespace
}  // namespace regulus::image
