// The fuzzers' corpus through their targets without a fuzzer: as it is, and with seeded damage for a while.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "fuzz/targets.hpp"

namespace regulus::fuzz {
namespace {

// Processor time of the damaged files of each target, and the most that one file may take (sanitizers
// multiply it).
constexpr double SECONDS_OF_DAMAGE = 1;
#if defined(__SANITIZE_ADDRESS__)
constexpr double MAX_SECONDS = 10;
#else
constexpr double MAX_SECONDS = 2;
#endif

double cpu_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

std::vector<std::string> corpus_of(const Target& target) {
  const auto folder = std::filesystem::path(REGULUS_SOURCE_DIR) / "tests" / "fuzz" / "corpus" / target.name;
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<std::string> corpus;
  for (const auto& file : files) {
    std::ifstream stream(file, std::ios::binary);
    corpus.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  }
  return corpus;
}

/// Flips, overwrites, moves, doubles or cuts off some bytes.
std::string damaged(std::string bytes, std::mt19937& random) {
  const auto below = [&](size_t bound) { return bound == 0 ? 0 : random() % bound; };
  for (size_t edits = 1 + below(6); edits > 0 && !bytes.empty(); --edits) {
    const size_t at = below(2) == 0 ? below(std::min<size_t>(bytes.size(), 64)) : below(bytes.size());
    const size_t length = std::min(bytes.size() - at, 1 + below(8));
    switch (below(6)) {
      case 0:
        bytes[at] = static_cast<char>(random());
        break;
      case 1:
        bytes.replace(at, length, length, below(2) == 0 ? '\xff' : '\0');
        break;
      case 2:
        bytes.insert(at, bytes, below(bytes.size()), length);
        break;
      case 3:
        bytes.erase(at, length);
        break;
      case 4:
        if (below(8) == 0) bytes.resize(at);
        break;
      default:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8)));
    }
  }
  return bytes;
}

bool read(const Target& target, const std::string& bytes, double& slowest) {
  const double start = cpu_seconds();
  const bool is_read = target.read({reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()});
  slowest = std::max(slowest, cpu_seconds() - start);
  return is_read;
}

class FuzzCorpus : public testing::TestWithParam<Target> {};

TEST_P(FuzzCorpus, IsReadOrRefused) {
  const std::vector<std::string> corpus = corpus_of(GetParam());
  ASSERT_FALSE(corpus.empty());
  size_t whole = 0, cases = 0, readable = 0;
  double slowest = 0;
  for (const std::string& bytes : corpus) whole += read(GetParam(), bytes, slowest) ? 1 : 0;
  EXPECT_GT(whole, 0u) << "a corpus that is refused as a whole tests nothing";
  std::mt19937 random(1);
  for (const double start = cpu_seconds(); cpu_seconds() - start < SECONDS_OF_DAMAGE; ++cases) {
    std::string bytes = damaged(corpus[random() % corpus.size()], random);
    readable += read(GetParam(), bytes, slowest) ? 1 : 0;
  }
  std::printf("%s: %zu of %zu files read; %zu of %zu damaged ones; slowest %.3f s (bound %.0f)\n",
              GetParam().name, whole, corpus.size(), readable, cases, slowest, MAX_SECONDS);
  EXPECT_LT(slowest, MAX_SECONDS);
}

INSTANTIATE_TEST_SUITE_P(Targets, FuzzCorpus, testing::ValuesIn(targets().begin(), targets().end()),
                         [](const auto& target) { return std::string(target.param.name); });

}  // namespace
}  // namespace regulus::fuzz
