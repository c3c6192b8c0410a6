// Tells tables apart that renders are made with.
#pragma once

#include <bit>
#include <cstdint>

namespace regulus::scene {

/// FNV-1a by words.
class WordHash {
 public:
  void add(uint32_t word) { value_ = (value_ ^ word) * 0x100000001b3u; }
  void add(float number) { add(std::bit_cast<uint32_t>(number)); }
  uint64_t value() const { return value_; }

 private:
  uint64_t value_ = 0xcbf29ce484222325u;
};

}  // namespace regulus::scene
