// Which file a name leads to.
#pragma once

#include <sys/stat.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <utility>

namespace regulus {

/// Device and number of what is there, links followed: two names of one file have the same. None if nothing
/// is.
inline std::optional<std::pair<uint64_t, uint64_t>> file_identity(const std::filesystem::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return std::nullopt;
  return std::pair(uint64_t{status.st_dev}, uint64_t{status.st_ino});
}

}  // namespace regulus
