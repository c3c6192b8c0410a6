// texel: outputs[i] = texel i of texture `parameter` of `inputs`, as a colour, and behind all of them as data.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/texture.glsl"

layout(local_size_x = 64) in;

layout(push_constant, scalar) uniform BatchArguments {
  uvec2 inputs;
  uvec2 outputs;
  uint count;
  uint parameter;
};

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  Texture image = LOAD(TextureBuffer, inputs, parameter);
  uint texels = image.width * image.height, number = i % texels;
  ivec2 place = ivec2(number % image.width, number / image.width);
  vec4 value = i < texels ? load_texel(image, place, true) : load_texel(image, place, false);
  STORE(Vec4Buffer, outputs, i, value);
}
