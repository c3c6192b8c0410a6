// regulus_film_hash FILE...: prints a hash of the data window and of every channel of OpenEXR files, one line
// each. What the header says beside that does not matter. Used by tests/support/pin-films.
#include <fmt/format.h>

#include <bit>
#include <cstdio>
#include <exception>

#include "image/image.hpp"

namespace {

/// FNV-1a, 64 bit, over words.
class Hash {
 public:
  void add(uint64_t word) { value_ = (value_ ^ word) * 0x100000001b3u; }
  uint64_t value() const { return value_; }

 private:
  uint64_t value_ = 0xcbf29ce484222325u;
};

uint64_t hash_of(const regulus::image::ExrContents& picture) {
  Hash hash;
  for (const uint32_t number : {picture.width, picture.height, picture.placement.x, picture.placement.y,
                                picture.placement.film_width, picture.placement.film_height})
    hash.add(number);
  for (const auto& [name, channel] : picture.channels) {
    for (const char letter : name) hash.add(static_cast<unsigned char>(letter));
    std::visit(
        [&](const auto& values) {
          for (const auto& value : values) hash.add(std::bit_cast<uint32_t>(value));
        },
        channel);
  }
  return hash.value();
}

}  // namespace

int main(int count, char** arguments) try {
  for (int i = 1; i < count; ++i)
    fmt::print("{:016x}\n", hash_of(regulus::image::read_exr_contents(arguments[i])));
  return 0;
} catch (const std::exception& error) {
  fmt::print(stderr, "{}\n", error.what());
  return 1;
}
