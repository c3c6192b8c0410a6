// Every glTF file of the shared assets loads or gives one line of error; no crash, no other exception.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <ctime>

#include "../support/sanitizers.hpp"
#include "../unit/scene_files.hpp"

namespace regulus::scene::test {
namespace {

// Processor time a file may take (a busy machine does not count); sanitizers multiply it.
constexpr double MAX_SECONDS = regulus::test::IS_SANITIZED ? 10 : 2;

std::vector<std::filesystem::path> corpus() {
  std::vector<std::filesystem::path> files;
  const std::filesystem::path folder = std::filesystem::path(REGULUS_ASSETS_DIR) / "gltf";
  if (!std::filesystem::exists(folder)) return files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.path().extension() == ".gltf" || entry.path().extension() == ".glb")
      files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

TEST(SceneCorpus, EveryFileLoadsOrSaysWhyNot) {
  const auto files = corpus();
  if (files.empty()) GTEST_SKIP() << "no corpus in " << REGULUS_ASSETS_DIR;
  size_t loaded = 0;
  double slowest = 0;
  for (const std::filesystem::path& file : files) {
    SCOPED_TRACE(file.string());
    const std::clock_t start = std::clock();
    std::string error;
    ASSERT_NO_THROW(error = error_of([&] {
                      Scene scene = load(file);
                      build_lights(scene);
                      find_features(scene);
                      make_camera(scene.cameras.at(0), 640, 480);
                    }));
    const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    slowest = std::max(slowest, seconds);
    EXPECT_LT(seconds, MAX_SECONDS);
    EXPECT_EQ(error.find("more than one line"), std::string::npos) << error;
    EXPECT_EQ(error.find("wrong exit status"), std::string::npos) << error;
    loaded += error.empty() ? 1 : 0;
  }
  std::printf("%zu files: %zu loaded, %zu refused; slowest %.2f s (bound %.0f)\n", files.size(), loaded,
              files.size() - loaded, slowest, MAX_SECONDS);
  EXPECT_GT(loaded, files.size() / 2);
}

}  // namespace
}  // namespace regulus::scene::test
