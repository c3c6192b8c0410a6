// The light tree: next-event estimation chooses a light by what it can send to the surface (Conty Estevez and Kulla,
// "Importance Sampling of Many Lights with Adaptive Tree Splitting", 2018; the BVHLightSampler of pbrt-v4). The walk goes
// to one of two nodes in proportion to their importances, so that a light's probability is the product of the shares along
// its way. Whatever can be lit has an importance above 0.
// Importance is intensity times the cosines at light and receiver over the squared distance, of lights in a sphere with
// normals in a ball: each cosine is bounded as a height over the distance, without a trigonometric function.
#ifndef REGULUS_LIB_LIGHT_TREE_GLSL
#define REGULUS_LIB_LIGHT_TREE_GLSL

#include "lib/buffers.glsl"
#include "lib/numerics.glsl"
#if REGULUS_INT64
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#endif

// Pairs are read 64 bits at a time where the device can: what counts on CPU drivers is the number of loads.
#if REGULUS_INT64
struct LightPairRecord {
  uint64_t words[4];
};
#define LIGHT_PAIR_WORDS(words) unpack32(words)
#else
struct LightPairRecord {
  uvec2 words[4];
};
#define LIGHT_PAIR_WORDS(words) (words)
#endif
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer LightPairRecords { LightPairRecord items[]; };

// A light that was chosen with a probability. INVALID_INDEX: none can reach the receiver.
struct LightChoice {
  uint light;
  float probability;
};

// A random number has 24 digits. Down to nodes of this probability 12 of them remain; then the next number takes over.
const float LAST_OF_FIRST_NUMBER = 1.0 / 4096.0;

// A node that can send light has at least this share, however bright its sibling looks: the sibling may be hidden.
const float LEAST_SHARE = 1.0 / 1048576.0;

// Where a walk is: at a pair, and how its parent's sphere lies towards the receiver.
struct LightTreeWalk {
  uint pair;
  vec3 from_center;  // to the receiver
  float radius;
};

LightTreeWalk start_light_walk(LightTreeRoot root, LightReceiver receiver) {
  return LightTreeWalk(0u, receiver.position - root.center, root.radius);
}

vec4 light_pair_bytes(uint word) { return vec4(uvec4(word, word >> 8u, word >> 16u, word >> 24u) & 0xFFu); }

vec4 light_pair_signed_bytes(uint word) { return light_pair_bytes(word) - vec4(128.0, 128.0, 128.0, 0.0); }

// Importance of a node times the fourth power of its distance, for an intensity of 1; from_center and radius are those of
// the node's sphere.
float light_importance(vec3 from_center, float radius, uint normals, bool is_two_sided, vec3 receiver_normal,
                       out float squared_distance) {
  float squared = dot(from_center, from_center);
  squared_distance = max(max(squared, radius * radius), 1e-30);
  float distance = sqrt(squared), least = sqrt(squared_distance);
  vec4 ball = light_pair_signed_bytes(normals);
  float along_axis = dot(ball.xyz, from_center) * (1.0 / 127.0);
  if (is_two_sided) along_axis = abs(along_axis);
  float light_height = along_axis + ball.w * (2.0 / 255.0) * distance + radius;
  float receiver_height = receiver_normal != vec3(0.0) ? radius - dot(receiver_normal, from_center) : least;
  return clamp(light_height, 0.0, least) * clamp(receiver_height, 0.0, least);
}

// A pair, and what a walk needs to know of its two nodes.
struct LightPairChoice {
  vec2 shares;  // of both, each rounded for itself: 1 less the other would lose the digits of a small one.
                // Negative if neither can be chosen
  uvec2 places, children;
  bool is_fixed;
};

