#include "image/formats.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>

#include "base/atomic_file.hpp"
#include "base/error.hpp"

namespace regulus::image {

namespace {

const std::map<std::string, Format> EXTENSIONS = {{".exr", Format::Exr},
                                                  {".png", Format::Png},
                                                  {".jpg", Format::Jpeg},
                                                  {".jpeg", Format::Jpeg},
                                                  {".hdr", Format::Hdr}};

}  // namespace

std::optional<Format> format_of(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto found = EXTENSIONS.find(extension);
  return found == EXTENSIONS.end() ? std::nullopt : std::optional(found->second);
}

Format require_format(const std::string& option, const std::filesystem::path& path,
                      const std::vector<Format>& allowed) {
  const std::optional<Format> format = format_of(path);
  if (format && std::ranges::find(allowed, *format) != allowed.end()) return *format;
  if (!format && is_device_or_pipe(path)) return allowed.front();
  std::string names;
  for (const auto& [extension, known] : EXTENSIONS)
    if (std::ranges::find(allowed, known) != allowed.end())
      names += fmt::format("{}{}", names.empty() ? "" : ", ", extension);
  throw Error(ErrorCode::BadUsage, fmt::format("{} {}: the format follows the extension; name a file that "
                                               "ends in {}",
                                               option, path.string(), names));
}

std::string encode_picture(const Format format, const Image& image, const Encoding& encoding,
                           const Attributes& attributes, const Channels& channels, const Placement& placement,
                           const std::string_view name) {
  switch (format) {
    case Format::Exr:
      return encode_exr(image, attributes, channels, placement, name, encoding.storage);
    case Format::Hdr:
      return encode_hdr(image, name);
    default:
      return encode_tone_mapped(format, image, encoding, name);
  }
}

}  // namespace regulus::image
