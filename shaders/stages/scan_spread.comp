// scan_spread: on the way down a scan, turns words into the exclusive sums of what stands before them.
// reads  words [sums, ...) already scanned          writes  words [source, source + count)
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/scan.glsl"

void main() {
  uint first = gl_GlobalInvocationID.x * SCAN_FAN;
  if (first >= scan.count) return;
  uint last = min(first + SCAN_FAN, scan.count);
  uint before = scan.sums == INVALID_INDEX ? 0u : LOAD(WordBuffer, scan.words, scan.sums + gl_GlobalInvocationID.x);
  for (uint i = first; i < last; ++i) {
    uint word = LOAD(WordBuffer, scan.words, scan.source + i);
    STORE(WordBuffer, scan.words, scan.source + i, before);
    before += word;
  }
}
