// What the host hands to the ray query kernels of the benchmark and of the tests.
#ifndef REGULUS_BENCH_INTERFACE_H
#define REGULUS_BENCH_INTERFACE_H

#include "interface/types.h"

REGULUS_INTERFACE_BEGIN

struct BenchRay {
  vec3 origin;
  float t_max;
  vec3 direction;
  float reserved;
};
REGULUS_LAYOUT(BenchRay, 32);

struct BenchArguments {
  DeviceAddress nodes;
  DeviceAddress triangles;
  DeviceAddress rays;
  DeviceAddress results;
  DeviceAddress overruns;  // one word: rays that were given up
  uint ray_count;
};
REGULUS_LAYOUT(BenchArguments, 44);

REGULUS_INTERFACE_END

#endif
