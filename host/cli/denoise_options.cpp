#include "cli/denoise_options.hpp"

#include <utility>

#include "cli/validators.hpp"
#include "denoise/denoise.hpp"
#include "render/settings.hpp"

namespace regulus::cli {

namespace {

bool is_cross(const DenoiseOptions& options) {
  return options.by == "cross";
}

// What the picture was before it was denoised, if it was.
void restore_noise(image::Image& image, image::Channels& channels) {
  for (size_t c = 0; c < 3; ++c) {
    const auto found = channels.find(std::string("noisy.") + "RGB"[c]);
    if (found == channels.end()) return;
    const auto* plane = std::get_if<std::vector<float>>(&found->second);
    if (plane == nullptr || 3 * plane->size() != image.rgb.size()) return;
    for (size_t i = 0; i < plane->size(); ++i) image.rgb[3 * i + c] = (*plane)[i];
  }
}

}  // namespace

void add_denoiser_options(CLI::App& command, DenoiseOptions& options) {
  command
      .add_option("--denoiser", options.by,
                  "What denoises: Open Image Denoise, or our own cross filter, which is worse but needs "
                  "nothing")
      ->type_name("oidn|cross")
      ->check(one_of({"oidn", "cross"}))
      ->capture_default_str();
  command
      .add_option("--oidn", options.library,
                  "libOpenImageDenoise.so.2 (default: $REGULUS_OIDN, or what the system finds)")
      ->type_name("FILE");
}

uint32_t aovs_for_denoiser(const DenoiseOptions& options) {
  return render::AOV_ALBEDO | render::AOV_SHADING_NORMAL | render::AOV_EMISSION |
         (is_cross(options) ? render::AOV_VARIANCE : 0U);
}

void require_denoiser(const DenoiseOptions& options) {
  if (!is_cross(options)) denoise::require_open_image_denoise(options.library);
}

void denoise_picture(const DenoiseOptions& options, image::Image& image, image::Channels& channels,
                     image::Attributes& attributes) {
  restore_noise(image, channels);
  const denoise::Input input = denoise::make_input(image, channels);
  const denoise::Method method =
      is_cross(options) ? denoise::Method::CrossFilter : denoise::Method::OpenImageDenoise;
  denoise::put_denoised(denoise::denoised(input, method, options.library),
                        is_cross(options) ? "cross filter" : "Open Image Denoise", image, channels,
                        attributes);
}

}  // namespace regulus::cli
