// Closest-hit and any-hit queries against the acceleration structure of interface/bvh.h. Watertight: rays do
// not slip between triangles that share an edge or a vertex, and no box test loses a hit that the triangle
// test would accept. The stack lives in shared memory, which CPU drivers handle faster than a private array;
// workgroups must have WORKGROUP_SIZE invocations. What counts on CPU drivers is the number of loads: each is
// a loop over the lanes of a vector. So loads are 64 bits wide, and the root is visited outside of the loop,
// where its address is the same for all lanes: it is loaded once for all if the query is called where all
// invocations of the workgroup are active (no early return before it).
#ifndef REGULUS_LIB_TRAVERSAL_GLSL
#define REGULUS_LIB_TRAVERSAL_GLSL

#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_scalar_block_layout : require
#if REGULUS_INT64
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#endif

#include "interface/wavefront.h"
#include "lib/placement.glsl"

// Whether a ray that meets a triangle meets its surface: (tag, triangle, barycentrics, origin, direction), the instance of an
// index, and the stored triangle that the device's own structure calls (geometry, primitive). lib/alpha.glsl defines these. In
// a bare tree, which is no scene, all surfaces are whole and stored in place.
#ifndef TRAVERSAL_IS_COVERED
#ifndef TRAVERSAL_OF_A_BARE_TREE
#error "rays of a scene are traced through lib/scene_query.glsl, which knows where its surfaces have holes"
#endif
#define TRAVERSAL_IS_COVERED(tag, triangle, barycentrics, origin, direction) true
#define TRAVERSAL_PLACED_TRIANGLE(geometry, primitive) (primitive)
#define TRAVERSAL_HAS_INSTANCES false
#define TRAVERSAL_INSTANCE(index) Instance(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), \
                                           vec3(0.0), 0u, 0u, 0u, 0u, 0u)
#endif

// How rays order the surfaces that they meet, if not by distance alone: lib/contacts.glsl.
#define TRAVERSAL_NEVER 3.4e38
#ifndef TRAVERSAL_HAS_CONTACTS
#define TRAVERSAL_HAS_CONTACTS false
#define TRAVERSAL_CONTACT_KEY(tag, number, t, cosine) vec2(t, 0.0)
#define TRAVERSAL_CONTACT_ORDER(tag, number, cosine) 0u
#define TRAVERSAL_CONTACT_REACH(t) 0.0
#define TRAVERSAL_CONTACT_GOES_ON(hit, tag) false
#endif

// Rays that were given up because they reached TRAVERSAL_MAX_STEPS; the hit found so far is returned.
uint traversal_overrun = 0u;

// Most node visits plus triangle tests of one invocation. One driver silently ends loops after 65,535 iterations of
// all loops together, and lanes of a vector share that budget.
const uint TRAVERSAL_MAX_STEPS = 16384u;

// Nothing left to visit.
const uint TRAVERSAL_DONE = 0xFFFFFFFFu;
// Nothing left to visit in the current instance. The last reference below BVH_LEAF_BIT, which no instance has.
const uint TRAVERSAL_LEAVE = BVH_LEAF_BIT - 1u;
// TraversalRay.instance_floor outside of instances.
const uint TRAVERSAL_NO_FLOOR = 0xFFFFFFFFu;

// Error of an instance's ray in its mesh's space, in units of |inverse| (|origin - translation| + reach): nine roundings.
// Five of each coordinate of a vertex on its way to world space; of the ray's origin one of the difference, one of the
// inverse and three of the product; and four of its direction at the distance of the vertex.
const float TRAVERSAL_INSTANCE_ERROR = 12.0 / 16777216.0;

// Direction components are kept this far from zero in the slab test: finite reciprocals, and a shift of the
// ray that stays within the margin of the boxes.
const float TRAVERSAL_MIN_DIRECTION = 1e-18;

// The far planes are scaled by 1 + 32 * 2^-24. Slab and triangle test together err by at most 16 * 2^-24 of
// the distance for each of near and far plane, with a division of 2.5 ulp as Vulkan allows (Ize, "Robust BVH
// Ray Traversal", JCGT 2013; what is relative to the node's extent is in the margin of the boxes).
const float TRAVERSAL_FAR_SCALE = 1.0000019;

