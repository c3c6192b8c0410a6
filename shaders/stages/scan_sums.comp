// scan_sums: on the way up a scan, the sum of each SCAN_FAN words.
// reads  words [source, source + count)          writes  words [sums, sums + ceil(count / SCAN_FAN))
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/scan.glsl"

void main() {
  uint first = gl_GlobalInvocationID.x * SCAN_FAN;
  if (first >= scan.count) return;
  uint last = min(first + SCAN_FAN, scan.count);
  uint sum = 0u;
  for (uint i = first; i < last; ++i) sum += LOAD(WordBuffer, scan.words, scan.source + i);
  STORE(WordBuffer, scan.words, scan.sums + gl_GlobalInvocationID.x, sum);
}
