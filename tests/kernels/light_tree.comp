// light_tree: what the light tree chooses for each query, and the probability of the query's light.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/light_tree.glsl"
#include "light_tree_batch.h"

layout(local_size_x = 64) in;

REGULUS_BUFFER(QueryBuffer, LightQuery);
REGULUS_BUFFER(AnswerBuffer, LightAnswer);

layout(push_constant, scalar) uniform BatchArguments {
  uvec2 inputs;
  uvec2 outputs;
  uint count;
  uint parameter;
};

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  LightQuery query = LOAD(QueryBuffer, inputs, i);
  LightChoice choice = choose_by_tree(query.root, query.receiver, query.u);
  STORE(AnswerBuffer, outputs, i,
        LightAnswer(choice.light, choice.probability, tree_probability(query.root, query.receiver, query.light)));
}