const float TRAVERSAL_FLOAT_MAX = 3.402823466e38;

// From this length on, an any-hit ray counts as one without an end.
const float TRAVERSAL_UNBOUNDED = 1e30;

// Pairs of words, moved as one where the device can.
#if REGULUS_INT64
#define TRAVERSAL_PAIR uint64_t
#define TRAVERSAL_PACK(words) pack64(words)
#define TRAVERSAL_UNPACK(pair) unpack32(pair)
#else
#define TRAVERSAL_PAIR uvec2
#define TRAVERSAL_PACK(words) (words)
#define TRAVERSAL_UNPACK(pair) (pair)
#endif

// Groups (see TraversalGroup) still to visit, deepest last.
shared TRAVERSAL_PAIR traversal_stack[BVH_MAX_DEPTH * WORKGROUP_SIZE];

struct TraversalNode {
  TRAVERSAL_PAIR pairs[12];
};
struct TraversalTriangle {
  TRAVERSAL_PAIR pairs[5];
};
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer TraversalNodes {
  TraversalNode nodes[];
};
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer TraversalTriangles {
  TraversalTriangle triangles[];
};
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer TraversalNodeRecords {
  BvhNode nodes[];
};

// Children of a node that are still to visit. `rest` is a key (below) whose distance bounds theirs from below
// and whose slot is the best next one unless it was visited already.
struct TraversalGroup {
  uint node_and_mask;  // node index << 8 | bit (slot ^ order) for each child
  uint rest;
};

// What is constant along a ray, or along its way through an instance. Boxes are met in the space of the instance's mesh, by
// a ray whose distances are those in the world; triangles are met in the world, to which their vertices are taken.
struct TraversalRay {
  vec3 origin;
  vec3 box_origin;        // origin as boxes see it
  vec3 slack;             // in instances, how far t of the boxes' planes may be wrong
  uint instance_floor;    // height of the stack below the current instance
  uint number_offset;     // of triangles: number - index
  bool is_mirrored;
  vec3 x_axis, y_axis, z_axis, translation;  // see Instance
  vec3 inverse_direction;
  vec3 inverse_direction_far;
  uint order;        // children are visited by ascending slot ^ order
  bool is_far_first;
  // The triangle test works in the frame of Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection",
  // JCGT 2013: the axis of the longest direction component is exchanged with z, then x and y are sheared
  // so that the ray runs along z.
  bool x_is_longest;
  bool y_is_longest;
  vec3 shear;        // x / z, y / z and 1 / z of the exchanged direction
};

vec3 traversal_exchange(TraversalRay ray, vec3 v) {
  return vec3(ray.x_is_longest ? v.z : v.x, ray.y_is_longest ? v.z : v.y,
              ray.x_is_longest ? v.x : (ray.y_is_longest ? v.y : v.z));
}

float traversal_safe_component(float d) {
  float least = d < 0.0 ? -TRAVERSAL_MIN_DIRECTION : TRAVERSAL_MIN_DIRECTION;
  return abs(d) < TRAVERSAL_MIN_DIRECTION ? least : d;
}

// Sets the members that concern boxes. The direction need not be of unit length.
void traversal_set_boxes(vec3 origin, vec3 direction, inout TraversalRay ray) {
  ray.box_origin = origin;
  vec3 safe = vec3(traversal_safe_component(direction.x), traversal_safe_component(direction.y),
                   traversal_safe_component(direction.z));
  ray.inverse_direction = 1.0 / safe;
  ray.inverse_direction_far = ray.inverse_direction * TRAVERSAL_FAR_SCALE;
  uint octant = (safe.x < 0.0 ? 1u : 0u) | (safe.y < 0.0 ? 2u : 0u) | (safe.z < 0.0 ? 4u : 0u);
  ray.order = ray.is_far_first ? octant ^ 7u : octant;
}

