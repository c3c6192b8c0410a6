// Alpha: which part of a surface is there. A masked surface is there where its alpha reaches the cut-off, a blended
// one with the probability alpha (lib/alpha.glsl).
#ifndef REGULUS_LIB_COVERAGE_GLSL
#define REGULUS_LIB_COVERAGE_GLSL

#include "lib/geometry.glsl"
#include "lib/texture.glsl"

// Share of the surface that is there, in [0, 1], at barycentrics of a triangle. 1 without FEATURE_ALPHA.
float coverage_at(Frame frame, Triangle triangle, vec2 barycentrics) {
  if ((spec_features & FEATURE_ALPHA) == 0u) return 1.0;
  Material material = LOAD(MaterialBuffer, frame.materials, triangle.material);
  if ((material.flags & (MATERIAL_ALPHA_MASK | MATERIAL_ALPHA_BLEND)) == 0u) return 1.0;
  float alpha = material.alpha * vertex_color(frame, triangle, barycentrics).a;
  if ((spec_features & FEATURE_TEXTURES) != 0u && material.alpha_texture != INVALID_INDEX) {
    TextureCoordinates uv = texture_coordinates(triangle, LOAD(VertexBuffer, frame.vertices, triangle.v0).uv,
                                                LOAD(VertexBuffer, frame.vertices, triangle.v1).uv,
                                                LOAD(VertexBuffer, frame.vertices, triangle.v2).uv, barycentrics);
    alpha *= sample_texture(frame, material.alpha_texture, uv).a;
  }
  if ((material.flags & MATERIAL_ALPHA_MASK) != 0u) return alpha >= material.alpha_cutoff ? 1.0 : 0.0;
  return alpha;
}

#endif
