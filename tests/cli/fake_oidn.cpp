// A library with the functions of Open Image Denoise that Regulus calls, whose results a test can foretell:
// albedo and normal come back halved, a picture as color, $FAKE_OIDN_MOST at most, + albedo. What was called
// stands in the file $FAKE_OIDN_LOG.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

namespace {

struct Filter {
  std::map<std::string, float*> images;
  std::map<std::string, bool> flags;
  size_t width = 0, height = 0;
};

void log(const std::string& line) {
  if (FILE* file = std::fopen(std::getenv("FAKE_OIDN_LOG"), "a")) {
    std::fprintf(file, "%s\n", line.c_str());
    std::fclose(file);
  }
}

}  // namespace

#define EXPORT extern "C" __attribute__((visibility("default")))

EXPORT void* oidnNewDevice(int type) {
  log("device " + std::to_string(type));
  return std::malloc(1);
}
EXPORT void oidnCommitDevice(void*) {}
EXPORT void oidnReleaseDevice(void* device) {
  log("released");
  std::free(device);
}
EXPORT int oidnGetDeviceError(void*, const char** message) {
  *message = "as asked for";
  return std::getenv("FAKE_OIDN_FAILS") != nullptr ? 4 : 0;
}
EXPORT void* oidnNewFilter(void*, const char*) {
  return new Filter;
}
EXPORT void oidnSetSharedFilterImage(void* filter, const char* name, void* pixels, int format, size_t width,
                                     size_t height, size_t, size_t, size_t) {
  auto* self = static_cast<Filter*>(filter);
  self->images[name] = format == 3 ? static_cast<float*>(pixels) : nullptr;
  self->width = width;
  self->height = height;
}
EXPORT void oidnSetFilterBool(void* filter, const char* name, bool value) {
  static_cast<Filter*>(filter)->flags[name] = value;
}
EXPORT void oidnCommitFilter(void*) {}
EXPORT void oidnExecuteFilter(void* filter) {
  auto* self = static_cast<Filter*>(filter);
  std::string line;
  size_t strange = 0;
  const size_t count = 3 * self->width * self->height;
  for (const auto& [name, pixels] : self->images) {
    line += name + " ";
    if (name != "output")
      for (size_t i = 0; i < count; ++i) strange += std::isfinite(pixels[i]) ? 0 : 1;
  }
  for (const auto& [name, value] : self->flags) line += name + (value ? "=1 " : "=0 ");
  log(line + std::to_string(strange));
  const char* most = std::getenv("FAKE_OIDN_MOST");
  const float brightest = most != nullptr ? std::strtof(most, nullptr) : INFINITY;
  for (size_t i = 0; i < count; ++i)
    self->images["output"][i] =
        self->images.contains("color")
            ? std::fmin(self->images["color"][i], brightest) +
                  (self->images.contains("albedo") ? self->images["albedo"][i] : 0)
            : (self->images.contains("albedo") ? self->images["albedo"][i] : self->images["normal"][i]) / 2;
}
EXPORT void oidnReleaseFilter(void* filter) {
  delete static_cast<Filter*>(filter);
}
