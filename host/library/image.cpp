#include "regulus/image.hpp"

#include "base/atomic_file.hpp"
#include "image/formats.hpp"
#include "image/image.hpp"

namespace regulus {

namespace {

image::Image image_of(const Picture& picture) {
  return {.width = picture.width, .height = picture.height, .rgb = picture.rgb};
}

}  // namespace

Picture read_picture(const std::filesystem::path& path) {
  Picture picture;
  image::Image image = image::read_exr(path, &picture.attributes);
  picture.width = image.width;
  picture.height = image.height;
  picture.rgb = std::move(image.rgb);
  return picture;
}

void write_picture(const std::filesystem::path& path, const Picture& picture, float exposure_ev) {
  using image::Format;
  const Format format =
      image::require_format("picture", path, {Format::Exr, Format::Png, Format::Jpeg, Format::Hdr});
  const image::Placement placement{picture.x, picture.y, picture.film_width, picture.film_height};
  write_file_atomically(path,
                        image::encode_picture(format, image_of(picture), exposure_ev, picture.attributes,
                                              picture.channels, placement, path.string()));
}

Comparison compare(const Picture& picture, const Picture& reference) {
  const image::Image a = image_of(picture), b = image_of(reference);
  const image::Metrics metrics = image::compare(a, b);
  return {.mse = metrics.mse,
          .relmse = metrics.relmse,
          .mae = metrics.mae,
          .psnr = metrics.psnr,
          .flip = image::flip(a, b),
          .mean = metrics.mean,
          .reference_mean = metrics.reference_mean,
          .non_finite = metrics.non_finite};
}

}  // namespace regulus
