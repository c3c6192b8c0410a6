// Version 1 of meshopt's attributes and the filter of colours, against streams that meshoptimizer 1.3.0 wrote
// (npm package meshoptimizer: encodeVertexBufferLevel with version 1, encodeFilterColor).
#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "scene/meshopt_attributes.hpp"

namespace regulus::scene::test {
namespace {

using Bytes = std::vector<unsigned char>;

Bytes from_hex(const std::string& text) {
  Bytes bytes;
  for (size_t i = 0; i < text.size(); i += 2)
    bytes.push_back(static_cast<unsigned char>(std::stoul(text.substr(i, 2), nullptr, 16)));
  return bytes;
}

uint32_t mixed(uint32_t i) {
  return i * 2654435761u;
}

struct Stream {
  const char* name;
  size_t count, stride;
  std::function<uint32_t(uint32_t)> word;  // of the elements, one after the other
  const char* encoded;
};

std::vector<Stream> streams() {
  return {
      {"bytes whose deltas are packed in 1, 4 and 8 bits", 40, 4,
       [](uint32_t i) { return (i & 1) | (mixed(i) >> 24) << 8 | 255u << 16 | (i * 3 & 255) << 24; },
       "a16d1526666666666666666666000000c3c3c3c3c1c3c3c3c3c1c3c3c3c1c3c3c3c3c1c3c3c3c3c1c3c3c3c1c3c3c3c3c1c3c"
       "3c3c1c3c32a"
       "066666666666666666666666666666666666666600000000000000000000000000000000000000000000000000ff0000"},
      {"deltas of two bytes", 40, 4,
       [](uint32_t i) { return ((i * 300) & 0xFFFF) | ((70000 - i * 257) & 0xFFFF) << 16; },
       "a15700585858585858585858585858585858585858585858585858585858585858585858585858585858152aaaaaaaaaaaaaa"
       "aaaaa00001515"
       "5555555555555555550000152aaaaaaaaaaaaaaaaaaa0000000000000000000000000000000000000000000000701101"},
      {"differences of four bytes, turned by four bits", 40, 4,
       [](uint32_t i) { return (i * i * 7) << 12 ^ (mixed(i >> 2) & 0x80000000u); },
       "a179001011080808011108080801000800071b234fdf53ab97f78bf3bf6fc37b27e73b032fff334bb7d76b939f8f63db47c75"
       "be30f1f13eb19"
       "0001313703070310f136131f3163e20f1edbbb0000063e060e000000000000000000000000000000000000000000000042"},
      {"literal bytes", 20, 4, [](uint32_t i) { return mixed(mixed(i) ^ 0x9e3779b9u); },
       "a1ff00c1393e39c1393e59c1393e39c1393e593ec63e0068913e912f0a1ad40fb13e91680a7dd45f411e003247044748c4d5d"
       "4818204474fc4"
       "3db4c701f10000bf73bfd4d040a73bc873bf08d2f524661c7d00000000000000000000000000000000000000e999a2f100"},
      {"two blocks of two channels", 300, 8, [](uint32_t i) { return (i & 1) != 0 ? 42 : (i >> 1) * 5; },
       "a1a9aaaaaaaaaa0aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa"
       "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa"
       "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa"
       "a9aa2aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa0000000000000000000000000000000000000000"
       "2a0000000100"},
  };
}

Bytes elements_of(const Stream& stream) {
  Bytes bytes(stream.count * stream.stride);
  for (uint32_t i = 0; i < bytes.size() / 4; ++i) {
    const uint32_t word = stream.word(i);
    std::memcpy(&bytes[4 * i], &word, 4);
  }
  return bytes;
}

TEST(SceneMeshopt, StreamsOfTheLibraryDecodeToWhatWentIn) {
  for (const Stream& stream : streams()) {
    Bytes decoded(stream.count * stream.stride);
    ASSERT_TRUE(decode_meshopt_attributes(decoded, stream.stride, from_hex(stream.encoded))) << stream.name;
    EXPECT_EQ(decoded, elements_of(stream)) << stream.name;
  }
}

TEST(SceneMeshopt, StreamsThatEndEarlyOrLateAreRefused) {
  for (const Stream& stream : streams()) {
    const Bytes encoded = from_hex(stream.encoded);
    Bytes decoded(stream.count * stream.stride);
    for (size_t cut = 1; cut + 1 < encoded.size(); ++cut) {
      Bytes shorter = encoded;
      shorter.erase(shorter.begin() + static_cast<std::ptrdiff_t>(encoded.size() / 2),
                    shorter.begin() +
                        static_cast<std::ptrdiff_t>(encoded.size() / 2 + std::min(cut, encoded.size() / 2)));
      decode_meshopt_attributes(decoded, stream.stride, shorter);  // whatever it holds: no crash
      EXPECT_FALSE(
          decode_meshopt_attributes(decoded, stream.stride, Bytes(encoded.begin(), encoded.begin() + 20)));
    }
    Bytes longer = encoded;
    longer.insert(longer.begin() + 5, 200, 0);
    EXPECT_FALSE(decode_meshopt_attributes(decoded, stream.stride, longer)) << stream.name;
    Bytes unknown_mode = encoded;
    unknown_mode.back() = 3;
    EXPECT_FALSE(decode_meshopt_attributes(decoded, stream.stride, unknown_mode)) << stream.name;
  }
}

TEST(SceneMeshopt, AnyBytesAreTaken) {
  for (uint32_t seed = 1; seed <= 3000; ++seed) {
    Bytes noise(30 + seed % 200);
    for (size_t i = 0; i < noise.size(); ++i)
      noise[i] = static_cast<unsigned char>(mixed(seed * 977 + static_cast<uint32_t>(i)) >> 23);
    noise[0] = MESHOPT_ATTRIBUTES_1;
    const size_t stride = 4 * (1 + seed % 64);
    for (size_t channel = 0; channel < stride / 4 && channel < noise.size(); ++channel)
      noise[noise.size() - 1 - channel] = static_cast<unsigned char>(seed % 3);
    Bytes decoded(stride * (seed % 300));
    decode_meshopt_attributes(decoded, stride, noise);
  }
}

// Colours r = i / 5, g = 1 - i / 5, b = 0 or 1/2, a falling by a tenth and last 0, within a step of the bits
// that were kept.
TEST(SceneMeshopt, ColoursAreThoseThatWentIn) {
  const auto expected = [](int i, int channel) {
    const double alpha = i == 5 ? 0 : 1 - 0.1 * i;
    const double rgba[4] = {i / 5.0, 1 - i / 5.0, 0.5 * (i % 2), alpha};
    return rgba[channel];
  };
  Bytes narrow = from_hex("7f007fff93da39f3663333e6790cedd94d66e7cc603fa180");
  decode_meshopt_colors(narrow, 4);
  Bytes wide = from_hex(
      "ff070000ff07ff0f33099afd9903330f660633033303660e9907cc00cdfe990dcd04660667fecc0c0006ff0301fa0008");
  decode_meshopt_colors(wide, 8);
  for (int i = 0; i < 6; ++i)
    for (int channel = 0; channel < 4; ++channel) {
      const auto at = static_cast<size_t>(4 * i + channel);
      EXPECT_NEAR(narrow[at] / 255.0, expected(i, channel), 2.0 / 255) << i << " " << channel;
      uint16_t value = 0;
      std::memcpy(&value, &wide[2 * at], 2);
      EXPECT_NEAR(value / 65535.0, expected(i, channel), 2.0 / 4095) << i << " " << channel;
    }
}

}  // namespace
}  // namespace regulus::scene::test
