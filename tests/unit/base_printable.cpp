// Text of unknown origin on a terminal.
#include <gtest/gtest.h>

#include "base/error.hpp"
#include "base/printable.hpp"

namespace regulus::test {
namespace {

TEST(Printable, TextStaysAsItIs) {
  for (const char* text : {"", "chair 'Räuber' 椅子 🪑", "a\\b %s \"c\" ~"})
    EXPECT_EQ(printable(text), text);
}

TEST(Printable, WhatTerminalsObeyIsWrittenOut) {
  EXPECT_EQ(printable("\x1b]0;owned\x07"), "\\x1b]0;owned\\x07");
  EXPECT_EQ(printable("a\nb\tc\rd"), "a b c d");
  EXPECT_EQ(printable("\x7f"), "\\x7f");
  EXPECT_EQ(printable("\xc2\x9b"), "\\xc2\\x9b") << "the 8-bit CSI as UTF-8";
  EXPECT_EQ(printable("\x9b"), "\\x9b") << "and as a byte";
  EXPECT_EQ(printable("\xe2\x80\xae"), "\\xe2\\x80\\xae") << "right-to-left override";
  EXPECT_EQ(printable(std::string_view("\0", 1)), "\\x00");
}

TEST(Printable, BytesThatAreNoUtf8AreWrittenOut) {
  EXPECT_EQ(printable("\xff"), "\\xff");
  EXPECT_EQ(printable("\xc3"), "\\xc3") << "cut off";
  EXPECT_EQ(printable("\xc0\xaf"), "\\xc0\\xaf") << "longer than needed";
  EXPECT_EQ(printable("\xed\xa0\x80"), "\\xed\\xa0\\x80") << "a surrogate";
  EXPECT_EQ(printable("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80") << "beyond the last code";
}

TEST(Printable, EveryByteAndPairIsPrintable) {
  for (int first = 0; first < 256; ++first)
    for (int second = 0; second < 256; ++second)
      for (const char c : printable(std::string{static_cast<char>(first), static_cast<char>(second)}))
        ASSERT_TRUE(static_cast<unsigned char>(c) >= 0x20 && c != 0x7f) << first << " " << second;
}

TEST(Printable, ErrorsAre) {
  EXPECT_STREQ(Error(ErrorCode::BadFile, "node '\x1b[2J'\n").what(), "node '\\x1b[2J' ");
}

}  // namespace
}  // namespace regulus::test
