#include "session/join_windows.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.hpp"
#include "render/film_file.hpp"

namespace regulus::session {

namespace {

/// A part's pixels on the film: [x0, x1) x [y0, y1).
struct Rectangle {
  uint32_t x0, y0, x1, y1;
  uint64_t area() const { return uint64_t{x1 - x0} * (y1 - y0); }
};

Rectangle rectangle_of(const Part& part) {
  const image::Placement& place = part.contents.placement;
  return {place.x, place.y, place.x + part.film.width, place.y + part.film.height};
}

bool overlap(const Rectangle& a, const Rectangle& b) {
  return a.x0 < b.x1 && b.x0 < a.x1 && a.y0 < b.y1 && b.y0 < a.y1;
}

Rectangle bounds_of(const std::vector<Part>& parts) {
  Rectangle bounds = rectangle_of(parts.front());
  for (const Part& part : parts) {
    const Rectangle own = rectangle_of(part);
    bounds = {std::min(bounds.x0, own.x0), std::min(bounds.y0, own.y0), std::max(bounds.x1, own.x1),
              std::max(bounds.y1, own.y1)};
  }
  return bounds;
}

void require_tiles(const std::vector<Part>& parts, const Rectangle& bounds) {
  uint64_t area = 0;
  for (size_t i = 0; i < parts.size(); ++i) {
    area += rectangle_of(parts[i]).area();
    if (parts[i].ranges != parts.front().ranges ||
        parts[i].film.light_paths != parts.front().film.light_paths)
      throw Error(
          ErrorCode::BadFile,
          fmt::format("{} and {} show different crops and hold different samples; merge the samples of each "
                      "crop first, and render those that are missing",
                      parts.front().path.string(), parts[i].path.string()));
    for (size_t k = 0; k < i; ++k)
      if (overlap(rectangle_of(parts[i]), rectangle_of(parts[k])))
        throw Error(ErrorCode::BadFile, fmt::format("{} and {} show crops that overlap; give each pixel once",
                                                    parts[k].path.string(), parts[i].path.string()));
  }
  if (area != bounds.area())
    throw Error(
        ErrorCode::BadFile,
        fmt::format("{} and the others show crops that leave gaps in {},{},{},{}; render what is missing",
                    parts.front().path.string(), bounds.x0, bounds.y0, bounds.x1, bounds.y1));
}

/// Copies a part's values into those of the whole.
void place(const image::Channel& part, const Rectangle& from, image::Channel& whole,
           const Rectangle& bounds) {
  std::visit(
      [&](auto& values) {
        using Values = std::decay_t<decltype(values)>;
        values.resize(bounds.area());
        const auto* own = std::get_if<Values>(&part);
        const uint64_t width = from.x1 - from.x0;
        for (uint64_t row = 0; own != nullptr && row < from.y1 - from.y0; ++row)
          std::copy_n(&(*own)[row * width], width,
                      &values[(from.y0 - bounds.y0 + row) * (bounds.x1 - bounds.x0) + from.x0 - bounds.x0]);
      },
      whole);
}

}  // namespace

Part join_windows(std::vector<Part> parts) {
  if (parts.size() == 1) return std::move(parts.front());
  const Rectangle bounds = bounds_of(parts);
  require_tiles(parts, bounds);
  Part whole = parts.front();
  whole.film = render::empty_like(parts.front().film, bounds.x1 - bounds.x0, bounds.y1 - bounds.y0);
  whole.contents.placement.x = bounds.x0;
  whole.contents.placement.y = bounds.y0;
  whole.contents.attributes["regulus:crop"] =
      fmt::format("[{},{},{},{}]", bounds.x0, bounds.y0, bounds.x1, bounds.y1);
  for (const Part& part : parts) {
    const Rectangle own = rectangle_of(part);
    render::place(part.film, own.x0 - bounds.x0, own.y0 - bounds.y0, whole.film);
    for (auto& [name, channel] : whole.contents.channels) {
      const auto found = part.contents.channels.find(name);
      if (found != part.contents.channels.end()) place(found->second, own, channel, bounds);
    }
  }
  return whole;
}

}  // namespace regulus::session
