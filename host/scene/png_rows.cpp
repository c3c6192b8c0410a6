#include "scene/png_rows.hpp"

#include <png.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdio>
#include <cstring>

namespace regulus::scene {
namespace {

constexpr uint64_t MAX_DEFLATE_EXPANSION = 1032;
// Signature, length and type of the first chunk, which is the header: width, height, bit depth, colour type.
constexpr size_t HEADER_OFFSET = 16, HEADER_END = 26;

/// What libpng's callbacks work on; nothing in it needs a destructor, because errors jump over them.
struct Input {
  const unsigned char* at;
  size_t bytes_left;
  std::array<char, 100> problem;
};

[[noreturn]] void on_error(png_structp png, png_const_charp message) {
  auto* input = static_cast<Input*>(png_get_error_ptr(png));
  std::snprintf(input->problem.data(), input->problem.size(), "%s", message);
  png_longjmp(png, 1);
}

void ignore_warning(png_structp, png_const_charp) {}

void read_bytes(png_structp png, png_bytep target, size_t bytes) {
  auto* input = static_cast<Input*>(png_get_io_ptr(png));
  if (bytes > input->bytes_left) png_error(png, "the file ends early");
  std::memcpy(target, input->at, bytes);
  input->at += bytes;
  input->bytes_left -= bytes;
}

/// Rows of `row_bytes` each to `target`; false with Input::problem if that fails. No object with a destructor
/// lives in this function: libpng leaves it by longjmp.
bool read_rows(png_structp png, png_infop info, Input* input, uint32_t height, bool is_16_bit,
               size_t row_bytes, unsigned char* target) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_read_fn(png, input, &read_bytes);
  // Colour profiles, texts and whatever else could be large: not looked at.
  png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
  png_set_crc_action(png, PNG_CRC_DEFAULT, PNG_CRC_QUIET_USE);
  png_read_info(png, info);
  png_set_expand(png);
  png_set_gray_to_rgb(png);
  png_set_add_alpha(png, is_16_bit ? 0xFFFF : 0xFF, PNG_FILLER_AFTER);
  if (is_16_bit && std::endian::native == std::endian::little) png_set_swap(png);
  const int passes = png_set_interlace_handling(png);
  png_read_update_info(png, info);
  if (png_get_rowbytes(png, info) != row_bytes || png_get_image_height(png, info) != height)
    png_error(png, "its header is not what it was");
  for (int pass = 0; pass < passes; ++pass)
    for (uint32_t y = 0; y < height; ++y) png_read_row(png, target + y * row_bytes, nullptr);
  return true;
}

uint32_t big_endian(std::span<const unsigned char> bytes) {
  return uint32_t{bytes[0]} << 24 | uint32_t{bytes[1]} << 16 | uint32_t{bytes[2]} << 8 | bytes[3];
}

}  // namespace

bool png_fits(std::span<const unsigned char> file) {
  if (file.size() < HEADER_END) return false;
  const uint64_t width = big_endian(file.subspan(HEADER_OFFSET, 4));
  const uint64_t height = big_endian(file.subspan(HEADER_OFFSET + 4, 4));
  const uint64_t bits = file[HEADER_OFFSET + 8];
  constexpr std::array<uint64_t, 8> CHANNELS = {1, 0, 3, 1, 2, 0, 4, 0};  // by colour type
  const uint64_t channels = CHANNELS[file[HEADER_OFFSET + 9] & 7];
  // Each row has a byte for its filter.
  return height * (1 + width * channels * bits / 8) <= MAX_DEFLATE_EXPANSION * file.size();
}

bool decode_png(std::span<const unsigned char> file, uint32_t width, uint32_t height, bool is_16_bit,
                std::vector<uint32_t>& words, std::string& reason) {
  Input input{file.data(), file.size(), {}};
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &input, &on_error, &ignore_warning);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  const bool is_read =
      info != nullptr && read_rows(png, info, &input, height, is_16_bit, size_t{width} * (is_16_bit ? 8 : 4),
                                   reinterpret_cast<unsigned char*>(words.data()));
  png_destroy_read_struct(&png, &info, nullptr);
  if (!is_read) reason = input.problem[0] != 0 ? input.problem.data() : "out of memory";
  return is_read;
}

}  // namespace regulus::scene
