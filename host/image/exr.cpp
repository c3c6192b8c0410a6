// OpenEXR in and out. Files are encoded in memory and written in one go (atomic_file.hpp). Reading treats
// the file as hostile: sizes are checked against the file's length before anything is allocated.
#include <Imath/half.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfChromaticitiesAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStdIO.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <exception>
#include <fstream>
#include <sstream>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "image/encoding.hpp"
#include "image/exr_header.hpp"
#include "image/exr_memory.hpp"
#include "image/image.hpp"
#include "image/pixel_limit.hpp"

namespace regulus::image {
namespace {

namespace fs = std::filesystem;

constexpr int MAX_EXTENT = 1 << 16;        // pixels; the widest film anybody renders, with room
constexpr int MAX_TILE = 1 << 12;          // pixels; the library has a buffer of a whole tile
constexpr uint64_t MAX_BLOCK_LINES = 256;  // DWAB's; other compressions have fewer

/// How many bytes of pixels a byte of file can hold. Deflate reaches 1032 : 1, a third more in PXR24, which
/// drops a byte in four; DWA first reduces empty blocks of 128 bytes to 2, all others stay below. A header
/// that claims more lies about its size.
uint64_t largest_expansion(const Imf::Compression compression) {
  const bool is_dwa = compression == Imf::DWAA_COMPRESSION || compression == Imf::DWAB_COMPRESSION;
  return is_dwa ? uint64_t{1} << 17 : uint64_t{1} << 11;
}

std::string one_line(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return std::iscntrl(c) != 0; }, ' ');
  return text;
}

[[noreturn]] void fail_bad_file(const fs::path& path, const std::string& reason) {
  throw Error(ErrorCode::BadFile, fmt::format("{}: {}", path.string(), one_line(reason)));
}

void require_size(const std::string_view name, const std::string& channel, const size_t found,
                  const size_t wanted) {
  if (found == wanted) return;
  throw Error(ErrorCode::Failed,
              fmt::format("{}: channel {} has {} values instead of {}", name, channel, found, wanted));
}

Imf::PixelType pixel_type(const Channel& channel) {
  return std::holds_alternative<std::vector<float>>(channel) ? Imf::FLOAT : Imf::UINT;
}

size_t value_count(const Channel& channel) {
  return std::visit([](const auto& values) { return values.size(); }, channel);
}

Imf::Slice channel_slice(const Channel& channel, const Imath::Box2i& window) {
  return std::visit(
      [&](const auto& values) { return Imf::Slice::Make(pixel_type(channel), values.data(), window); },
      channel);
}

/// Colours and directions, for which 11 bits of mantissa do. Ids of cryptomattes are the bits of a float.
bool may_be_half(const std::string& name) {
  if (name.starts_with("Crypto")) return false;
  const std::string_view last = std::string_view(name).substr(name.rfind('.') + 1);
  return last == "R" || last == "G" || last == "B" || last == "A" || name.starts_with("N.") ||
         name.starts_with("Ng.");
}

constexpr float LARGEST_HALF = 65504;

/// Finite values stay finite.
half to_half(const float value) {
  return std::isfinite(value) ? half(std::clamp(value, -LARGEST_HALF, LARGEST_HALF)) : half(value);
}

/// The halves of every `stride`th value from `values` on.
std::vector<half> to_halves(const float* values, const size_t count, const size_t stride) {
  std::vector<half> halves(count);
  for (size_t i = 0; i < count; ++i) halves[i] = to_half(values[i * stride]);
  return halves;
}

Imf::Header make_header(const Image& image, const Attributes& attributes, const Channels& channels,
                        const Placement& placement, const ExrStorage& storage) {
  const Imath::V2i first(static_cast<int>(placement.x), static_cast<int>(placement.y));
  const Imath::V2i size(static_cast<int>(image.width), static_cast<int>(image.height));
  const Imath::V2i film(static_cast<int>(placement.film_width), static_cast<int>(placement.film_height));
  const Imath::Box2i data(first, first + size - Imath::V2i(1));
  const Imath::Box2i display(Imath::V2i(0), film - Imath::V2i(1));
  Imf::Header header(placement.film_width != 0 ? display : data, data);
  header.compression() = storage.is_dwaa ? Imf::DWAA_COMPRESSION : Imf::ZIP_COMPRESSION;
  Imf::addChromaticities(header, Imf::Chromaticities());  // the default is Rec. 709 with D65
  for (const auto& [name, value] : attributes) header.insert(name, Imf::StringAttribute(value));
  const auto type_of = [&](const std::string& name, const Imf::PixelType type) {
    return storage.has_half_floats && type == Imf::FLOAT && may_be_half(name) ? Imf::HALF : type;
  };
  for (const char* name : {"R", "G", "B"})
    header.channels().insert(name, Imf::Channel(type_of(name, Imf::FLOAT)));
  for (const auto& [name, channel] : channels)
    header.channels().insert(name, Imf::Channel(type_of(name, pixel_type(channel))));
  return header;
}

