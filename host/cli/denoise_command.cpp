// regulus denoise: a picture without its noise, from a picture and its albedo and normals.

#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "base/error.hpp"
#include "cli/commands.hpp"
#include "cli/denoise_options.hpp"
#include "cli/output_guard.hpp"
#include "cli/output_writer.hpp"
#include "image/formats.hpp"
#include "image/image.hpp"

namespace regulus::cli {

namespace {

namespace fs = std::filesystem;
using image::Format;

struct Options {
  std::string input, output;
  DenoiseOptions denoise;
};

struct Picture {
  image::Image image;
  image::ExrContents contents;  // without colors
};

Picture read_picture(const fs::path& file) {
  Picture picture;
  picture.image = image::read_exr(file, &picture.contents.attributes);
  try {
    picture.contents = image::read_exr_contents(file);
    for (const char* color : {"R", "G", "B"}) picture.contents.channels.erase(color);
  } catch (const Error&) {
    // One with half floats, of another program: its colors alone.
    fmt::print(stderr,
               "regulus: warning: {}: has channels that are not 32 bits wide; only its colors are used\n",
               file.string());
  }
  return picture;
}

// A denoised picture is no part any more: its colors are not those of its sums.
void drop_sums(image::ExrContents& contents) {
  std::erase_if(contents.channels, [](const auto& channel) { return channel.first.starts_with("film."); });
  contents.attributes.erase("regulus:sample_ranges");
  contents.attributes.erase("regulus:checksum");
}

void denoise(const Options& options) {
  OutputGuard guard;
  guard.add_input(options.input, "the picture to denoise");
  guard.add_output("--output", options.output);
  guard.require_places();
  const Format format = image::require_format("--output", options.output,
                                              {Format::Exr, Format::Png, Format::Jpeg, Format::Hdr});
  require_denoiser(options.denoise);
  Picture picture = read_picture(options.input);
  image::ExrContents& contents = picture.contents;
  if (options.denoise.by == "oidn" && !contents.channels.contains("albedo.R"))
    fmt::print(
        stderr,
        "regulus: warning: {}: has no albedo; render with --aov albedo,N,emission for sharper details\n",
        options.input);
  denoise_picture(options.denoise, picture.image, contents.channels, contents.attributes);
  drop_sums(contents);
  OutputWriter writer;
  writer.write(options.output, [&] {
    return image::encode_picture(format, picture.image, 0, contents.attributes, contents.channels,
                                 contents.placement, options.output);
  });
  writer.throw_failures();
}

}  // namespace

void add_denoise_command(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("denoise", "Denoise a picture, by its albedo and normals where it has them");
  command->add_option("INPUT", options->input, "An OpenEXR picture, best with --aov albedo,N,emission")
      ->type_name("FILE")
      ->required();
  command
      ->add_option("-o,--output", options->output,
                   "Picture to write, in the format of its extension; OpenEXR keeps all channels, and the "
                   "noisy picture as noisy.R, noisy.G, noisy.B")
      ->type_name("FILE")
      ->required();
  add_denoiser_options(*command, options->denoise);
  command->callback([options] { denoise(*options); });
}

}  // namespace regulus::cli
