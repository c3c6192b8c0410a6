#include "cli/strategy_images.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "base/error.hpp"
#include "image/formats.hpp"
#include "render/strategies.hpp"

namespace regulus::cli {

namespace fs = std::filesystem;

const char* const STRATEGY_IMAGES_HELP =
    "Folder for two EXR files per strategy, and a contact sheet of them: TECHNIQUE-sS-tT-weighted.exr is "
    "what "
    "paths that TECHNIQUE made of S vertices from the light and T from the camera (lens included; a merge "
    "counts the merged vertex in both) add to the picture, so that these files sum to it; "
    "-unweighted.exr is what the strategy finds without the others. sheet.png: a row per path length, S "
    "grows to the right, merges after the others; weighted above, unweighted below";

namespace {

constexpr const char *SHEET = "sheet.png", *WEIGHTED = "-weighted.exr", *UNWEIGHTED = "-unweighted.exr";

// Longest side of a picture on the sheet, pixels; and the space around it.
constexpr uint32_t THUMBNAIL = 96, MARGIN = 2;

// The mean of blocks of pixels; what is left over at the border is left out.
image::Image thumbnail(const image::Image& whole) {
  const uint32_t factor = std::max(1u, std::max(whole.width, whole.height) / THUMBNAIL);
  image::Image small{whole.width / factor, whole.height / factor, {}};
  small.width = std::max(small.width, 1u);
  small.height = std::max(small.height, 1u);
  small.rgb.resize(3ull * small.width * small.height);
  const uint32_t block_width = std::min(factor, whole.width), block_height = std::min(factor, whole.height);
  for (uint64_t i = 0; i < small.rgb.size(); ++i) {
    const uint64_t channel = i % 3, x = i / 3 % small.width * block_width,
                   y = i / 3 / small.width * block_height;
    double sum = 0;
    for (uint64_t dy = 0; dy < block_height; ++dy)
      for (uint64_t dx = 0; dx < block_width; ++dx)
        sum += whole.rgb[3 * ((y + dy) * whole.width + x + dx) + channel];
    small.rgb[i] = static_cast<float>(sum / (double{1} * block_width * block_height));
  }
  return small;
}

// Pictures in rows and columns.
class Sheet {
 public:
  void place(uint32_t row, uint32_t column, const image::Image& whole) {
    pictures_[{row, column}] = thumbnail(whole);
    rows_ = std::max(rows_, row + 1);
    columns_ = std::max(columns_, column + 1);
  }

  image::Image compose() const {
    if (pictures_.empty()) return {1, 1, {0, 0, 0}};
    const image::Image& any = pictures_.begin()->second;
    const uint32_t step_x = any.width + MARGIN, step_y = any.height + MARGIN;
    image::Image sheet{columns_ * step_x, rows_ * step_y, {}};
    sheet.rgb.assign(3ull * sheet.width * sheet.height, 0.1f);
    for (const auto& [place, picture] : pictures_)
      for (uint64_t y = 0; y < picture.height; ++y)
        std::copy_n(&picture.rgb[3 * y * picture.width], 3ull * picture.width,
                    &sheet.rgb[3 * ((place.first * step_y + y) * sheet.width + place.second * step_x)]);
    return sheet;
  }

 private:
  std::map<std::pair<uint32_t, uint32_t>, image::Image> pictures_;
  uint32_t rows_ = 0, columns_ = 0;
};

}  // namespace

void make_strategy_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!fs::is_directory(folder, error))
    throw Error(ErrorCode::Failed,
                fmt::format("--strategy-images {}: cannot make this folder; name another", folder.string()));
}

std::vector<fs::path> strategy_files(const fs::path& folder, const render::RenderSettings& settings) {
  std::vector<fs::path> files = {folder / SHEET};
  const uint32_t techniques = settings.techniques.value_or(render::ALL_TECHNIQUES);
  for (const render::Strategy& strategy : render::list_strategies(techniques, settings.max_depth))
    for (const char* ending : {WEIGHTED, UNWEIGHTED}) files.push_back(folder / (strategy.name() + ending));
  return files;
}

void write_strategy_images(OutputWriter& writer, const fs::path& folder, const render::Renderer& renderer,
                           uint32_t max_depth, const image::Attributes& attributes, float exposure_ev) {
  Sheet sheet;
  renderer.for_each_strategy([&](const render::StrategyImages& images) {
    const render::Strategy& strategy = images.strategy;
    const auto write = [&](const char* ending, const image::Image& picture) {
      const fs::path file = folder / (strategy.name() + ending);
      writer.write(file, [&] { return image::encode_exr(picture, attributes, {}, {}, file.string()); });
    };
    write(WEIGHTED, images.weighted);
    write(UNWEIGHTED, images.unweighted);
    // Without merges a path of k edges has s = 0 ... k.
    const uint32_t column = strategy.is_merge() ? max_depth + strategy.s - 1 : strategy.s;
    sheet.place(strategy.edges() - 1, column, images.weighted);
    sheet.place(max_depth + strategy.edges() - 1, column, images.unweighted);
  });
  writer.write(folder / SHEET, [&] {
    return image::encode_tone_mapped(image::Format::Png, sheet.compose(), exposure_ev, SHEET);
  });
}

}  // namespace regulus::cli
