// Writes what a command has made, so that nothing made is lost.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace regulus::cli {

/// What cannot be written where it should be is put into the system's temporary folder, and the outputs after
/// it are written all the same; throw_failures() tells.
class OutputWriter {
 public:
  /// @param encode makes the bytes of the file
  void write(const std::filesystem::path& file, const std::function<std::string()>& encode);

  bool has_failed() const { return !failures_.empty(); }

  /// @throws regulus::Error (Failed) if some output could not be written: which, why, and where it is now
  void throw_failures() const;

 private:
  std::string failures_;
};

}  // namespace regulus::cli
