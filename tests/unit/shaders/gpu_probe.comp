// gpu_probe: out[i] = factor * in[i] + addend for i < count. The device tests chain it to see whether every
// command finds what the ones before it wrote.
#version 460
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_scalar_block_layout : require
#if REGULUS_INT64
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#endif

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const uint FACTOR = 1;

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Words { uint word[]; };

layout(push_constant, scalar) uniform Parameters {
  uvec2 source;
  uvec2 target;
  uint addend;
  uint count;
};

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
#if REGULUS_INT64
  Words(target).word[i] = uint(uint64_t(FACTOR) * Words(source).word[i] + addend);
#else
  Words(target).word[i] = FACTOR * Words(source).word[i] + addend;
#endif
}
