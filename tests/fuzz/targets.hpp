// What the fuzzers feed: every reader of files, from bytes to what the renderer would work on. A target
// returns whether the bytes were read; Error with status BadFile is caught as the answer "no". Anything else
// that leaves it is a bug.
#pragma once

#include <cstdint>
#include <span>

namespace regulus::fuzz {

using Bytes = std::span<const unsigned char>;

struct Target {
  const char* name;  ///< folder of its corpus
  bool (*read)(Bytes bytes);
};

/// All of them: gltf, exr, hdr, images, draco, meshopt, checkpoint.
std::span<const Target> targets();

/// One by name. @throws std::out_of_range
const Target& target(const char* name);

}  // namespace regulus::fuzz