// Sets the members for the world, where no vertex needs to be moved.
void traversal_set_world(vec3 origin, vec3 direction, inout TraversalRay ray) {
  traversal_set_boxes(origin, direction, ray);
  ray.slack = vec3(0.0);
  ray.instance_floor = TRAVERSAL_NO_FLOOR;
  ray.number_offset = 0u;
  ray.is_mirrored = false;
  ray.x_axis = vec3(1.0, 0.0, 0.0);
  ray.y_axis = vec3(0.0, 1.0, 0.0);
  ray.z_axis = vec3(0.0, 0.0, 1.0);
  ray.translation = vec3(0.0);
}

TraversalRay traversal_ray(vec3 origin, vec3 direction, bool is_far_first) {
  TraversalRay ray;
  ray.origin = origin;
  ray.is_far_first = is_far_first;
  traversal_set_world(origin, direction, ray);
  vec3 size = abs(direction);
  ray.x_is_longest = size.x > size.y && size.x >= size.z;
  ray.y_is_longest = !ray.x_is_longest && size.y > size.z;
  vec3 exchanged = traversal_exchange(ray, direction);
  ray.shear = vec3(exchanged.xy / exchanged.z, 1.0 / exchanged.z);
  return ray;
}

// Whether the ray can be traced: finite, with a direction.
bool traversal_is_valid(vec3 origin, vec3 direction) {
  return all(lessThanEqual(abs(origin), vec3(TRAVERSAL_FLOAT_MAX))) &&
         all(lessThanEqual(abs(direction), vec3(TRAVERSAL_FLOAT_MAX))) &&
         any(greaterThan(abs(direction), vec3(TRAVERSAL_MIN_DIRECTION)));
}

// Index of the lowest set bit of a value below 2^24, through the exponent of a float: vector units of CPUs
// lack bit counts.
uint traversal_lowest_bit(uint isolated_bit) {
  return (floatBitsToUint(float(int(isolated_bit))) >> 23) - 127u;
}

// Plane of slot `slot` from the eight bytes of one side of an axis.
float traversal_plane(uvec2 planes, uint slot) {
  uint word = slot < 4u ? planes.x : planes.y;
  return float(int((word >> (8u * (slot & 3u))) & 0xFFu));
}

// Key of a child: distance with the slot in the lowest three bits. Positive floats sort like their bits.
const uint TRAVERSAL_KEY_SLOT = 7u;
const float TRAVERSAL_MIN_DISTANCE = 1e-37;

uint traversal_key(TraversalRay ray, float t_near, float t_far, uint slot) {
  uint distance = ray.is_far_first ? ~floatBitsToUint(t_far) & 0x7FFFFFFFu : floatBitsToUint(t_near);
  return (distance & ~TRAVERSAL_KEY_SLOT) | slot;
}

float traversal_key_distance(uint key) { return uintBitsToFloat(key & ~TRAVERSAL_KEY_SLOT); }

// The children of a node that a ray meets: bits as in TraversalGroup, the key of the child to visit first,
// and the least key of the others.
struct TraversalVisit {
  uint mask;
  uint first;
  uint rest;
};

// Sets what concerns the triangles of an instance.
void traversal_place_triangles(Instance instance, inout TraversalRay ray) {
  ray.number_offset = instance.first_number - instance.first_triangle;
  ray.is_mirrored = instance.is_mirrored != 0u;
  ray.x_axis = instance.x_axis;
  ray.y_axis = instance.y_axis;
  ray.z_axis = instance.z_axis;
  ray.translation = instance.translation;
}

// Sets the ray up for an instance's tree above the given height of the stack and returns the tree's root.
uint traversal_enter(Instance instance, vec3 origin, vec3 direction, uint stack_size, inout TraversalRay ray) {
  vec3 from = origin - instance.translation;
  vec3 size = abs(from) + instance.reach;
  traversal_set_boxes(
      vec3(dot(instance.inverse_x, from), dot(instance.inverse_y, from), dot(instance.inverse_z, from)),
      vec3(dot(instance.inverse_x, direction), dot(instance.inverse_y, direction), dot(instance.inverse_z, direction)), ray);
  vec3 error = vec3(dot(abs(instance.inverse_x), size), dot(abs(instance.inverse_y), size),
                    dot(abs(instance.inverse_z), size));
  ray.slack = (TRAVERSAL_INSTANCE_ERROR * error) * abs(ray.inverse_direction);
  ray.instance_floor = stack_size;
  traversal_place_triangles(instance, ray);
  return instance.root;
}

