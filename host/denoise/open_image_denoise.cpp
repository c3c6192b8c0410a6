// Open Image Denoise by its C API (oidn.h of version 2), whose functions are looked up when it is first
// needed.

#include <fmt/format.h>

#include <cstdlib>
#include <memory>

#include "base/error.hpp"
#include "base/shared_library.hpp"
#include "denoise/denoise.hpp"

namespace regulus::denoise {

namespace {

constexpr const char* LIBRARY = "libOpenImageDenoise.so.2";

// Of oidn.h: handles are pointers to structures that only the library knows.
struct OIDNDeviceImpl;
struct OIDNFilterImpl;
using OIDNDevice = OIDNDeviceImpl*;
using OIDNFilter = OIDNFilterImpl*;
constexpr int OIDN_DEVICE_TYPE_CPU = 1, OIDN_FORMAT_FLOAT3 = 3, OIDN_ERROR_NONE = 0;

/// The functions that are needed, all of them found.
struct Api {
  explicit Api(const std::string& name) : library(name) {
    if (!library.is_loaded())
      throw Error(ErrorCode::Failed,
                  fmt::format("Open Image Denoise cannot be loaded ({}); install it, or name its {} with "
                              "--oidn FILE or REGULUS_OIDN",
                              library.problem(), LIBRARY));
    find(new_device, "oidnNewDevice");
    find(commit_device, "oidnCommitDevice");
    find(release_device, "oidnReleaseDevice");
    find(device_error, "oidnGetDeviceError");
    find(new_filter, "oidnNewFilter");
    find(set_image, "oidnSetSharedFilterImage");
    find(set_bool, "oidnSetFilterBool");
    find(commit_filter, "oidnCommitFilter");
    find(execute_filter, "oidnExecuteFilter");
    find(release_filter, "oidnReleaseFilter");
  }

  template <typename F>
  void find(F*& function, const char* name) {
    function = library.find<F>(name);
    if (function == nullptr)
      throw Error(
          ErrorCode::Failed,
          fmt::format("{} has no function {}; version 2 of Open Image Denoise is needed", LIBRARY, name));
  }

  SharedLibrary library;
  OIDNDevice (*new_device)(int type) = nullptr;
  void (*commit_device)(OIDNDevice) = nullptr;
  void (*release_device)(OIDNDevice) = nullptr;
  int (*device_error)(OIDNDevice, const char** message) = nullptr;
  OIDNFilter (*new_filter)(OIDNDevice, const char* type) = nullptr;
  void (*set_image)(OIDNFilter, const char* name, void* pixels, int format, size_t width, size_t height,
                    size_t byte_offset, size_t pixel_stride, size_t row_stride) = nullptr;
  void (*set_bool)(OIDNFilter, const char* name, bool value) = nullptr;
  void (*commit_filter)(OIDNFilter) = nullptr;
  void (*execute_filter)(OIDNFilter) = nullptr;
  void (*release_filter)(OIDNFilter) = nullptr;
};

std::string file_of(const std::string& library) {
  const char* variable = std::getenv("REGULUS_OIDN");
  const std::string named = !library.empty() || variable == nullptr ? library : variable;
  return named.empty() ? LIBRARY : named;
}

class Denoiser {
 public:
  explicit Denoiser(const std::string& library)
      : api_(library), device_(api_.new_device(OIDN_DEVICE_TYPE_CPU)) {
    if (device_ == nullptr) require_success();
    api_.commit_device(device_);
    require_success();
  }
  ~Denoiser() {
    if (device_ != nullptr) api_.release_device(device_);
  }
  Denoiser(const Denoiser&) = delete;
  Denoiser& operator=(const Denoiser&) = delete;

  struct Picture {
    const char* name;  ///< of the filter's input
    const std::vector<float>& pixels;
  };

  /// The first of the pictures, filtered with the help of the others.
  std::vector<float> filter(const Input& size, const std::vector<Picture>& pictures) {
    std::vector<float> output(pictures.front().pixels.size());
    const std::unique_ptr<OIDNFilterImpl, void (*)(OIDNFilter)> filter(api_.new_filter(device_, "RT"),
                                                                       api_.release_filter);
    require_success();
    const auto set = [&](const char* name, const std::vector<float>& pixels) {
      // The library only reads inputs, but its API has one type for both.
      api_.set_image(filter.get(), name, const_cast<float*>(pixels.data()), OIDN_FORMAT_FLOAT3, size.width,
                     size.height, 0, 0, 0);
    };
    for (const Picture& picture : pictures) set(picture.name, picture.pixels);
    set("output", output);
    const bool is_color = std::string("color") == pictures.front().name;
    if (is_color) api_.set_bool(filter.get(), "hdr", true);
    if (pictures.size() > 1) api_.set_bool(filter.get(), "cleanAux", true);
    api_.commit_filter(filter.get());
    require_success();
    api_.execute_filter(filter.get());
    require_success();
    return output;
  }

 private:
  void require_success() {
    const char* message = nullptr;
    if (api_.device_error(device_, &message) == OIDN_ERROR_NONE) return;
    throw Error(ErrorCode::Failed,
                fmt::format("Open Image Denoise failed: {}", message == nullptr ? "unknown" : message));
  }

  Api api_;
  OIDNDevice device_ = nullptr;
};

}  // namespace

void require_open_image_denoise(const std::string& library) {
  const Api api(file_of(library));
}

std::vector<float> by_open_image_denoise(const Input& input, const std::string& library) {
  Denoiser denoiser(file_of(library));
  std::vector<Denoiser::Picture> pictures = {{"color", input.color}};
  std::vector<float> albedo, normal;
  if (!input.albedo.empty()) {
    albedo = denoiser.filter(input, {{"albedo", input.albedo}});
    pictures.push_back({"albedo", albedo});
    if (!input.normal.empty()) {
      normal = denoiser.filter(input, {{"normal", input.normal}});
      pictures.push_back({"normal", normal});
    }
  }
  return denoiser.filter(input, pictures);
}

}  // namespace regulus::denoise
