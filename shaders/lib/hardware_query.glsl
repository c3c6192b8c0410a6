// The queries of lib/traversal.glsl by the device's own (VK_KHR_ray_query), which includes this file. The device says which
// triangle a ray meets; traversal_intersect says where on it, so t, u and v have the bits of the traversal, and only ties may
// fall to another triangle. Triangles with holes and those of copies, which the device meets in the space of their mesh, are
// put to the kernel one by one: a hit counts if the test in world space finds it in the range of the ray, and the surface is
// there. All others the device takes as they are. Where the test puts such a hit out of the range (the surface that the ray
// starts on, say), the ray is traced once more with every triangle put to the kernel.
#ifndef REGULUS_LIB_HARDWARE_QUERY_GLSL
#define REGULUS_LIB_HARDWARE_QUERY_GLSL

#extension GL_EXT_ray_query : require

// Most passes over the scene of one ray among contacts; the hit found so far is returned, and the ray counted as given up.
const uint HARDWARE_MAX_PASSES = 2048u;

// A triangle that the device has found, as the test sees it.
struct HardwareHit {
  Hit hit;
  uint tag;
  bool is_met;  // in the range of the ray; with contacts: it counts
  vec2 key;     // with contacts: see traversal_rank
  uint order;
};

// copy, geometry, primitive: as the structure calls the triangle.
HardwareHit hardware_hit(DeviceAddress triangles, uint copy, uint geometry, uint primitive, TraversalRay ray, vec3 direction,
                         float t_max) {
  uint index;
  if (TRAVERSAL_HAS_INSTANCES && copy >= HARDWARE_FIRST_COPY) {
    Instance instance = TRAVERSAL_INSTANCE(copy - HARDWARE_FIRST_COPY);
    traversal_place_triangles(instance, ray);
    index = instance.first_triangle + primitive;
  } else {
    index = TRAVERSAL_PLACED_TRIANGLE(geometry, primitive);
  }
  vec3 tuv, normal;
  HardwareHit found;
  bool is_inside = traversal_intersect(triangles, index, ray, -TRAVERSAL_FLOAT_MAX, TRAVERSAL_FLOAT_MAX, tuv, found.tag, normal);
  found.key = vec2(0.0);
  found.order = 0u;
  if (TRAVERSAL_HAS_CONTACTS) {
    bool has_area = abs(tuv.x) <= TRAVERSAL_FLOAT_MAX;
    found.key = traversal_rank(triangles, index, ray, normal, ray.origin, direction, tuv.x, found.tag, found.order);
    found.is_met = has_area && found.key.x < TRAVERSAL_NEVER;
  } else {
    found.is_met = tuv.x > 0.0 && tuv.x <= t_max;
  }
  // What the device lets pass at an edge may lie outside by rounding.
  vec2 barycentrics = tuv.yz;
  if (!is_inside) {
    barycentrics.x = clamp(tuv.y, 0.0, 1.0);
    barycentrics.y = clamp(tuv.z, 0.0, 1.0 - barycentrics.x);
  }
  found.hit = Hit(tuv.x, barycentrics.x, barycentrics.y, index + ray.number_offset);
  return found;
}

#define HARDWARE_HIT(query, is_committed)                                                                                  \
  hardware_hit(triangles, uint(rayQueryGetIntersectionInstanceCustomIndexEXT(query, is_committed)),                        \
               uint(rayQueryGetIntersectionGeometryIndexEXT(query, is_committed)),                                         \
               uint(rayQueryGetIntersectionPrimitiveIndexEXT(query, is_committed)), ray, direction, t_max)
#define HARDWARE_COVERED(met) \
  TRAVERSAL_IS_COVERED(met.tag, met.hit.triangle, vec2(met.hit.u, met.hit.v), ray.origin, direction)
#define HARDWARE_MISSES(query) (rayQueryGetIntersectionTypeEXT(query, true) == gl_RayQueryCommittedIntersectionNoneEXT)

