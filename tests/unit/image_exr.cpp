// OpenEXR: what is written is read back bit for bit, and every layout that we promise to read is read.
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfOutputFile.h>

#include <bit>
#include <cmath>
#include <limits>

#include "image_files.hpp"
#include "support/random.hpp"

namespace regulus::test {
namespace {

/// Expects equal bit patterns, NaN payloads and signs of zero included.
void expect_same_bits(const image::Image& a, const image::Image& b) {
  ASSERT_EQ(a.width, b.width);
  ASSERT_EQ(a.height, b.height);
  ASSERT_EQ(a.rgb.size(), b.rgb.size());
  size_t different = 0;
  for (size_t i = 0; i < a.rgb.size(); ++i)
    different += std::bit_cast<uint32_t>(a.rgb[i]) != std::bit_cast<uint32_t>(b.rgb[i]);
  EXPECT_EQ(different, 0u);
}

TEST(Exr, EveryBitPatternSurvives) {
  const TemporaryFolder folder;
  Random random(1);
  image::Image image = make_image(
      67, 35, [&](size_t) { return std::bit_cast<float>(static_cast<uint32_t>(random.uniform() * 0x1p32)); });
  using Limits = std::numeric_limits<float>;
  const float special[] = {0.0f,
                           -0.0f,
                           Limits::denorm_min(),
                           -Limits::denorm_min(),
                           Limits::min(),
                           Limits::max(),
                           Limits::infinity(),
                           -Limits::infinity(),
                           1e-40f,
                           Limits::lowest(),
                           Limits::quiet_NaN()};
  std::copy(std::begin(special), std::end(special), image.rgb.begin());
  image::write_exr(folder / "bits.exr", image);
  expect_same_bits(image, image::read_exr(folder / "bits.exr"));
  EXPECT_EQ(folder.file_count(), 1u) << "a temporary file was left";
}

TEST(Exr, OnePixelAndOneRow) {
  const TemporaryFolder folder;
  for (const auto& [width, height] : {std::pair{1u, 1u}, {1u, 40u}, {300u, 1u}}) {
    const image::Image image = make_image(width, height, [](size_t i) { return static_cast<float>(i) / 7; });
    image::write_exr(folder / "thin.exr", image);
    expect_same_bits(image, image::read_exr(folder / "thin.exr"));
  }
}

TEST(Exr, AttributesAndExtraChannelsAreStoredUnderTheirNames) {
  const TemporaryFolder folder;
  const image::Image image = make_image(4, 3, [](size_t i) { return static_cast<float>(i); });
  const image::Attributes attributes = {{"regulus:seed", "18446744073709551615"},
                                        {"regulus:a-name-that-is-longer-than-thirty-one-characters", "long"},
                                        {"regulus:empty", ""},
                                        {"regulus:text", "two\nlines, \xC3\xBC"}};
  std::vector<float> depth(12);
  for (size_t i = 0; i < depth.size(); ++i) depth[i] = 100.0f - static_cast<float>(i);
  image::write_exr(folder / "a.exr", image, attributes, {{"Z", depth}, {"albedo.R", depth}});

  image::Attributes read;
  expect_same_bits(image, image::read_exr(folder / "a.exr", &read));
  EXPECT_EQ(read, attributes);

  Imf::InputFile file((folder / "a.exr").c_str());
  EXPECT_EQ(file.header().compression(), Imf::ZIP_COMPRESSION);
  std::string names;
  for (auto c = file.header().channels().begin(); c != file.header().channels().end(); ++c) {
    names += std::string(c.name()) + " ";
    EXPECT_EQ(c.channel().type, Imf::FLOAT) << c.name();
  }
  EXPECT_EQ(names, "B G R Z albedo.R ");
  std::vector<float> z(12);
  Imf::FrameBuffer pixels;
  pixels.insert("Z", Imf::Slice::Make(Imf::FLOAT, z.data(), file.header().dataWindow()));
  file.setFrameBuffer(pixels);
  file.readPixels(0, 2);
  EXPECT_EQ(z, depth);
}

/// Writes a half-float file with the given channels, pixel value = 1 + channel index + 16 * pixel index.
void write_half(const std::filesystem::path& path, const std::vector<std::string>& names,
                const Imath::Box2i& data_window, Imf::Compression compression) {
  Imf::Header header(Imath::Box2i({0, 0}, {99, 99}), data_window);
  header.compression() = compression;
  const auto count = static_cast<size_t>((data_window.max.x - data_window.min.x + 1) *
                                         (data_window.max.y - data_window.min.y + 1));
  std::vector<std::vector<half>> values;
  for (size_t c = 0; c < names.size(); ++c) {
    header.channels().insert(names[c], Imf::Channel(Imf::HALF));
    values.emplace_back();
    for (size_t i = 0; i < count; ++i) values.back().emplace_back(1.0f + float(c) + 16.0f * float(i));
  }
  Imf::FrameBuffer pixels;
  for (size_t c = 0; c < names.size(); ++c)
    pixels.insert(names[c], Imf::Slice::Make(Imf::HALF, values[c].data(), data_window));
  Imf::OutputFile file(path.c_str(), header);
  file.setFrameBuffer(pixels);
  file.writePixels(data_window.max.y - data_window.min.y + 1);
}

TEST(Exr, ReadsHalfInAnOffsetDataWindow) {
  const TemporaryFolder folder;
  for (const Imf::Compression compression :
       {Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION, Imf::ZIPS_COMPRESSION, Imf::PIZ_COMPRESSION}) {
    write_half(folder / "half.exr", {"R", "G", "B", "A"}, Imath::Box2i({-3, 5}, {1, 7}), compression);
    const image::Image image = image::read_exr(folder / "half.exr");
    ASSERT_EQ(image.width, 5u);
    ASSERT_EQ(image.height, 3u);
    EXPECT_EQ(image.largest_finite, 65504);
    for (size_t i = 0; i < image.rgb.size(); ++i)
      ASSERT_EQ(image.rgb[i], 1.0f + static_cast<float>(i % 3) + 16.0f * static_cast<float>(i / 3));
  }
}

TEST(Exr, ReadsBlackImagesThatCompressBest) {
  const TemporaryFolder folder;
  for (const Imf::Compression compression :
       {Imf::ZIP_COMPRESSION, Imf::PIZ_COMPRESSION, Imf::PXR24_COMPRESSION, Imf::B44A_COMPRESSION,
        Imf::DWAA_COMPRESSION, Imf::DWAB_COMPRESSION}) {
    constexpr int SIZE = 2048;
    Imf::Header header(SIZE, SIZE);
    header.compression() = compression;
    const std::vector<float> black(size_t{SIZE} * SIZE);
    Imf::FrameBuffer pixels;
    for (const char* name : {"R", "G", "B"}) {
      header.channels().insert(name, Imf::Channel(Imf::FLOAT));
      pixels.insert(name, Imf::Slice::Make(Imf::FLOAT, black.data(), header.dataWindow()));
    }
    {
      Imf::OutputFile file((folder / "black.exr").c_str(), header);
      file.setFrameBuffer(pixels);
      file.writePixels(SIZE);
    }
    std::printf("compression %d: %.0f bytes of pixels in a byte of file\n", compression,
                12.0 * SIZE * SIZE / static_cast<double>(std::filesystem::file_size(folder / "black.exr")));
    EXPECT_EQ(image::read_exr(folder / "black.exr").width, uint32_t{SIZE}) << compression;
    std::filesystem::remove(folder / "black.exr");
  }
}

TEST(Exr, CopiesLuminanceToAllChannels) {
  const TemporaryFolder folder;
  write_half(folder / "y.exr", {"Y"}, Imath::Box2i({0, 0}, {3, 1}), Imf::ZIP_COMPRESSION);
  const image::Image image = image::read_exr(folder / "y.exr");
  ASSERT_EQ(image.rgb.size(), 24u);
  for (size_t i = 0; i < image.rgb.size(); ++i)
    EXPECT_EQ(image.rgb[i], 1.0f + 16.0f * static_cast<float>(i / 3));
}

TEST(Exr, ErrorsNameFileAndChannel) {
  const TemporaryFolder folder;
  write_half(folder / "rg.exr", {"R", "G"}, Imath::Box2i({0, 0}, {3, 1}), Imf::ZIP_COMPRESSION);
  expect_error([&] { image::read_exr(folder / "rg.exr"); }, ErrorCode::BadFile, "rg.exr: has no channel B");
  expect_error([&] { image::read_exr(folder / "none.exr"); }, ErrorCode::BadFile, "none.exr: no such file");
  expect_error([&] { image::read_exr(folder.path()); }, ErrorCode::BadFile, "is not a file");
}

TEST(Exr, RefusesInconsistentInput) {
  const TemporaryFolder folder;
  const image::Image image = make_image(4, 3, [](size_t) { return 1.0f; });
  expect_error(
      [&] {
        image::write_exr(folder / "a.exr", image, {}, {{"Z", std::vector<float>(11)}});
      },
      ErrorCode::Failed, "channel Z has 11 values instead of 12");
  expect_error([&] { image::write_exr(folder / "a.exr", image::Image{}); }, ErrorCode::Failed, "a.exr");
  expect_error(
      [&] {
        image::write_exr(folder / "a.exr", image, {{"channels", "taken"}});
      },
      ErrorCode::Failed, "a.exr");
  EXPECT_EQ(folder.file_count(), 0u);
}

}  // namespace
}  // namespace regulus::test
