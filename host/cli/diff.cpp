#include "cli/diff.hpp"

#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/standard_streams.hpp"
#include "cli/output_guard.hpp"
#include "image/formats.hpp"
#include "image/image.hpp"

namespace regulus::cli {

using image::Format;

namespace {

struct DiffOptions {
  std::string image, reference, json, heat_map, flip_map;
};

// NaN and infinity (the psnr of equal images) become null: JSON has neither.
nlohmann::ordered_json to_json(const image::Metrics& metrics, double flip) {
  return {{"mse", metrics.mse},
          {"relmse", metrics.relmse},
          {"trimmed_relmse", metrics.trimmed_relmse},
          {"mrse", metrics.mrse},
          {"mae", metrics.mae},
          {"psnr", metrics.psnr},
          {"flip", flip},
          {"mean", metrics.mean},
          {"reference_mean", metrics.reference_mean},
          {"non_finite", metrics.non_finite}};
}

void print(const image::Metrics& metrics, double flip) {
  say("mse             {:.6g}\nrelmse          {:.6g}\ntrimmed relmse  {:.6g}\nmrse            {:.6g}\n",
      metrics.mse, metrics.relmse, metrics.trimmed_relmse, metrics.mrse);
  say("mae             {:.6g}\npsnr            {:.2f} dB\nflip            {:.6g}\n", metrics.mae,
      metrics.psnr, flip);
  const auto print_mean = [](const char* name, const std::array<double, 3>& mean) {
    say("{:<15} {:.6g} {:.6g} {:.6g}\n", name, mean[0], mean[1], mean[2]);
  };
  print_mean("mean", metrics.mean);
  print_mean("reference mean", metrics.reference_mean);
  say("non-finite      {}\n", metrics.non_finite);
}

image::Metrics compare(const DiffOptions& options, const image::Image& image, const image::Image& reference) {
  try {
    return image::compare(image, reference);
  } catch (const Error& error) {  // knows the sizes, not the files
    throw Error(error.code(),
                fmt::format("{} against {}: {}", options.image, options.reference, error.what()));
  }
}

// The formats of the maps that are asked for; PNG for those that are not.
struct MapFormats {
  Format heat = Format::Png, flip = Format::Png;
};

MapFormats check_outputs(const DiffOptions& options) {
  OutputGuard guard;
  guard.add_input(options.image, "the image");
  guard.add_input(options.reference, "the reference");
  MapFormats formats;
  const auto add = [&](const char* option, const std::string& file, Format* format) {
    if (file.empty()) return;
    guard.add_output(option, file);
    if (format != nullptr) *format = image::require_format(option, file, {Format::Png, Format::Jpeg});
    require_writable(file);
  };
  add("--json", options.json, nullptr);
  add("--heat-map", options.heat_map, &formats.heat);
  add("--flip-map", options.flip_map, &formats.flip);
  return formats;
}

void diff(const DiffOptions& options) {
  const MapFormats formats = check_outputs(options);
  const image::Image image = image::read_exr(options.image);
  const image::Image reference = image::read_exr(options.reference);
  const image::Metrics metrics = compare(options, image, reference);
  const double flip = image::flip(image, reference);
  if (!options.json.empty()) write_file_atomically(options.json, to_json(metrics, flip).dump(2) + "\n");
  if (!options.heat_map.empty())
    write_file_atomically(options.heat_map,
                          image::encode_heat_map(formats.heat, image, reference, options.heat_map));
  if (!options.flip_map.empty())
    write_file_atomically(options.flip_map,
                          image::encode_flip_map(formats.flip, image, reference, options.flip_map));
  print(metrics, flip);
}

}  // namespace

void add_diff_command(CLI::App& app) {
  const auto options = std::make_shared<DiffOptions>();
  CLI::App* command = app.add_subcommand("diff", "Error metrics of an image against a reference");
  command->add_option("IMAGE", options->image, "OpenEXR file")->type_name("FILE")->required();
  command->add_option("REFERENCE", options->reference, "OpenEXR file of the same size")
      ->type_name("FILE")
      ->required();
  command->add_option("--json", options->json, "Write the metrics to this file")->type_name("FILE");
  command
      ->add_option("--heat-map", options->heat_map,
                   "Write the relative error of each pixel to this PNG or JPEG, 0.001 (black) to 1 (yellow)")
      ->type_name("FILE");
  command
      ->add_option("--flip-map", options->flip_map,
                   "Write the FLIP error of each pixel to this PNG or JPEG, 0 (black) to 1 (yellow)")
      ->type_name("FILE");
  command->callback([options] { diff(*options); });
}

}  // namespace regulus::cli
