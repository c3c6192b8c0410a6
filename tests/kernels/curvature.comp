// curvature: outputs[i] = mean_curvature of the three vertices inputs[i].
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/footprint.glsl"

layout(local_size_x = 64) in;

struct Corners {
  Vertex v0, v1, v2;
};
REGULUS_BUFFER(CornersBuffer, Corners);
REGULUS_BUFFER(CurvatureBuffer, float);

layout(push_constant, scalar) uniform BatchArguments {
  uvec2 inputs;
  uvec2 outputs;
  uint count;
  uint parameter;
};

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  Corners corners = LOAD(CornersBuffer, inputs, i);
  STORE(CurvatureBuffer, outputs, i, mean_curvature(corners.v0, corners.v1, corners.v2));
}
