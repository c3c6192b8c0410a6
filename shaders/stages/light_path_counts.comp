// light_path_counts: the number of vertices of each light path, to be scanned.
// reads  light heads          writes  light path ends
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/stage.glsl"

void main() {
  uint i = stage.first_pixel + item_index();
  if (i >= FRAME.light_path_count) return;
  STORE(WordBuffer, FRAME.light_path_ends, i, LOAD(LightHeadBuffer, FRAME.light_heads, i).count);
}