Imf::Slice rgb_slice(const Image& image, const size_t component, const Imath::Box2i& window) {
  return Imf::Slice::Make(Imf::FLOAT, image.rgb.data() + component, window, 3 * sizeof(float),
                          3 * sizeof(float) * image.width);
}

std::string encode_checked(const Image& image, const Attributes& attributes, const Channels& channels,
                           const Placement& placement, const ExrStorage& storage) {
  const Imf::Header header = make_header(image, attributes, channels, placement, storage);
  const Imath::Box2i& window = header.dataWindow();
  Imf::FrameBuffer pixels;
  for (size_t component = 0; component < 3; ++component)
    pixels.insert(std::string(1, "RGB"[component]), rgb_slice(image, component, window));
  for (const auto& [name, channel] : channels) pixels.insert(name, channel_slice(channel, window));
  std::vector<std::vector<half>> halves;
  for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel) {
    if (channel.channel().type != Imf::HALF) continue;
    const std::string name = channel.name();
    const size_t color = std::string_view("RGB").find(name);
    const size_t count = size_t{image.width} * image.height;
    halves.push_back(color != std::string_view::npos
                         ? to_halves(image.rgb.data() + color, count, 3)
                         : to_halves(std::get<std::vector<float>>(channels.at(name)).data(), count, 1));
    pixels.insert(name, Imf::Slice::Make(Imf::HALF, halves.back().data(), window));
  }

  Imf::StdOSStream stream;
  {
    Imf::OutputFile file(stream, header);
    file.setFrameBuffer(pixels);
    file.writePixels(static_cast<int>(image.height));
  }  // the destructor completes the line offset table
  return stream.str();
}

uint64_t pixel_bytes_of(const Imf::Header& header) {
  uint64_t bytes = 0;
  for (auto c = header.channels().begin(); c != header.channels().end(); ++c)
    bytes += c.channel().type == Imf::HALF ? 2 : 4;
  return bytes;
}

/// Refuses what would make the decoder or us allocate out of proportion to the file.
void check_window(const fs::path& path, const Imf::Header& header, const uint64_t file_bytes) {
  const Imath::Box2i& window = header.dataWindow();
  const int64_t width = int64_t{window.max.x} - window.min.x + 1;
  const int64_t height = int64_t{window.max.y} - window.min.y + 1;
  if (width < 1 || height < 1 || width > MAX_EXTENT || height > MAX_EXTENT)
    fail_bad_file(
        path, fmt::format("data window of {} x {} pixels; at most {} are read", width, height, MAX_EXTENT));
  if (static_cast<uint64_t>(width * height) * pixel_bytes_of(header) >
      largest_expansion(header.compression()) * file_bytes)
    fail_bad_file(path, fmt::format("claims {} x {} pixels in {} bytes; the file is cut off or corrupt",
                                    width, height, file_bytes));
}

/// The channels that hold red, green and blue.
std::array<std::string, 3> find_rgb(const fs::path& path, const Imf::ChannelList& channels) {
  const bool is_grey = !channels.findChannel("R") && channels.findChannel("Y");
  std::array<std::string, 3> names =
      is_grey ? std::array<std::string, 3>{"Y", "Y", "Y"} : std::array<std::string, 3>{"R", "G", "B"};
  for (const std::string& name : names) {
    const Imf::Channel* channel = channels.findChannel(name);
    if (!channel) {
      std::string found;
      for (auto c = channels.begin(); c != channels.end(); ++c) found += fmt::format(" {}", c.name());
      fail_bad_file(path, fmt::format("has no channel {} (found:{}); R, G, B or Y are read", name,
                                      found.substr(0, 200)));
    }
    if (channel->xSampling != 1 || channel->ySampling != 1)
      fail_bad_file(path, fmt::format("channel {} is subsampled; only full resolution is read", name));
    if (channel->type == Imf::UINT)
      fail_bad_file(path, fmt::format("channel {} holds integers; half or float is read", name));
  }
  return names;
}

