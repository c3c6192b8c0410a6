// The vocabulary that lets one header be read by both C++ and GLSL. Structs that cross the border are
// written with these types only; GLSL lays them out with the `scalar` rules, which for these types are
// C++'s own rules. Each struct is followed by REGULUS_LAYOUT(Struct, bytes), checked when C++ compiles it.
#ifndef REGULUS_INTERFACE_TYPES_H
#define REGULUS_INTERFACE_TYPES_H

#ifdef __cplusplus

#include <cstdint>
#include <glm/glm.hpp>
#include <type_traits>

#define REGULUS_INTERFACE_BEGIN namespace regulus::interface {
#define REGULUS_INTERFACE_END }
#define REGULUS_CONSTANT inline constexpr uint32_t
#define REGULUS_LAYOUT(type, bytes) \
  static_assert(sizeof(type) == (bytes) && std::is_trivially_copyable_v<type>, #type " must match its GLSL layout")

REGULUS_INTERFACE_BEGIN
using uint = uint32_t;
using glm::uvec2;
using glm::uvec4;
using glm::vec2;
using glm::vec3;
using glm::vec4;
REGULUS_INTERFACE_END

#else

#define REGULUS_INTERFACE_BEGIN
#define REGULUS_INTERFACE_END
#define REGULUS_CONSTANT const uint
#define REGULUS_LAYOUT(type, bytes)

#endif

REGULUS_INTERFACE_BEGIN

// DeviceAddress: a buffer device address as (low, high) words, so that devices without 64-bit integers can
// hold it.
#ifdef __cplusplus
using DeviceAddress = glm::uvec2;
inline DeviceAddress device_address(uint64_t address) {
  return {static_cast<uint32_t>(address), static_cast<uint32_t>(address >> 32)};
}
#else
#define DeviceAddress uvec2
#endif

REGULUS_CONSTANT INVALID_INDEX = 0xFFFFFFFFu;

REGULUS_INTERFACE_END

#endif
