#include "cli/diff.hpp"

#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "base/error.hpp"
#include "image/atomic_file.hpp"
#include "image/flip_picture.hpp"
#include "image/image.hpp"

namespace regulus::cli {

namespace {

struct DiffOptions {
  std::string image, reference, json, heat_map, flip_map;
};

// NaN and infinity (the psnr of equal images) become null: JSON has neither.
nlohmann::ordered_json to_json(const image::Metrics& metrics, double flip) {
  return {{"mse", metrics.mse},
          {"relmse", metrics.relmse},
          {"mrse", metrics.mrse},
          {"mae", metrics.mae},
          {"psnr", metrics.psnr},
          {"flip", flip},
          {"mean", metrics.mean},
          {"reference_mean", metrics.reference_mean},
          {"non_finite", metrics.non_finite}};
}

void print(const image::Metrics& metrics, double flip) {
  fmt::print("mse             {:.6g}\nrelmse          {:.6g}\nmrse            {:.6g}\n", metrics.mse,
             metrics.relmse, metrics.mrse);
  fmt::print("mae             {:.6g}\npsnr            {:.2f} dB\nflip            {:.6g}\n", metrics.mae,
             metrics.psnr, flip);
  const auto print_mean = [](const char* name, const std::array<double, 3>& mean) {
    fmt::print("{:<15} {:.6g} {:.6g} {:.6g}\n", name, mean[0], mean[1], mean[2]);
  };
  print_mean("mean", metrics.mean);
  print_mean("reference mean", metrics.reference_mean);
  fmt::print("non-finite      {}\n", metrics.non_finite);
}

image::Metrics compare(const DiffOptions& options, const image::Image& image, const image::Image& reference) {
  try {
    return image::compare(image, reference);
  } catch (const Error& error) {  // knows the sizes, not the files
    throw Error(error.status(),
                fmt::format("{} against {}: {}", options.image, options.reference, error.what()));
  }
}

void diff(const DiffOptions& options) {
  const image::Image image = image::read_exr(options.image);
  const image::Image reference = image::read_exr(options.reference);
  const image::Metrics metrics = compare(options, image, reference);
  const double flip = image::flip(image, reference);
  if (!options.json.empty())
    image::write_file_atomically(options.json, to_json(metrics, flip).dump(2) + "\n");
  if (!options.heat_map.empty()) image::write_heat_map(options.heat_map, image, reference);
  if (!options.flip_map.empty()) image::write_flip_picture(options.flip_map, image, reference);
  print(metrics, flip);
}

}  // namespace

void add_diff_command(CLI::App& app) {
  const auto options = std::make_shared<DiffOptions>();
  CLI::App* command = app.add_subcommand("diff", "Error metrics of an image against a reference");
  command->add_option("IMAGE", options->image, "OpenEXR file")->required();
  command->add_option("REFERENCE", options->reference, "OpenEXR file of the same size")->required();
  command->add_option("--json", options->json, "Write the metrics to this file");
  command->add_option("--heat-map", options->heat_map,
                      "Write the relative error of each pixel to this PNG, 0.001 (black) to 1 (yellow)");
  command->add_option("--flip-map", options->flip_map,
                      "Write the FLIP error of each pixel to this PNG, 0 (black) to 1 (yellow)");
  command->callback([options] { diff(*options); });
}

}  // namespace regulus::cli
