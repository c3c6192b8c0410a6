#include "scene_files.hpp"

#include <array>

namespace regulus::scene::test {
namespace {

void append_u32(Bytes& bytes, uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<unsigned char>(value >> shift));
}

/// CRC of PNG 1.2, annex D.
uint32_t crc32(const unsigned char* data, size_t size) {
  uint32_t crc = 0xFFFFFFFFu;
  for (size_t i = 0; i < size; ++i) {
    crc ^= data[i];
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1) != 0 ? 0xEDB88320u : 0u);
  }
  return ~crc;
}

void append_chunk(Bytes& png, const std::string& type, const Bytes& content) {
  append_u32(png, static_cast<uint32_t>(content.size()));
  const size_t start = png.size();
  png.insert(png.end(), type.begin(), type.end());
  png.insert(png.end(), content.begin(), content.end());
  append_u32(png, crc32(png.data() + start, png.size() - start));
}

/// zlib stream of stored blocks (RFC 1950, RFC 1951 3.2.4).
Bytes stored_zlib(const Bytes& raw) {
  Bytes stream = {0x78, 0x01};
  uint32_t a = 1, b = 0;
  for (size_t start = 0; start < raw.size() || start == 0; start += 65535) {
    const size_t size = std::min<size_t>(65535, raw.size() - start);
    stream.push_back(start + size >= raw.size() ? 1 : 0);
    for (const uint32_t length : {static_cast<uint32_t>(size), ~static_cast<uint32_t>(size)}) {
      stream.push_back(static_cast<unsigned char>(length));
      stream.push_back(static_cast<unsigned char>(length >> 8));
    }
    stream.insert(stream.end(), raw.begin() + static_cast<std::ptrdiff_t>(start),
                  raw.begin() + static_cast<std::ptrdiff_t>(start + size));
  }
  for (const unsigned char byte : raw) {
    a = (a + byte) % 65521;
    b = (b + a) % 65521;
  }
  append_u32(stream, b << 16 | a);
  return stream;
}

/// zlib stream of `size` zeros: a literal and then copies of 258 bytes from one byte back, by the fixed codes
/// (RFC 1951 3.2.6: length 258 has the code 11000101, distance 1 the code 00000).
Bytes deflated_zeros(uint64_t size) {
  Bytes stream = {0x78, 0x01};
  uint32_t bits = 0, count = 0;
  const auto append = [&](uint32_t value, uint32_t length) {
    for (uint32_t i = 0; i < length; ++i) {
      bits |= (value >> (length - 1 - i) & 1) << count;
      if (++count == 8) {
        stream.push_back(static_cast<unsigned char>(bits));
        bits = count = 0;
      }
    }
  };
  append(0b110, 3);  // last block, fixed codes, lowest bit first
  for (uint64_t i = 0; i < 1 + (size - 1) % 258; ++i) append(0b00110000, 8);  // literal 0
  for (uint64_t i = 0; i < (size - 1) / 258; ++i) append(0b1100010100000, 13);
  append(0, 7);  // end of block
  append(0, 7);  // to a whole byte
  // Adler-32 of zeros: a stays 1, b counts the bytes.
  append_u32(stream, static_cast<uint32_t>(size % 65521) << 16 | 1);
  return stream;
}

}  // namespace

Bytes make_blank_png(uint32_t width, uint32_t height) {
  Bytes header;
  append_u32(header, width);
  append_u32(header, height);
  header.insert(header.end(), {1, 0, 0, 0, 0});
  Bytes png = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
  append_chunk(png, "IHDR", header);
  append_chunk(png, "IDAT", deflated_zeros(uint64_t{height} * (1 + (width + 7) / 8)));
  append_chunk(png, "IEND", {});
  return png;
}

Bytes make_png(uint32_t width, uint32_t height, uint32_t channels, uint32_t bits,
               const std::vector<uint16_t>& samples) {
  Bytes raw;
  const size_t row_samples = static_cast<size_t>(width) * channels;
  for (size_t i = 0; i < samples.size(); ++i) {
    if (i % row_samples == 0) raw.push_back(0);  // filter type: none
    if (bits == 16) raw.push_back(static_cast<unsigned char>(samples[i] >> 8));
    raw.push_back(static_cast<unsigned char>(samples[i]));
  }
  const unsigned char color_type = channels == 1 ? 0 : channels == 3 ? 2 : 6;
  Bytes header;
  append_u32(header, width);
  append_u32(header, height);
  header.insert(header.end(), {static_cast<unsigned char>(bits), color_type, 0, 0, 0});
  Bytes png = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
  append_chunk(png, "IHDR", header);
  append_chunk(png, "IDAT", stored_zlib(raw));
  append_chunk(png, "IEND", {});
  return png;
}

}  // namespace regulus::scene::test
