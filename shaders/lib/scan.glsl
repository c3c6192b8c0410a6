// The arguments of a scan, for its way up and its way down (host/render/scan.cpp records the levels).
#ifndef REGULUS_LIB_SCAN_GLSL
#define REGULUS_LIB_SCAN_GLSL

#include "lib/buffers.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
layout(push_constant, scalar) uniform PushConstants { ScanArguments scan; };

#endif
