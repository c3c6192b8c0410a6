// What tests do otherwise under sanitizers.
#pragma once

#include <gtest/gtest.h>

namespace regulus::test {

/// Under sanitizers everything takes ten times as long, and it is they that look.
#ifdef __SANITIZE_ADDRESS__
inline constexpr bool IS_SANITIZED = true;
#else
inline constexpr bool IS_SANITIZED = false;
#endif

/// Skips a case that only draws many more samples of code that other cases run under sanitizers.
#define REGULUS_SKIP_UNDER_SANITIZERS() \
  if (::regulus::test::IS_SANITIZED) GTEST_SKIP() << "statistics, without sanitizers"

}  // namespace regulus::test