LightPairChoice weigh_light_pair(LightTreeRoot root, LightTreeWalk walk, vec3 receiver_normal) {
#define PAIR_WORDS(i) LIGHT_PAIR_WORDS(LightPairRecords(root.pairs).items[walk.pair].words[i])
  uvec2 places = PAIR_WORDS(0), normals = PAIR_WORDS(1), children = PAIR_WORDS(2), share_and_flags = PAIR_WORDS(3);
#undef PAIR_WORDS
  float first_share = uintBitsToFloat(share_and_flags.x);
  uint flags = share_and_flags.y;
  vec4 first_place = light_pair_signed_bytes(places.x), second_place = light_pair_signed_bytes(places.y);
  float unit = walk.radius * (1.0 / 127.0), scale = walk.radius * (1.0 / 255.0), first_squared, second_squared;
  float first = first_share * light_importance(walk.from_center - unit * first_place.xyz, scale * first_place.w, normals.x,
                                               (flags & LIGHT_PAIR_TWO_SIDED) != 0u, receiver_normal, first_squared);
  float second = (1.0 - first_share) *
                 light_importance(walk.from_center - unit * second_place.xyz, scale * second_place.w, normals.y,
                                  (flags & LIGHT_PAIR_TWO_SIDED << 1u) != 0u, receiver_normal, second_squared);
  second *= square(clamp(first_squared / second_squared, 1e-12, 1e12));
  float sum = first + second;
  vec2 shares = sum > 0.0 ? vec2(first, second) / sum : vec2(-1.0);
  if (first > 0.0 && second > 0.0) shares = clamp(shares, LEAST_SHARE, 1.0 - LEAST_SHARE);
  bool is_fixed = (flags & LIGHT_PAIR_FIXED) != 0u;
  if (is_fixed) shares = vec2(first_share, 1.0 - first_share);
  return LightPairChoice(shares, places, children, is_fixed);
}

// Goes on to the first or the second node of a pair.
LightTreeWalk descend_light_pair(LightTreeWalk walk, LightPairChoice pair, bool takes_first) {
  walk.pair = takes_first ? pair.children.x : pair.children.y;
  if (pair.is_fixed) return walk;
  vec4 place = light_pair_signed_bytes(takes_first ? pair.places.x : pair.places.y);
  walk.from_center -= walk.radius * (1.0 / 127.0) * place.xyz;
  walk.radius *= place.w * (1.0 / 255.0);
  return walk;
}

LightChoice choose_by_tree(LightTreeRoot root, LightReceiver receiver, vec2 u) {
  LightTreeWalk walk = start_light_walk(root, receiver);
  float number = u.x, probability = 1.0;
  bool is_first_number = true;
  for (uint depth = 0u; depth < MAX_LIGHT_TREE_DEPTH; ++depth) {
    LightPairChoice pair = weigh_light_pair(root, walk, receiver.normal);
    if (pair.shares.x < 0.0) break;
    bool takes_first = number < pair.shares.x;
    float taken = takes_first ? pair.shares.x : pair.shares.y;
    number = min((takes_first ? number : number - pair.shares.x) / taken, ONE_MINUS_ULP);
    probability *= taken;
    if (is_first_number && probability < LAST_OF_FIRST_NUMBER) {
      number = u.y;
      is_first_number = false;
    }
    walk = descend_light_pair(walk, pair, takes_first);
    if ((walk.pair & LIGHT_PAIR_LEAF) != 0u) return LightChoice(walk.pair & ~LIGHT_PAIR_LEAF, probability);
  }
  return LightChoice(INVALID_INDEX, 0.0);
}

// Probability with which choose_by_tree returns the light.
float tree_probability(LightTreeRoot root, LightReceiver receiver, uint light) {
  uint trail = LOAD(WordBuffer, root.trails, light);
  LightTreeWalk walk = start_light_walk(root, receiver);
  float probability = 1.0;
  for (uint depth = 0u; depth < MAX_LIGHT_TREE_DEPTH && (walk.pair & LIGHT_PAIR_LEAF) == 0u; ++depth) {
    LightPairChoice pair = weigh_light_pair(root, walk, receiver.normal);
    bool takes_first = (trail >> depth & 1u) == 0u;
    probability *= max(takes_first ? pair.shares.x : pair.shares.y, 0.0);
    walk = descend_light_pair(walk, pair, takes_first);
  }
  return probability;
}

#endif
