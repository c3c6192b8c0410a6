// Textures as plain memory (see interface/scene.h): wrap, bilinear filter, and the material values at a
// point. Level 0 only: a footprint would depend on the direction of the walk, and with it the measured
// function (docs/mathematics.md 9).
#ifndef REGULUS_LIB_TEXTURE_GLSL
#define REGULUS_LIB_TEXTURE_GLSL

#include "interface/srgb.h"
#include "lib/buffers.glsl"
#include "lib/specialization.glsl"
#include "lib/texture_coordinates.glsl"

int wrap_texel(int index, int size, uint mode) {
  if (mode == TEXTURE_WRAP_CLAMP) return clamp(index, 0, size - 1);
  int period = mode == TEXTURE_WRAP_MIRROR ? 2 * size : size;
  int wrapped = index - period * int(floor(float(index) / float(period)));
  wrapped = clamp(wrapped, 0, period - 1);  // the division rounds: keep it in range
  return wrapped < size ? wrapped : period - 1 - wrapped;
}

// Texel of two words.
vec4 load_wide_texel(Texture image, uint index) {
  uvec2 words = LOAD(WordPairBuffer, image.texels, index);
  if ((image.flags & TEXTURE_HALF) != 0u) return vec4(unpackHalf2x16(words.x), unpackHalf2x16(words.y));
  return vec4(words.x & 0xFFFFu, words.x >> 16, words.y & 0xFFFFu, words.y >> 16) / 65535.0;
}

// Linear RGBA. `is_color`: 8-bit codes are sRGB. Callers pass a literal, because half of the cost is decoding.
vec4 load_texel(Texture image, ivec2 texel, bool is_color) {
  uint s_mode = image.flags & 3u, t_mode = (image.flags >> TEXTURE_WRAP_T_SHIFT) & 3u;
  int x = wrap_texel(texel.x, int(image.width), s_mode), y = wrap_texel(texel.y, int(image.height), t_mode);
  uint index = uint(y) * image.width + uint(x);
  if ((spec_features & FEATURE_WIDE_TEXELS) != 0u && (image.flags & (TEXTURE_UNORM16 | TEXTURE_HALF)) != 0u)
    return load_wide_texel(image, index);
  uint word = LOAD(WordBuffer, image.texels, index);
  vec3 color = vec3(word & 0xFFu, (word >> 8) & 0xFFu, (word >> 16) & 0xFFu);
  float alpha = code_to_fraction(float(word >> 24));
  if (is_color) return vec4(srgb_code_to_linear(color.r), srgb_code_to_linear(color.g), srgb_code_to_linear(color.b), alpha);
  return vec4(code_to_fraction(color.r), code_to_fraction(color.g), code_to_fraction(color.b), alpha);
}

// Linear RGBA of texture `index` at a point with these coordinates (see texture_coordinates). White if the index is
// INVALID_INDEX. `is_color`: see load_texel.
vec4 sample_texels(Frame frame, uint index, TextureCoordinates coordinates, bool is_color) {
  if (index == INVALID_INDEX) return vec4(1.0);
  Texture image = LOAD(TextureBuffer, frame.textures, index);
  vec2 uv = image_coordinates(frame, image, coordinates);
  // Far from 0, float coordinates cannot tell texels apart: bring repeating ones near 0 first.
  vec2 near_uv = uv - 2.0 * floor(0.5 * uv);
  bvec2 clamps = bvec2((image.flags & 3u) == TEXTURE_WRAP_CLAMP,
                       ((image.flags >> TEXTURE_WRAP_T_SHIFT) & 3u) == TEXTURE_WRAP_CLAMP);
  vec2 position = mix(near_uv, clamp(uv, -1.0, 2.0), clamps) * vec2(image.width, image.height);
  if ((image.flags & TEXTURE_NEAREST) != 0u) return load_texel(image, ivec2(floor(position)), is_color);
  vec2 corner = floor(position - 0.5);
  vec2 weight = position - 0.5 - corner;
  ivec2 texel = ivec2(corner);
  vec4 top = mix(load_texel(image, texel, is_color), load_texel(image, texel + ivec2(1, 0), is_color), weight.x);
  vec4 bottom = mix(load_texel(image, texel + ivec2(0, 1), is_color), load_texel(image, texel + ivec2(1, 1), is_color), weight.x);
  return mix(top, bottom, weight.y);
}

// The same for a texture that holds data, and for one whose RGB are a colour.
vec4 sample_texture(Frame frame, uint index, TextureCoordinates coordinates) {
  return sample_texels(frame, index, coordinates, false);
}
vec4 sample_color_texture(Frame frame, uint index, TextureCoordinates coordinates) {
  return sample_texels(frame, index, coordinates, true);
}

// Multiplies the factors of a material by the vertex colour and by their textures at uv.
void apply_textures(Frame frame, TextureCoordinates uv, vec4 color, inout Material material) {
  if ((spec_features & FEATURE_VERTEX_COLORS) != 0u) material.base_color *= color.rgb;
  if ((spec_features & FEATURE_TEXTURES) == 0u) return;
  material.base_color *= sample_color_texture(frame, material.base_color_texture, uv).rgb;
  if (spec_material_class == MATERIAL_CLASS_DIFFUSE) return;
  vec4 metallic_roughness = sample_texture(frame, material.metallic_roughness_texture, uv);
  material.roughness *= metallic_roughness.g;
  material.metallic *= metallic_roughness.b;
  if ((spec_features & FEATURE_SPECULAR_TEXTURES) != 0u) {
    material.specular *= sample_texture(frame, material.specular_texture, uv).a;
    material.specular_color *= sample_color_texture(frame, material.specular_color_texture, uv).rgb;
  }
  if ((spec_features & FEATURE_CLEARCOAT) != 0u) {
    material.clearcoat *= sample_texture(frame, material.clearcoat_texture, uv).r;
    material.clearcoat_roughness *= sample_texture(frame, material.clearcoat_roughness_texture, uv).g;
  }
  if ((spec_features & FEATURE_SHEEN) != 0u) {
    material.sheen_color *= sample_color_texture(frame, material.sheen_color_texture, uv).rgb;
    material.sheen_roughness *= sample_texture(frame, material.sheen_roughness_texture, uv).a;
  }
  if ((spec_features & FEATURE_IRIDESCENCE) != 0u) {
    material.iridescence *= sample_texture(frame, material.iridescence_texture, uv).r;
    vec2 range = material.iridescence_thickness;
    material.iridescence_thickness.y = mix(range.x, range.y, sample_texture(frame, material.iridescence_thickness_texture, uv).g);
  }
  if (spec_material_class == MATERIAL_CLASS_TRANSMISSIVE)
    material.transmission *= sample_texture(frame, material.transmission_texture, uv).r;
}

// Radiance a material emits at uv, with its emission factor (or the one of the light that stands for it) and the
// vertex colour there.
vec3 emitted_radiance(Frame frame, Material material, vec3 factor, TextureCoordinates uv, vec4 color) {
  if ((spec_features & FEATURE_VERTEX_COLORS) != 0u && (material.flags & MATERIAL_UNLIT) != 0u) factor *= color.rgb;
  if ((spec_features & FEATURE_TEXTURES) == 0u) return factor;
  return factor * sample_color_texture(frame, material.emissive_texture, uv).rgb;
}

#endif
