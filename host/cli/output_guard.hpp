// Keeps what a command writes apart from what it reads, and from what else it writes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <tuple>
#include <vector>

namespace regulus::cli {

/// Files are told apart by what they are, not by name: symbolic and hard links, and other ways into a folder,
/// lead to the same file, also one that does not exist yet. Devices and pipes clash with nothing.
class OutputGuard {
 public:
  /// A file that no output may replace. @param what it is, as in "the scene"
  /// @throws regulus::Error (BadUsage) if it is an output
  void add_input(const std::filesystem::path& file, const std::string& what);

  /// A scene and everything that it refers to, whether it is read or not. Precondition: it has been loaded.
  /// @throws regulus::Error (BadUsage) if one of them is an output
  void add_scene(const std::filesystem::path& scene_file);

  /// A file to be written. @param option that names it; the error asks for another one
  /// @throws regulus::Error (BadUsage) if it is an input or another output
  void add_output(const std::string& option, const std::filesystem::path& file);

  /// A place that cannot be written is better known before an hour of work than after it: tries to make the
  /// temporary file of every output that was added since the last call.
  /// @throws regulus::Error (Failed) naming option and file
  void require_places();

 private:
  /// Device and number of an existing file; of another one those of its folder, and its name.
  using Identity = std::tuple<uint64_t, uint64_t, std::string>;
  struct Output {
    std::string option;
    std::filesystem::path file;
  };

  static Identity identify(const std::filesystem::path& file);

  std::map<Identity, std::string> inputs_;
  std::map<Identity, Output> outputs_;
  std::vector<Output> unchecked_;  // devices and pipes too
};

}  // namespace regulus::cli