// Tests the eight children of a node against [0, t_max].
TraversalVisit traversal_visit(DeviceAddress nodes, uint index, TraversalRay ray, float t_max) {
#define NODE_PAIR(i) TRAVERSAL_UNPACK(TraversalNodes(nodes).nodes[index].pairs[i])
  uvec2 head_xy = NODE_PAIR(0);
  uvec2 head_z = NODE_PAIR(1);
  vec3 offset = uintBitsToFloat(uvec3(head_xy, head_z.x)) - ray.box_origin;
  uint exponents = head_z.y;
  vec3 quantum = uintBitsToFloat(uvec3(exponents << 23, exponents << 15, exponents << 7) & 0x7F800000u);
  vec3 near_scale = quantum * ray.inverse_direction;
  vec3 near_offset = offset * ray.inverse_direction;
  vec3 far_scale = quantum * ray.inverse_direction_far;
  vec3 far_offset = offset * ray.inverse_direction_far;
  // With this slack an empty slot, whose planes are the wrong way round, could be hit.
  uint occupied = 0xFFu;
  if (TRAVERSAL_HAS_INSTANCES) {
    near_offset -= ray.slack;
    far_offset += ray.slack * TRAVERSAL_FAR_SCALE;
    occupied = exponents >> 24;
  }
  if (TRAVERSAL_HAS_CONTACTS) {
    far_offset += TRAVERSAL_CONTACT_REACH(0.0);  // so that what lies just behind the origin counts
    occupied = exponents >> 24;
  }

  uvec2 lower_x = NODE_PAIR(2), upper_x = NODE_PAIR(3);
  uvec2 lower_y = NODE_PAIR(4), upper_y = NODE_PAIR(5);
  uvec2 lower_z = NODE_PAIR(6), upper_z = NODE_PAIR(7);
#undef NODE_PAIR
  bvec3 is_negative = lessThan(ray.inverse_direction, vec3(0.0));
  uvec2 near_x = is_negative.x ? upper_x : lower_x, far_x = is_negative.x ? lower_x : upper_x;
  uvec2 near_y = is_negative.y ? upper_y : lower_y, far_y = is_negative.y ? lower_y : upper_y;
  uvec2 near_z = is_negative.z ? upper_z : lower_z, far_z = is_negative.z ? lower_z : upper_z;

  uint mask = 0u;
  uint keys[8];
#define TEST_SLOT(slot)                                                                                     \
  {                                                                                                         \
    float t_near = max(max(traversal_plane(near_x, slot) * near_scale.x + near_offset.x,                    \
                           traversal_plane(near_y, slot) * near_scale.y + near_offset.y),                   \
                       max(traversal_plane(near_z, slot) * near_scale.z + near_offset.z,                    \
                           TRAVERSAL_MIN_DISTANCE));                                                        \
    float t_far = min(min(traversal_plane(far_x, slot) * far_scale.x + far_offset.x,                        \
                          traversal_plane(far_y, slot) * far_scale.y + far_offset.y),                       \
                      min(traversal_plane(far_z, slot) * far_scale.z + far_offset.z, t_max));               \
    bool is_met = t_near <= t_far &&                                                                        \
                  (!(TRAVERSAL_HAS_INSTANCES || TRAVERSAL_HAS_CONTACTS) || (occupied & (1u << slot)) != 0u);\
    keys[slot] = is_met ? traversal_key(ray, t_near, t_far, slot) : TRAVERSAL_DONE;                         \
    mask |= is_met ? 1u << (slot ^ ray.order) : 0u;                                                         \
  }
  TEST_SLOT(0u)
  TEST_SLOT(1u)
  TEST_SLOT(2u)
  TEST_SLOT(3u)
  TEST_SLOT(4u)
  TEST_SLOT(5u)
  TEST_SLOT(6u)
  TEST_SLOT(7u)
#undef TEST_SLOT
  uint first = min(min(min(keys[0], keys[1]), min(keys[2], keys[3])),
                   min(min(keys[4], keys[5]), min(keys[6], keys[7])));
#define REST(slot) (keys[slot] == first ? TRAVERSAL_DONE : keys[slot])
  uint rest = min(min(min(REST(0), REST(1)), min(REST(2), REST(3))),
                  min(min(REST(4), REST(5)), min(REST(6), REST(7))));
#undef REST
  return TraversalVisit(mask, first, rest);
}

