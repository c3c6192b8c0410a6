// Batches of queries to the light tree.
#ifndef REGULUS_LIGHT_TREE_BATCH_H
#define REGULUS_LIGHT_TREE_BATCH_H

#include "interface/scene.h"

REGULUS_INTERFACE_BEGIN

struct LightQuery {
  LightReceiver receiver;
  vec2 u;
  uint light;
  LightTreeRoot root;
};
REGULUS_LAYOUT(LightQuery, 68);

struct LightAnswer {
  uint light;         // chosen; INVALID_INDEX: none
  float probability;  // with which it was
  float of_light;     // probability of the query's light
};
REGULUS_LAYOUT(LightAnswer, 12);

REGULUS_INTERFACE_END

#endif
