// The scenes in the repository are what their generator writes, byte for byte.
#include "image_files.hpp"

namespace regulus::test {
namespace {

namespace fs = std::filesystem;

const fs::path SCENES = fs::path(REGULUS_SOURCE_DIR) / "scenes";

/// Relative path -> bytes of every scene file below a folder.
std::map<std::string, std::string> scene_files(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder))
    if (entry.path().extension() == ".gltf" || entry.path().extension() == ".bin")
      files[fs::relative(entry.path(), folder).string()] = read_bytes(entry.path());
  return files;
}

TEST(Scenes, AreWhatTheGeneratorWrites) {
  if (std::system("command -v python3 >/dev/null") != 0) GTEST_SKIP() << "python3 is missing";
  const TemporaryFolder folder;
  const std::string command =
      "python3 '" + (SCENES / "generate.py").string() + "' --out '" + folder.path().string() + "'";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const std::map<std::string, std::string> committed = scene_files(SCENES),
                                           written = scene_files(folder.path());
  ASSERT_GE(committed.size(), 2u * 4) << "four scenes, two files each";
  for (const auto& [name, bytes] : committed)
    EXPECT_TRUE(written.contains(name) && written.at(name) == bytes)
        << name << " differs: run scenes/generate.py and commit the result";
  for (const auto& [name, bytes] : written)
    EXPECT_TRUE(committed.contains(name)) << name << " is not committed";
}

}  // namespace
}  // namespace regulus::test