// Vertex sheared into the ray's frame, and the edge function of two such vertices. `precise`, because contraction to
// fused multiply-add would break their symmetry. (Functions of their own: the front end takes
// exponential time to propagate `precise` through structs.)
vec2 traversal_shear(vec3 v, vec3 shear) {
  precise vec2 sheared = v.xy - shear.xy * v.z;
  return sheared;
}

float traversal_edge(vec2 p, vec2 q) {
  precise float edge = p.x * q.y - p.y * q.x;
  return edge;
}

// Tests a triangle for a hit with t in (t_min, t_max]. Edges are inclusive and both faces count. Barycentrics are
// of p1 and p2. The sign of each edge function is that of the exact function of the sheared vertices or zero
// (products round monotonically), and those are the same for all triangles that share a vertex: no gap.
// normal: not of unit length, of the front; only with TRAVERSAL_HAS_CONTACTS.
bool traversal_intersect(DeviceAddress triangles, uint index, TraversalRay ray, float t_min, float t_max, out vec3 tuv,
                         out uint tag, out vec3 normal) {
#define TRIANGLE_PAIR(i) TRAVERSAL_UNPACK(TraversalTriangles(triangles).triangles[index].pairs[i])
  uvec2 w0 = TRIANGLE_PAIR(0), w1 = TRIANGLE_PAIR(1), w2 = TRIANGLE_PAIR(2);
  uvec2 w3 = TRIANGLE_PAIR(3), w4 = TRIANGLE_PAIR(4);
#undef TRIANGLE_PAIR
  vec3 v0 = uintBitsToFloat(uvec3(w0, w1.x));
  vec3 v1 = uintBitsToFloat(uvec3(w1.y, w2));
  vec3 v2 = uintBitsToFloat(uvec3(w3, w4.x));
  if (TRAVERSAL_HAS_INSTANCES) {
    // In the world this changes nothing, because products with 1 and 0 and their sums are exact.
    vec3 second = ray.is_mirrored ? v2 : v1, third = ray.is_mirrored ? v1 : v2;
    v0 = placed_position(ray.x_axis, ray.y_axis, ray.z_axis, ray.translation, v0);
    v1 = placed_position(ray.x_axis, ray.y_axis, ray.z_axis, ray.translation, second);
    v2 = placed_position(ray.x_axis, ray.y_axis, ray.z_axis, ray.translation, third);
  }
  normal = TRAVERSAL_HAS_CONTACTS ? cross(v1 - v0, v2 - v0) : vec3(0.0);
  vec3 a = traversal_exchange(ray, v0 - ray.origin);
  vec3 b = traversal_exchange(ray, v1 - ray.origin);
  vec3 c = traversal_exchange(ray, v2 - ray.origin);
  tag = w4.y;

  vec2 a_sheared = traversal_shear(a, ray.shear);
  vec2 b_sheared = traversal_shear(b, ray.shear);
  vec2 c_sheared = traversal_shear(c, ray.shear);
  float edge_a = traversal_edge(c_sheared, b_sheared);
  float edge_b = traversal_edge(a_sheared, c_sheared);
  float edge_c = traversal_edge(b_sheared, a_sheared);
  float determinant = edge_a + edge_b + edge_c;
  float inverse = 1.0 / determinant;
  tuv = vec3((edge_a * a.z + edge_b * b.z + edge_c * c.z) * ray.shear.z, edge_b, edge_c) * inverse;

  bool is_inside = min(min(edge_a, edge_b), edge_c) >= 0.0 || max(max(edge_a, edge_b), edge_c) <= 0.0;
  return is_inside && determinant != 0.0 && tuv.x > t_min && tuv.x <= t_max;
}