Hit hardware_nearest(DeviceAddress structure, DeviceAddress triangles, TraversalRay ray, vec3 direction, float t_max,
                     const bool any_hit, out uint tag) {
  tag = 0u;
  uint flags = any_hit ? gl_RayFlagsTerminateOnFirstHitEXT : gl_RayFlagsNoneEXT;
  while (true) {
    rayQueryEXT query;
    rayQueryInitializeEXT(query, accelerationStructureEXT(structure), flags, 0xFFu, ray.origin, 0.0, direction, t_max);
    while (rayQueryProceedEXT(query)) {
      HardwareHit met = HARDWARE_HIT(query, false);
      if (met.is_met && HARDWARE_COVERED(met)) rayQueryConfirmIntersectionEXT(query);
    }
    if (HARDWARE_MISSES(query)) break;
    HardwareHit found = HARDWARE_HIT(query, true);
    if (found.is_met || (flags & gl_RayFlagsNoOpaqueEXT) != 0u) {
      tag = found.tag;
      return found.hit;
    }
    flags |= gl_RayFlagsNoOpaqueEXT;
  }
  return Hit(t_max, 0.0, 0.0, INVALID_INDEX);
}

// Among contacts (lib/contacts.glsl). Every triangle is put to the kernel, in two passes: the first finds the nearest that
// counts, the second, which ends as far behind it as a surface may lie that is met before it, the first by rank. The ray of
// the device starts as far before the origin.
Hit hardware_first(DeviceAddress structure, DeviceAddress triangles, TraversalRay ray, vec3 direction, float t_max,
                   out uint tag) {
  float before = TRAVERSAL_CONTACT_REACH(0.0);
  Hit hit = Hit(t_max, 0.0, 0.0, INVALID_INDEX);
  tag = 0u;
  float end = t_max + before;
  bool is_first_pass = true;
  for (uint pass = 0u; true; ++pass) {
    float best = TRAVERSAL_NEVER;
    uint best_order = 0xFFFFFFFFu;
    rayQueryEXT query;
    rayQueryInitializeEXT(query, accelerationStructureEXT(structure), gl_RayFlagsNoOpaqueEXT, 0xFFu,
                          ray.origin - before * direction, 0.0, direction, end);
    while (rayQueryProceedEXT(query)) {
      HardwareHit met = HARDWARE_HIT(query, false);
      if (!met.is_met || !HARDWARE_COVERED(met)) continue;
      if (is_first_pass) {
        rayQueryConfirmIntersectionEXT(query);
      } else if (traversal_is_first(met.key, met.order, best, best_order)) {
        hit = met.hit;
        tag = met.tag;
        best = met.key.x;
        best_order = met.order;
      }
    }
    if (is_first_pass) {
      if (HARDWARE_MISSES(query)) break;
      float nearest = rayQueryGetIntersectionTEXT(query, true);
      end = nearest + before + TRAVERSAL_CONTACT_REACH(nearest);
    } else {
      if (!TRAVERSAL_CONTACT_GOES_ON(hit, tag)) break;
      if (pass >= HARDWARE_MAX_PASSES) {
        traversal_overrun = 1u;
        break;
      }
      hit = Hit(t_max, 0.0, 0.0, INVALID_INDEX);
      tag = 0u;
      end = t_max + before;
    }
    is_first_pass = !is_first_pass;
  }
  return hit;
}

// As traversal_run, in the device's structure.
Hit hardware_run(DeviceAddress structure, DeviceAddress triangles, vec3 origin, vec3 direction, float t_max,
                 const bool any_hit, out uint tag) {
  tag = 0u;
  if (!traversal_is_valid(origin, direction) || !(t_max > 0.0)) return Hit(t_max, 0.0, 0.0, INVALID_INDEX);
  TraversalRay ray = traversal_ray(origin, direction, false);
  if (TRAVERSAL_HAS_CONTACTS) return hardware_first(structure, triangles, ray, direction, t_max, tag);
  return hardware_nearest(structure, triangles, ray, direction, t_max, any_hit, tag);
}

#endif