Attributes string_attributes(const Imf::Header& header) {
  Attributes attributes;
  for (auto attribute = header.begin(); attribute != header.end(); ++attribute)
    if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&attribute.attribute()))
      attributes[attribute.name()] = text->value();
  return attributes;
}

/// Makes the constructor of input files refuse huge windows and tiles before it allocates buffers for them.
void limit_image_size() {
  Imf::Header::setMaxImageSize(MAX_EXTENT, MAX_EXTENT);
  Imf::Header::setMaxTileSize(MAX_TILE, MAX_TILE);
}

Image read_pixels(const fs::path& path, Imf::InputFile& file, const uint64_t file_bytes,
                  Attributes* attributes, const uint64_t max_pixels = UINT64_MAX) {
  const Imf::Header& header = file.header();
  check_window(path, header, file_bytes);
  const Imath::Box2i& window = header.dataWindow();
  const std::array<std::string, 3> names = find_rgb(path, header.channels());

  Image image;
  image.width = static_cast<uint32_t>(window.max.x - window.min.x + 1);
  image.height = static_cast<uint32_t>(window.max.y - window.min.y + 1);
  require_pixels(path.string(), image.width, image.height, max_pixels);
  image.rgb.resize(size_t{3} * image.width * image.height);
  const bool is_half = std::all_of(names.begin(), names.end(), [&](const std::string& name) {
    return header.channels()[name].type == Imf::HALF;
  });
  if (is_half) image.largest_finite = LARGEST_HALF;
  Imf::FrameBuffer pixels;
  for (size_t component = 0; component < 3; ++component)
    if (component == 0 || names[component] != names[0])
      pixels.insert(names[component], rgb_slice(image, component, window));
  file.setFrameBuffer(pixels);
  file.readPixels(window.min.y, window.max.y);

  if (names[1] == names[0])
    for (size_t i = 0; i < image.rgb.size(); i += 3) image.rgb[i + 1] = image.rgb[i + 2] = image.rgb[i];
  if (attributes) *attributes = string_attributes(header);
  return image;
}

ExrContents read_all_channels(const fs::path& path, Imf::InputFile& file, const uint64_t file_bytes) {
  const Imf::Header& header = file.header();
  check_window(path, header, file_bytes);
  const Imath::Box2i &window = header.dataWindow(), &display = header.displayWindow();
  ExrContents contents;
  contents.width = static_cast<uint32_t>(window.max.x - window.min.x + 1);
  contents.height = static_cast<uint32_t>(window.max.y - window.min.y + 1);
  if (window.min.x < 0 || window.min.y < 0 || display.min != Imath::V2i(0) || display.max.x < window.max.x ||
      display.max.y < window.max.y || display.max.x >= MAX_EXTENT || display.max.y >= MAX_EXTENT)
    fail_bad_file(path, "its data window is not within its display window, or that does not start at 0, 0");
  contents.placement = {static_cast<uint32_t>(window.min.x), static_cast<uint32_t>(window.min.y),
                        static_cast<uint32_t>(display.max.x + 1), static_cast<uint32_t>(display.max.y + 1)};
  contents.attributes = string_attributes(header);
  const size_t pixel_count = size_t{contents.width} * contents.height;
  Imf::FrameBuffer pixels;
  for (auto c = header.channels().begin(); c != header.channels().end(); ++c) {
    if (c.channel().type == Imf::HALF || c.channel().xSampling != 1 || c.channel().ySampling != 1)
      fail_bad_file(path, fmt::format("channel {} is not of 32 bits at full resolution", c.name()));
    Channel& channel = contents.channels[c.name()];
    if (c.channel().type == Imf::UINT) channel = std::vector<uint32_t>();
    std::visit([&](auto& values) { values.resize(pixel_count); }, channel);
    pixels.insert(c.name(), channel_slice(channel, window));
  }
  file.setFrameBuffer(pixels);
  file.readPixels(window.min.y, window.max.y);
  return contents;
}