// The same t, but by the triangle's plane: from barycentrics it errs more, and surfaces in one plane should have one distance.
// `t` itself where the ray is parallel to the plane.
float traversal_plane_distance(DeviceAddress triangles, uint index, TraversalRay ray, vec3 normal, vec3 origin, vec3 direction,
                               float t) {
  uvec2 w0 = TRAVERSAL_UNPACK(TraversalTriangles(triangles).triangles[index].pairs[0]);
  uvec2 w1 = TRAVERSAL_UNPACK(TraversalTriangles(triangles).triangles[index].pairs[1]);
  vec3 v0 = uintBitsToFloat(uvec3(w0, w1.x));
  if (TRAVERSAL_HAS_INSTANCES) v0 = placed_position(ray.x_axis, ray.y_axis, ray.z_axis, ray.translation, v0);
  float slope = dot(normal, direction);
  return abs(slope) > 0.0 ? dot(normal, v0 - origin) / slope : t;
}

// Among contacts: gives a hit the distance of the triangle's plane, says in the tag which face was met, and returns the key
// (TRAVERSAL_CONTACT_KEY) and order by which it comes before others.
vec2 traversal_rank(DeviceAddress triangles, uint index, TraversalRay ray, vec3 normal, vec3 origin, vec3 direction,
                    inout float t, inout uint tag, out uint order) {
  t = traversal_plane_distance(triangles, index, ray, normal, origin, direction, t);
  float cosine = dot(normal, direction) * inversesqrt(max(dot(normal, normal), 1e-37));
  vec2 key = TRAVERSAL_CONTACT_KEY(tag, index + ray.number_offset, t, cosine);
  if (cosine < 0.0) tag |= TRIANGLE_TAG_FRONT;
  order = TRAVERSAL_CONTACT_ORDER(tag, index + ray.number_offset, cosine);
  return key;
}

// Whether a hit of that rank counts and comes before the best so far.
bool traversal_is_first(vec2 key, uint order, float best, uint best_order) {
  return key.x < TRAVERSAL_NEVER && (key.x < best - key.y || (key.x <= best + key.y && order < best_order));
}

#define TRAVERSAL_STACK(level) traversal_stack[(level) * WORKGROUP_SIZE + gl_LocalInvocationIndex]

uint traversal_child(DeviceAddress nodes, uint node, uint slot) {
  return TraversalNodeRecords(nodes).nodes[node].children[slot];
}

// Takes the next child off the group, or off the topmost group of the stack whose children are not all beyond
// t_max. Returns its reference or TRAVERSAL_DONE; in an instance, if there is none above its floor, TRAVERSAL_LEAVE.
uint traversal_next(DeviceAddress nodes, TraversalRay ray, float t_max, const bool any_hit,
                    inout TraversalGroup group, inout uint stack_size) {
  // The far-first order of any-hit rays has no distances in its keys, and their t_max never shrinks.
  if (!any_hit && traversal_key_distance(group.rest) > t_max) group.node_and_mask = 0u;
  uint least_size = TRAVERSAL_HAS_INSTANCES && ray.instance_floor != TRAVERSAL_NO_FLOOR ? ray.instance_floor : 0u;
  while ((group.node_and_mask & 0xFFu) == 0u && stack_size > least_size) {
    --stack_size;
    uvec2 top = TRAVERSAL_UNPACK(TRAVERSAL_STACK(stack_size));
    group = TraversalGroup(top.x, top.y);
    if (!any_hit && traversal_key_distance(group.rest) > t_max) group.node_and_mask = 0u;
  }
  uint children = group.node_and_mask & 0xFFu;
  if (children == 0u)
    return TRAVERSAL_HAS_INSTANCES && ray.instance_floor != TRAVERSAL_NO_FLOOR ? TRAVERSAL_LEAVE : TRAVERSAL_DONE;
  uint nearest = 1u << ((group.rest & TRAVERSAL_KEY_SLOT) ^ ray.order);
  uint bit = (children & nearest) != 0u ? nearest : children & (0u - children);
  group.node_and_mask ^= bit;
  return traversal_child(nodes, group.node_and_mask >> 8, traversal_lowest_bit(bit) ^ ray.order);
}

