// What reading an OpenEXR file takes beside its picture, for those who count memory before it is taken.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace regulus::image {

/// Bytes that decode_exr() takes while it reads, beside the pixels that it returns: copies of the file, and
/// the blocks of all channels in which pixels are compressed. Reads only the header.
/// @throws regulus::Error (BadFile) naming `name` as decode_exr() does
uint64_t exr_decoding_bytes(const std::string& name, std::span<const unsigned char> bytes);

}  // namespace regulus::image
