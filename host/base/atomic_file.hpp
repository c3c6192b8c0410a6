// Writing a whole file so that no reader ever sees half of it. Used for images and for JSON reports.
#pragma once

#include <filesystem>
#include <string_view>

namespace regulus {

/// Replaces the file at `path` by `bytes`: writes a temporary file in the same folder, flushes it to the
/// disk and renames it. Symbolic links are followed, also those to nothing yet; a device or pipe is written
/// to directly. Temporary files of the same `path` that a killed process left behind are removed.
/// @throws regulus::Error (Failed) naming the file and the system's reason; the temporary is removed and
/// what was at `path` before is untouched.
void write_file_atomically(const std::filesystem::path& path, std::string_view bytes);

/// Finds out now whether write_file_atomically could write there, by making its temporary file and removing
/// it again. Removes left-over ones as well. A device or pipe is not opened.
/// @throws regulus::Error (Failed), as write_file_atomically would
void require_writable(const std::filesystem::path& path);

/// Writes `bytes` to a new file in the system's temporary folder whose name ends like that of `path`, for
/// what could not be written there. Returns its path; empty if that fails as well.
std::filesystem::path write_to_temporary_folder(const std::filesystem::path& path, std::string_view bytes);

/// What a chain of symbolic links from `path` ends at, whether it exists or not; `path` if it is no link.
/// @throws regulus::Error (Failed) if the links go round in circles
std::filesystem::path follow_links(const std::filesystem::path& path);

/// Something at `path` that is neither a regular file nor a folder, such as /dev/null or a pipe.
bool is_device_or_pipe(const std::filesystem::path& path);

}  // namespace regulus
