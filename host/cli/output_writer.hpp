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
  /// In one line, which outputs could not be written, why, and where they are now.
  const std::string& failures() const { return failures_; }

  /// @throws regulus::Error (Failed) with failures(), if there are any
  void throw_failures() const;

 private:
  std::string failures_;
};

}  // namespace regulus::cli
