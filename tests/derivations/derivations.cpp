// The programs behind docs/mathematics.md, run again: every number they print is the one that stands beside
// them, and so the one that the text quotes. Their random numbers are seeded.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace {

// What a command prints.
std::string output_of(const std::string& command) {
  std::string text;
  FILE* pipe = popen(command.c_str(), "r");
  if (!pipe) return text;
  char block[4096];
  while (const size_t read = fread(block, 1, sizeof block, pipe)) text.append(block, read);
  EXPECT_EQ(pclose(pipe), 0) << command;
  return text;
}

// The numbers of a text, in order.
std::vector<double> numbers_of(const std::string& text) {
  std::vector<double> numbers;
  const char* at = text.c_str();
  while (*at) {
    char* end = nullptr;
    const double number = std::strtod(at, &end);
    if (end == at) {
      ++at;
      continue;
    }
    numbers.push_back(number);
    at = end;
  }
  return numbers;
}

struct Derivation {
  const char* name;
  bool is_slow;  // more than 5 CPU seconds
};

class Derivations : public testing::TestWithParam<Derivation> {};

// Another library may round a function's last bit otherwise, which moves a sample or two of a hundred
// thousand: the bound allows a thousandth, and errors of rounding that a program itself prints (below 1e-14)
// to be others.
TEST_P(Derivations, PrintWhatStandsBesideThem) {
  const auto [name, is_slow] = GetParam();
  if (is_slow && !std::getenv("REGULUS_FULL_TESTS"))
    GTEST_SKIP() << "slow: runs with cmake/bootstrap test --full";
  const std::string recorded_file = fmt::format("{}/docs/derivations/{}.out", REGULUS_SOURCE_DIR, name);
  std::ifstream file(recorded_file);
  std::stringstream recorded;
  recorded << file.rdbuf();
  const std::vector<double> expected = numbers_of(recorded.str());
  const std::vector<double> printed =
      numbers_of(output_of(fmt::format("{}/derivation_{}", REGULUS_DERIVATIONS, name)));
  ASSERT_FALSE(expected.empty());
  ASSERT_EQ(printed.size(), expected.size());
  for (size_t i = 0; i < expected.size(); ++i) {
    if (printed[i] == expected[i] || (std::isnan(printed[i]) && std::isnan(expected[i]))) continue;
    EXPECT_LE(std::abs(printed[i] - expected[i]), std::max(1e-3 * std::abs(expected[i]), 1e-14))
        << name << ", number " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Programs, Derivations,
                         testing::Values(Derivation{"albedo", false}, Derivation{"bounds", true},
                                         Derivation{"energy", false}, Derivation{"energy2", false},
                                         Derivation{"mis_check", false}, Derivation{"one_mirror", true},
                                         Derivation{"sigma", false}, Derivation{"two_mirror", true}),
                         [](const auto& each) { return std::string(each.param.name); });

}  // namespace
