// A case of the kernel energy_albedo.
#ifndef REGULUS_TESTS_ENERGY_CASE_H
#define REGULUS_TESTS_ENERGY_CASE_H

#include "interface/scene.h"

REGULUS_INTERFACE_BEGIN

struct EnergyCase {
  Material material;
  DeviceAddress tables;
  float cosine;   // of the direction from which the surface is seen
  uint is_front;
};
REGULUS_LAYOUT(EnergyCase, 228);

REGULUS_INTERFACE_END

#endif
