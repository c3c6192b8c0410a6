// The CIE's standard observer of 1931, from its table: what tests of colours compare with.
#pragma once

#include <glm/glm.hpp>
#include <vector>

namespace regulus::test {

/// X, Y, Z at every tenth nanometre from 380 to 770 (CIE 15, table T.4, to four decimals).
inline const std::vector<glm::dvec3>& observer() {
  static const std::vector<glm::dvec3> table = {
      {.0014, .0000, .0065},  {.0042, .0001, .0201},  {.0143, .0004, .0679},  {.0435, .0012, .2074},
      {.1344, .0040, .6456},  {.2839, .0116, 1.3856}, {.3483, .0230, 1.7471}, {.3362, .0380, 1.7721},
      {.2908, .0600, 1.6692}, {.1954, .0910, 1.2876}, {.0956, .1390, .8130},  {.0320, .2080, .4652},
      {.0049, .3230, .2720},  {.0093, .5030, .1582},  {.0633, .7100, .0782},  {.1655, .8620, .0422},
      {.2904, .9540, .0203},  {.4334, .9950, .0087},  {.5945, .9950, .0039},  {.7621, .9520, .0021},
      {.9163, .8700, .0017},  {1.0263, .7570, .0011}, {1.0622, .6310, .0008}, {1.0026, .5030, .0003},
      {.8544, .3810, .0002},  {.6424, .2650, .0000},  {.4479, .1750, .0000},  {.2835, .1070, .0000},
      {.1649, .0610, .0000},  {.0874, .0320, .0000},  {.0468, .0170, .0000},  {.0227, .0082, .0000},
      {.0114, .0041, .0000},  {.0058, .0021, .0000},  {.0029, .0010, .0000},  {.0014, .0005, .0000},
      {.0007, .0002, .0000},  {.0003, .0001, .0000},  {.0002, .0001, .0000},  {.0001, .0000, .0000}};
  return table;
}

/// Wavelength of the i-th entry, nm.
inline double observed(size_t i) {
  return 380 + 10 * static_cast<double>(i);
}

/// X, Y, Z in linear Rec. 709, without what is negative.
inline glm::dvec3 seen(const glm::dvec3& xyz) {
  return glm::max(glm::dvec3(3.2404542 * xyz.x - 1.5371385 * xyz.y - 0.4985314 * xyz.z,
                             -0.9692660 * xyz.x + 1.8760108 * xyz.y + 0.0415560 * xyz.z,
                             0.0556434 * xyz.x - 0.2040259 * xyz.y + 1.0572252 * xyz.z),
                  glm::dvec3(0));
}

}  // namespace regulus::test
