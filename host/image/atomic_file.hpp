// Writing a whole file so that no reader ever sees half of it. Used for images and for JSON reports.
#pragma once

#include <filesystem>
#include <string_view>

namespace regulus::image {

/// Replaces the file at `path` by `bytes`: writes a temporary file in the same folder, flushes it to the
/// disk and renames it. Symbolic links are followed; a device or pipe is written to directly.
/// @throws regulus::Error (Failed) naming the file and the system's reason; the temporary is removed and
/// what was at `path` before is untouched.
void write_file_atomically(const std::filesystem::path& path, std::string_view bytes);

}  // namespace regulus::image