/// What `read` makes of an open file; its errors and the library's become those of the file.
template <typename Read>
auto open_and_read(const fs::path& path, const Read& read) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) fail_bad_file(path, "no such file");
  if (!fs::is_regular_file(status)) fail_bad_file(path, "is not a file");
  const uint64_t file_bytes = fs::file_size(path, error);
  if (error) fail_bad_file(path, fmt::format("cannot be read ({})", error.message()));
  try {
    limit_image_size();
    std::ifstream header(path, std::ios::binary);
    check_exr_header(path, header, file_bytes);
    Imf::InputFile file(path.c_str());
    return read(file, file_bytes);
  } catch (const Error&) {
    throw;
  } catch (const std::exception& problem) {
    fail_bad_file(path, fmt::format("cannot be read as OpenEXR ({})", problem.what()));
  }
}

}  // namespace

std::string encode_exr(const Image& image, const Attributes& attributes, const Channels& channels,
                       const Placement& placement, const std::string_view name, const ExrStorage& storage) {
  const size_t pixel_count = size_t{image.width} * image.height;
  require_size(name, "RGB", image.rgb.size(), 3 * pixel_count);
  for (const auto& [key, channel] : channels) require_size(name, key, value_count(channel), pixel_count);
  try {
    return encode_checked(image, attributes, channels, placement, storage);
  } catch (const std::exception& error) {
    throw Error(ErrorCode::Failed,
                fmt::format("{}: cannot be encoded as OpenEXR ({})", name, one_line(error.what())));
  }
}

std::string encode_exr(const Image& image, const Attributes& attributes, const Channels& channels,
                       const Placement& placement, const std::string_view name) {
  return encode_exr(image, attributes, channels, placement, name, {});
}

void write_exr(const fs::path& path, const Image& image, const Attributes& attributes,
               const Channels& channels, const Placement& placement) {
  write_file_atomically(path, encode_exr(image, attributes, channels, placement, path.string()));
}

Image read_exr(const fs::path& path, Attributes* attributes) {
  return open_and_read(path, [&](Imf::InputFile& file, uint64_t file_bytes) {
    return read_pixels(path, file, file_bytes, attributes);
  });
}

ExrContents read_exr_contents(const fs::path& path) {
  return open_and_read(path, [&](Imf::InputFile& file, uint64_t file_bytes) {
    return read_all_channels(path, file, file_bytes);
  });
}

namespace {

/// What `read` makes of a file's bytes; its errors and the library's become those of the file.
template <typename Read>
auto open_and_decode(const std::string& name, const std::span<const unsigned char> bytes, const Read& read) {
  try {
    limit_image_size();
    Imf::StdISStream stream;
    {
      const std::string text(bytes.begin(), bytes.end());
      std::istringstream header(text);
      check_exr_header(name, header, bytes.size());
      stream.str(text);
    }
    Imf::InputFile file(stream);
    return read(file);
  } catch (const Error&) {
    throw;
  } catch (const std::exception& problem) {
    fail_bad_file(name, fmt::format("cannot be read as OpenEXR ({})", problem.what()));
  }
}

}  // namespace

Image decode_exr(const std::string& name, const std::span<const unsigned char> bytes,
                 const uint64_t max_pixels) {
  return open_and_decode(name, bytes, [&](Imf::InputFile& file) {
    return read_pixels(name, file, bytes.size(), nullptr, max_pixels);
  });
}

uint64_t exr_decoding_bytes(const std::string& name, const std::span<const unsigned char> bytes) {
  return open_and_decode(name, bytes, [&](Imf::InputFile& file) {
    const Imf::Header& header = file.header();
    check_window(name, header, bytes.size());
    const Imath::Box2i& window = header.dataWindow();
    const auto width = static_cast<uint64_t>(int64_t{window.max.x} - window.min.x + 1);
    const auto height = static_cast<uint64_t>(int64_t{window.max.y} - window.min.y + 1);
    uint64_t pixels = width * std::min(height, MAX_BLOCK_LINES);
    if (header.hasTileDescription()) {  // a tile, and a row of them
      const Imf::TileDescription& tile = header.tileDescription();
      pixels = uint64_t{tile.xSize} * tile.ySize + width * std::min<uint64_t>(height, tile.ySize);
    }
    constexpr uint64_t PACKED_AND_NOT = 2, COPIES_OF_FILE = 3;
    return PACKED_AND_NOT * pixels * pixel_bytes_of(header) + COPIES_OF_FILE * bytes.size();
  });
}

}  // namespace regulus::image
