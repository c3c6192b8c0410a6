// Every load and store of device memory goes through this file: addresses are buffer device addresses, so
// how a record is laid out and moved is decided here alone.
#ifndef REGULUS_LIB_BUFFERS_GLSL
#define REGULUS_LIB_BUFFERS_GLSL

#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_scalar_block_layout : require

#include "interface/wavefront.h"

#define REGULUS_BUFFER(name, type) \
  layout(buffer_reference, scalar, buffer_reference_align = 4) buffer name { type items[]; }

REGULUS_BUFFER(WordBuffer, uint);
REGULUS_BUFFER(WordPairBuffer, uvec2);
REGULUS_BUFFER(FloatBuffer, float);
REGULUS_BUFFER(Vec2Buffer, vec2);
REGULUS_BUFFER(Vec3Buffer, vec3);
REGULUS_BUFFER(Vec4Buffer, vec4);
REGULUS_BUFFER(FrameBuffer, Frame);
REGULUS_BUFFER(VertexBuffer, Vertex);
REGULUS_BUFFER(TriangleBuffer, Triangle);
REGULUS_BUFFER(InstanceBuffer, Instance);
REGULUS_BUFFER(MaterialBuffer, Material);
REGULUS_BUFFER(SolidBuffer, Solid);
REGULUS_BUFFER(BvhTriangleBuffer, BvhTriangle);
REGULUS_BUFFER(MediaSetBuffer, MediaSet);
REGULUS_BUFFER(PathMediaBuffer, PathMedia);
REGULUS_BUFFER(TextureBuffer, Texture);
REGULUS_BUFFER(LightBuffer, Light);
REGULUS_BUFFER(LightAliasBuffer, LightAlias);
REGULUS_BUFFER(LightReceiverBuffer, LightReceiver);
REGULUS_BUFFER(GuidedLightBuffer, GuidedLight);
REGULUS_BUFFER(GuideNodeBuffer, GuideNode);
REGULUS_BUFFER(PathBuffer, Path);
REGULUS_BUFFER(HitBuffer, Hit);
REGULUS_BUFFER(CandidateBuffer, VisibilityCandidate);
REGULUS_BUFFER(QueueHeadBuffer, QueueHead);
REGULUS_BUFFER(SplatBuffer, SplatCandidate);
REGULUS_BUFFER(StrategyCandidateBuffer, StrategyCandidate);
REGULUS_BUFFER(CameraVertexBuffer, CameraVertex);
REGULUS_BUFFER(LightVertexBuffer, LightVertex);
REGULUS_BUFFER(PathHistoryBuffer, PathHistory);
REGULUS_BUFFER(LightHeadBuffer, LightPathHead);
REGULUS_BUFFER(ConnectionPairBuffer, ConnectionPair);
REGULUS_BUFFER(GridEntryBuffer, GridEntry);
REGULUS_BUFFER(AovPixelBuffer, AovPixel);
REGULUS_BUFFER(WavelengthBuffer, Wavelength);

// Record `index` of the array of `type` (one of the buffer types above) at `address`.
#define LOAD(type, address, index) (type(address).items[index])
#define STORE(type, address, index, value) (type(address).items[index] = (value))

// Adds to a word and returns what it held before.
#define ATOMIC_ADD(address, index, value) atomicAdd(WordBuffer(address).items[index], value)
#define ATOMIC_OR(address, index, value) atomicOr(WordBuffer(address).items[index], value)

#endif
