#include "session/film_memory.hpp"

#include <fmt/format.h>

#include <bit>

#include "base/error.hpp"
#include "base/machine_memory.hpp"
#include "interface/wavefront.h"

namespace regulus::session {

namespace {

// What is written exists at most so many times: as values, encoded, and in the library's buffer.
constexpr uint64_t COPIES_IN_WRITING = 3;

uint64_t bytes_per_pixel(const render::RenderSettings& settings, bool holds_sums, bool is_in_bands) {
  uint64_t layers = 1;
  if ((settings.techniques.value_or(render::ALL_TECHNIQUES) & interface::TECHNIQUE_SPLAT) != 0) ++layers;
  if ((settings.aovs & render::AOV_VARIANCE) != 0) layers += 2;
  // Of groups of lights as many as there are kinds.
  const auto kinds = static_cast<uint64_t>(std::popcount(settings.aovs & render::LIGHT_AOVS));
  layers += kinds * layers + ((settings.aovs & render::AOV_LIGHTS) != 0 ? interface::LIGHT_KINDS - 1 : 0);
  const uint64_t sums = layers * interface::FILM_WORDS_PER_PIXEL * sizeof(uint32_t);
  const uint64_t rgb = 3 * sizeof(float);
  const auto aovs = static_cast<uint64_t>(std::popcount(settings.aovs)) * rgb;  // none has more channels
  uint64_t bytes = COPIES_IN_WRITING * (rgb + aovs + (holds_sums ? sums : 0));
  if ((settings.aovs & render::SURFACE_AOVS) != 0) bytes += sizeof(interface::AovPixel);
  // The next state is downloaded beside the last, and its noise is told from an earlier picture.
  if (!is_in_bands) bytes += 2 * sums + rgb;
  return bytes;
}

}  // namespace

void require_film_memory(const render::RenderSettings& settings, bool holds_sums, bool is_in_bands,
                         uint64_t memory_bytes) {
  const render::Window window = settings.window();
  const uint64_t allowed = memory_bytes != 0 ? memory_bytes : default_memory_bytes();
  const uint64_t needed = window.pixels() * bytes_per_pixel(settings, holds_sums, is_in_bands);
  if (needed <= allowed) return;
  const auto mebibytes = [](uint64_t bytes) { return static_cast<double>(bytes) / (1 << 20); };
  throw Error(
      ErrorCode::Failed,
      fmt::format("a film of {} x {} pixels needs {:.1f} MiB of this machine's memory, but {:.1f} MiB are "
                  "allowed; render crops of it or allow more",
                  window.width, window.height, mebibytes(needed), mebibytes(allowed)));
}

}  // namespace regulus::session