// After a visit: the reference of the child to go on with; its siblings become the group, and the group
// before them goes to the stack.
uint traversal_descend(DeviceAddress nodes, uint node, TraversalVisit visit, TraversalRay ray, float t_max,
                       const bool any_hit, inout TraversalGroup group, inout uint stack_size) {
  if (visit.mask == 0u) return traversal_next(nodes, ray, t_max, any_hit, group, stack_size);
  uint slot = visit.first & TRAVERSAL_KEY_SLOT;
  uint siblings = visit.mask ^ (1u << (slot ^ ray.order));
  if (siblings != 0u) {
    if ((group.node_and_mask & 0xFFu) != 0u) {
      TRAVERSAL_STACK(stack_size) = TRAVERSAL_PACK(uvec2(group.node_and_mask, group.rest));
      ++stack_size;
    }
    group = TraversalGroup(node << 8 | siblings, visit.rest);
  }
  return traversal_child(nodes, node, slot);
}

// Goes on where the ray enters an instance (reference `next`) or has left one (TRAVERSAL_LEAVE); returns the next reference.
uint traversal_change_space(DeviceAddress nodes, uint next, vec3 origin, vec3 direction, float t_max, const bool any_hit,
                            inout TraversalRay ray, inout TraversalGroup group, inout uint stack_size) {
  if (next == TRAVERSAL_LEAVE) {
    traversal_set_world(origin, direction, ray);
    return traversal_next(nodes, ray, t_max, any_hit, group, stack_size);
  }
  if ((group.node_and_mask & 0xFFu) != 0u) {
    TRAVERSAL_STACK(stack_size) = TRAVERSAL_PACK(uvec2(group.node_and_mask, group.rest));
    ++stack_size;
  }
  group = TraversalGroup(0u, 0u);
  Instance instance = TRAVERSAL_INSTANCE(next ^ BVH_INSTANCE_BIT);
  return traversal_enter(instance, origin, direction, stack_size, ray);
}

