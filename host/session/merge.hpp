// Parts of a render joined: sample ranges and crops, exactly.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "image/formats.hpp"
#include "session/part.hpp"

namespace regulus::session {

/// The part that holds the samples of all of the files, its header and AOVs among them.
/// @param files at least one
/// @throws regulus::Error (BadFile) if they are no complete parts of one render, hold a sample twice or leave
/// gaps; it names the files
Part merge_parts(const std::vector<std::filesystem::path>& files);

/// The bytes of a part's file: in OpenEXR a part again, in other formats a picture. Errors name `path`.
/// @throws regulus::Error (Failed)
std::string encode(const Part& part, image::Format format, const std::filesystem::path& path);

}  // namespace regulus::session
