// OpenEXR headers, looked at before the library reads them. Internal to host/image.
#pragma once

#include <cstdint>
#include <filesystem>
#include <istream>

namespace regulus::image {

/// Refuses headers by which the library would lose its place in the file or take memory out of proportion: it
/// reads attributes of known types without regard to the size that they state, and makes room for as much
/// text as they state before it reads any.
/// @param stream the whole file; left somewhere in it
/// @throws regulus::Error (BadFile) naming `path`
void check_exr_header(const std::filesystem::path& path, std::istream& stream, uint64_t file_bytes);

}  // namespace regulus::image