// The traversal that both queries share. With `any_hit` it ends at the first hit found.
Hit traversal_run(DeviceAddress nodes, DeviceAddress triangles, vec3 origin, vec3 direction, float t_max,
                  const bool any_hit, out uint tag) {
  Hit hit = Hit(t_max, 0.0, 0.0, INVALID_INDEX);
  tag = 0u;
  // A ray without an end most likely ends at what encloses the scene: large and far.
  bool is_far_first = any_hit && t_max >= TRAVERSAL_UNBOUNDED;
  TraversalRay ray = traversal_ray(origin, direction, is_far_first);
  float limit = traversal_is_valid(origin, direction) ? t_max * TRAVERSAL_FAR_SCALE : -1.0;
  TraversalGroup group = TraversalGroup(0u, 0u);
  uint stack_size = 0u;
  uint steps = 0u;
  float best = TRAVERSAL_NEVER;  // with contacts: key and order of the hit found so far
  uint best_order = 0xFFFFFFFFu;
  TraversalVisit root = traversal_visit(nodes, 0u, ray, limit);
  uint next = traversal_descend(nodes, 0u, root, ray, limit, any_hit, group, stack_size);
  while (next != TRAVERSAL_DONE) {
    while (next < (TRAVERSAL_HAS_INSTANCES ? BVH_INSTANCE_BIT : BVH_LEAF_BIT)) {
      TraversalVisit visit = traversal_visit(nodes, next, ray, limit);
      next = traversal_descend(nodes, next, visit, ray, limit, any_hit, group, stack_size);
      ++steps;
      if (steps >= TRAVERSAL_MAX_STEPS) break;
    }
    if (TRAVERSAL_HAS_INSTANCES && next >= BVH_INSTANCE_BIT && next < BVH_LEAF_BIT) {
      next = traversal_change_space(nodes, next, origin, direction, limit, any_hit, ray, group, stack_size);
      ++steps;
    }
    if (next != TRAVERSAL_DONE && next >= BVH_LEAF_BIT) {
      uint first = next & BVH_LEAF_FIRST_MASK;
      uint end = first + ((next & ~BVH_LEAF_BIT) >> BVH_LEAF_COUNT_SHIFT) + 1u;
      for (uint i = first; i < end; ++i) {
        vec3 tuv, normal;
        uint hit_tag;
        float t_min = TRAVERSAL_HAS_CONTACTS ? -TRAVERSAL_FLOAT_MAX : 0.0;
        float t_limit = TRAVERSAL_HAS_CONTACTS ? limit : hit.t;
        bool is_met = traversal_intersect(triangles, i, ray, t_min, t_limit, tuv, hit_tag, normal);
        vec2 key = vec2(tuv.x, 0.0);
        uint order = 0u;
        if (TRAVERSAL_HAS_CONTACTS) {
          key = traversal_rank(triangles, i, ray, normal, origin, direction, tuv.x, hit_tag, order);
          is_met = is_met && traversal_is_first(key, order, best, best_order);
        }
        if (is_met && TRAVERSAL_IS_COVERED(hit_tag, i + ray.number_offset, tuv.yz, origin, direction)) {
          hit = Hit(tuv.x, tuv.y, tuv.z, i + ray.number_offset);
          tag = hit_tag;
          best = key.x;
          best_order = order;
          if (any_hit) i = end;
        }
        ++steps;
      }
      limit = hit.t * TRAVERSAL_FAR_SCALE;
      if (TRAVERSAL_HAS_CONTACTS) limit = (max(hit.t, 0.0) + TRAVERSAL_CONTACT_REACH(hit.t)) * TRAVERSAL_FAR_SCALE;
      bool is_done = any_hit && hit.triangle != INVALID_INDEX;
      next = is_done ? TRAVERSAL_DONE : traversal_next(nodes, ray, limit, any_hit, group, stack_size);
    }
    if (steps >= TRAVERSAL_MAX_STEPS && next != TRAVERSAL_DONE) {
      traversal_overrun = 1u;
      next = TRAVERSAL_DONE;
    } else if (TRAVERSAL_HAS_CONTACTS && next == TRAVERSAL_DONE && TRAVERSAL_CONTACT_GOES_ON(hit, tag)) {
      // Starts from the root once more within this loop, because SwiftShader takes minutes to compile a loop around it.
      hit = Hit(t_max, 0.0, 0.0, INVALID_INDEX);
      tag = 0u;
      best = TRAVERSAL_NEVER;
      best_order = 0xFFFFFFFFu;
      limit = t_max * TRAVERSAL_FAR_SCALE;
      next = 0u;
    }
  }
  return hit;
}

#ifdef REGULUS_RAY_QUERY
// The device's own queries take the place of the traversal above, and their structure that of the nodes.
#include "lib/hardware_query.glsl"
#define TRAVERSAL_RUN hardware_run
#else
#define TRAVERSAL_RUN traversal_run
#endif

// The first hit with t in (0, t_max] along origin + t * direction, its triangle's number and tag. On a miss the
// triangle is INVALID_INDEX. A ray that is not finite or has no direction misses.
Hit trace_closest(DeviceAddress nodes, DeviceAddress triangles, vec3 origin, vec3 direction, float t_max,
                  out uint tag) {
  return TRAVERSAL_RUN(nodes, triangles, origin, direction, t_max, false, tag);
}

// Whether anything is hit with t in (0, t_max].
bool trace_any(DeviceAddress nodes, DeviceAddress triangles, vec3 origin, vec3 direction, float t_max) {
  uint tag;
  return TRAVERSAL_RUN(nodes, triangles, origin, direction, t_max, true, tag).triangle != INVALID_INDEX;
}

#endif
