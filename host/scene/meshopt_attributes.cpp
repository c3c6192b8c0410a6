#include "scene/meshopt_attributes.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>

namespace regulus::scene {
namespace {

using ByteSpan = std::span<const unsigned char>;

constexpr size_t GROUP = 16;       // elements whose deltas are packed together
constexpr size_t MAX_BLOCK = 256;  // elements
constexpr size_t BLOCK_BYTES = 8192;
constexpr size_t MIN_TAIL = 24;

/// Bytes taken from the front; running out of them is remembered.
class Reader {
 public:
  explicit Reader(ByteSpan bytes) : bytes_(bytes) {}

  ByteSpan take(size_t count) {
    static constexpr std::array<unsigned char, MAX_BLOCK> ZEROS{};
    if (count > bytes_.size()) {
      is_short_ = true;
      return ByteSpan(ZEROS).first(count);
    }
    const ByteSpan taken = bytes_.first(count);
    bytes_ = bytes_.subspan(count);
    return taken;
  }

  bool is_exhausted() const { return !is_short_ && bytes_.empty(); }
  bool is_short() const { return is_short_; }

 private:
  ByteSpan bytes_;
  bool is_short_ = false;
};

/// Sixteen deltas of `bits` bits each; the largest stands for a byte that follows.
void read_group(Reader& reader, unsigned bits, unsigned char* deltas) {
  std::fill_n(deltas, GROUP, static_cast<unsigned char>(0));
  if (bits == 0) return;
  const ByteSpan packed = reader.take(2 * bits);
  if (bits == 8) {
    std::copy(packed.begin(), packed.end(), deltas);
    return;
  }
  const unsigned sentinel = (1u << bits) - 1;
  const size_t per_byte = 8 / bits;
  for (size_t i = 0; i < GROUP; ++i) {
    const size_t place = bits == 1 ? i % per_byte : per_byte - 1 - i % per_byte;
    const unsigned delta = packed[i / per_byte] >> (bits * place) & sentinel;
    deltas[i] = delta == sentinel ? reader.take(1)[0] : static_cast<unsigned char>(delta);
  }
}

/// The deltas of one byte of all elements of a block.
void read_deltas(Reader& reader, unsigned control, size_t count, unsigned char* deltas) {
  constexpr unsigned BITS[2][4] = {{0, 1, 2, 4}, {1, 2, 4, 8}};
  if (control == 2) {
    std::fill_n(deltas, count, static_cast<unsigned char>(0));
  } else if (control == 3) {
    const ByteSpan literal = reader.take(count);
    std::copy(literal.begin(), literal.end(), deltas);
  } else {
    const size_t groups = (count + GROUP - 1) / GROUP;
    const ByteSpan header = reader.take((groups + 3) / 4);
    for (size_t group = 0; group < groups; ++group)
      read_group(reader, BITS[control][header[group / 4] >> (2 * (group % 4)) & 3], deltas + group * GROUP);
  }
}

template <typename T>
T unzigzag(T value) {
  return static_cast<T>((value & 1) != 0 ? ~(value >> 1) : value >> 1);
}

/// Four bytes of an element: those of the one before it, changed by deltas.
uint32_t apply(uint32_t before, uint32_t delta, unsigned mode) {
  uint32_t result = 0;
  switch (mode & 15) {
    case 0:
      for (unsigned shift = 0; shift < 32; shift += 8)
        result |=
            uint32_t{static_cast<uint8_t>((before >> shift) + unzigzag(static_cast<uint8_t>(delta >> shift)))}
            << shift;
      return result;
    case 1:
      for (unsigned shift = 0; shift < 32; shift += 16)
        result |= uint32_t{static_cast<uint16_t>((before >> shift) +
                                                 unzigzag(static_cast<uint16_t>(delta >> shift)))}
                  << shift;
      return result;
    default:
      return before ^ std::rotr(delta, static_cast<int>(mode >> 4));
  }
}

bool is_mode(unsigned char mode) {
  return (mode & 15) == 2 || mode < 2;
}

/// Decodes colours of components of type T.
template <typename T>
void decode_colors(std::span<unsigned char> elements) {
  using Signed = std::make_signed_t<T>;
  constexpr int MAXIMUM = static_cast<T>(~T{0});
  for (size_t at = 0; at + 4 * sizeof(T) <= elements.size(); at += 4 * sizeof(T)) {
    std::array<T, 4> in{};
    std::memcpy(in.data(), &elements[at], sizeof(in));
    // The highest bit of alpha tells how many bits there are.
    const int scale = (1 << std::bit_width(static_cast<unsigned>(in[3]))) - 1;
    const int y = in[0];
    const auto co = static_cast<Signed>(in[1]), cg = static_cast<Signed>(in[2]);
    const int half_alpha = in[3] & (scale >> 1);
    const std::array<int, 4> rgba = {y + co - cg, y + cg, y - co - cg, half_alpha << 1 | (half_alpha & 1)};
    std::array<T, 4> out{};
    for (size_t i = 0; i < 4; ++i)
      out[i] = static_cast<T>(std::clamp(
          std::lround(static_cast<double>(rgba[i]) * MAXIMUM / std::max(scale, 1)), 0L, long{MAXIMUM}));
    std::memcpy(&elements[at], out.data(), sizeof(out));
  }
}

}  // namespace

bool decode_meshopt_attributes(std::span<unsigned char> elements, size_t stride, ByteSpan stream) {
  const size_t channels = stride / 4, tail = stride + channels;
  if (stream.size() < 1 + std::max(tail, MIN_TAIL) || stream[0] != MESHOPT_ATTRIBUTES_1) return false;
  const ByteSpan modes = stream.last(channels);
  if (!std::all_of(modes.begin(), modes.end(), is_mode)) return false;
  std::array<unsigned char, 256> before{};
  std::copy_n(stream.last(tail).begin(), stride, before.begin());

  Reader reader(stream.subspan(1, stream.size() - 1 - std::max(tail, MIN_TAIL)));
  const size_t block = std::min(BLOCK_BYTES / stride & ~(GROUP - 1), MAX_BLOCK);
  std::array<std::array<unsigned char, MAX_BLOCK>, 4> deltas{};
  const size_t count = elements.size() / stride;
  for (size_t first = 0; first < count && !reader.is_short(); first += block) {
    const size_t in_block = std::min(block, count - first);
    const ByteSpan controls = reader.take(channels);
    for (size_t channel = 0; channel < channels; ++channel) {
      for (size_t k = 0; k < 4; ++k)
        read_deltas(reader, controls[channel] >> (2 * k) & 3, in_block, deltas[k].data());
      uint32_t value = 0;
      std::memcpy(&value, &before[4 * channel], 4);
      for (size_t i = 0; i < in_block; ++i) {
        const uint32_t delta = deltas[0][i] | uint32_t{deltas[1][i]} << 8 | uint32_t{deltas[2][i]} << 16 |
                               uint32_t{deltas[3][i]} << 24;
        value = apply(value, delta, modes[channel]);
        std::memcpy(&elements[(first + i) * stride + 4 * channel], &value, 4);
      }
      std::memcpy(&before[4 * channel], &value, 4);
    }
  }
  return reader.is_exhausted();
}

void decode_meshopt_colors(std::span<unsigned char> elements, size_t stride) {
  if (stride == 4)
    decode_colors<uint8_t>(elements);
  else
    decode_colors<uint16_t>(elements);
}

}  // namespace regulus::scene
