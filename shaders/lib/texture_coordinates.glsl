// Where textures are looked up at a point of a triangle.
#ifndef REGULUS_LIB_TEXTURE_COORDINATES_GLSL
#define REGULUS_LIB_TEXTURE_COORDINATES_GLSL

#include "lib/buffers.glsl"
#include "lib/specialization.glsl"

struct TextureCoordinates {
  vec2 own;  // interpolated between the vertices' own
  // With FEATURE_UV_SETS, what reading further sets takes:
  uvec3 corners;
  vec2 barycentrics;
};

TextureCoordinates texture_coordinates(Triangle triangle, vec2 uv0, vec2 uv1, vec2 uv2, vec2 barycentrics) {
  float b0 = 1.0 - barycentrics.x - barycentrics.y;
  return TextureCoordinates(b0 * uv0 + barycentrics.x * uv1 + barycentrics.y * uv2,
                            uvec3(triangle.v0, triangle.v1, triangle.v2), barycentrics);
}

// Set 1 and up (see interface::Texture).
vec2 further_coordinates(Frame frame, TextureCoordinates at, uint set) {
  uvec3 index = at.corners * frame.vertex_uv_sets + (set - 1u);
  return (1.0 - at.barycentrics.x - at.barycentrics.y) * LOAD(Vec2Buffer, frame.vertex_uvs, index.x) +
         at.barycentrics.x * LOAD(Vec2Buffer, frame.vertex_uvs, index.y) +
         at.barycentrics.y * LOAD(Vec2Buffer, frame.vertex_uvs, index.z);
}

// Where an image is looked up (glTF: (0, 0) is its top left corner).
vec2 image_coordinates(Frame frame, Texture image, TextureCoordinates at) {
  vec2 uv = at.own;
  if ((spec_features & FEATURE_UV_SETS) != 0u) {
    uint set = (image.flags >> TEXTURE_SET_SHIFT) & TEXTURE_SET_MASK;
    if (set != 0u) uv = further_coordinates(frame, at, set);
  }
  if ((spec_features & FEATURE_TEXTURE_MAPPINGS) != 0u && (image.flags & TEXTURE_MAPPED) != 0u)
    uv = vec2(dot(image.map_u, vec3(uv, 1.0)), dot(image.map_v, vec3(uv, 1.0)));
  return uv;
}

#endif
