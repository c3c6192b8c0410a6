#include "reference/traversal.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>
#include <vector>

#include "reference/rng.hpp"
#include "scene/placement.hpp"
#include "scene/texture.hpp"

namespace regulus::reference {

using glm::dvec3;
using namespace interface;

namespace {

constexpr uint32_t CHILDREN = 8;
// Slack of the slab test, relative: boxes have a margin of their own, so only rounding has to be covered.
constexpr double SLAB_SLACK = 1e-14;

struct Box {
  dvec3 lower, upper;
};

double plane(const BvhNode& node, uint32_t axis, bool is_upper, uint32_t slot) {
  const uint32_t word = node.planes[4 * axis + (is_upper ? 2 : 0) + slot / 4];
  const uint32_t q = word >> (8 * (slot % 4)) & 0xFFu;
  const int exponent = static_cast<int>(node.exponents >> (8 * axis) & 0xFFu) - 127;
  return node.origin[static_cast<int>(axis)] + std::ldexp(static_cast<double>(q), exponent);
}

/// Box of a child, or nothing for an empty slot (whose planes are inverted).
std::optional<Box> child_box(const BvhNode& node, uint32_t slot) {
  Box box{};
  for (uint32_t axis = 0; axis < 3; ++axis) {
    box.lower[static_cast<int>(axis)] = plane(node, axis, false, slot);
    box.upper[static_cast<int>(axis)] = plane(node, axis, true, slot);
  }
  if (box.lower.x > box.upper.x || box.lower.y > box.upper.y || box.lower.z > box.upper.z)
    return std::nullopt;
  return box;
}

bool meets(const Ray& ray, const Box& box) {
  double near = ray.t_min;
  double far = ray.t_max;
  for (int axis = 0; axis < 3; ++axis) {
    if (ray.direction[axis] == 0) {
      if (ray.origin[axis] < box.lower[axis] || ray.origin[axis] > box.upper[axis]) return false;
      continue;
    }
    double a = (box.lower[axis] - ray.origin[axis]) / ray.direction[axis];
    double b = (box.upper[axis] - ray.origin[axis]) / ray.direction[axis];
    if (a > b) std::swap(a, b);
    near = std::max(near, a - SLAB_SLACK * std::abs(a));
    far = std::min(far, b + SLAB_SLACK * std::abs(b));
  }
  return near <= far;
}

/// The ray in the space of a copy's mesh, at the same t, and how far off its vertices may be there: they are
/// rounded on their way to the world, which is where triangles are met.
struct LocalRay {
  Ray ray;
  dvec3 slack{0};
};

LocalRay local_ray(const Ray& ray, const Instance* copy) {
  if (copy == nullptr) return {ray};
  constexpr double PLACING_ERROR = 1e-6;  // of the reach: some roundings of single precision
  const glm::dmat3 inverse =
      glm::inverse(glm::dmat3(dvec3(copy->x_axis), dvec3(copy->y_axis), dvec3(copy->z_axis)));
  LocalRay local{ray};
  local.ray.origin = inverse * (ray.origin - dvec3(copy->translation));
  local.ray.direction = inverse * ray.direction;
  for (int column = 0; column < 3; ++column)
    local.slack += PLACING_ERROR * static_cast<double>(copy->reach[column]) * glm::abs(inverse[column]);
  return local;
}

// See shaders/lib/contacts.glsl, where the same numbers are.
constexpr double CONTACT_MIN_COS = 1.0 / 16;
constexpr double CONTACT_EMITTER = 2, CONTACT_FRONT = 1.5, CONTACT_BACK = 1, CONTACT_ENTRY = 0.5;
constexpr double CONTACT_TIE = 0.2;
constexpr double CONTACT_BEHIND = 1;
constexpr double CONTACT_REACH = CONTACT_EMITTER + CONTACT_TIE;

double contact_error(const Ray& ray, double t) {
  const dvec3 size = glm::abs(ray.origin);
  return CONTACT_ROUNDINGS * 0x1p-24 * (std::max({size.x, size.y, size.z}) + std::abs(t));
}

double contact_reach(const Ray& ray, double t) {
  return CONTACT_REACH / CONTACT_MIN_COS * contact_error(ray, t);
}

/// What hits are ordered by, and how near two must be for `order` to decide. Infinite: not met.
struct ContactKey {
  double value = std::numeric_limits<double>::infinity();
  double tie = 0;
  uint32_t order = INVALID_INDEX;  ///< what then decides
};

/// A surface that is no boundary of a closed solid.
ContactKey plain_key(const Ray& ray, uint32_t tag, uint32_t number, double t, bool is_front, double along) {
  const Contact& contact = *ray.contact;
  const bool is_open = tag >> TRIANGLE_TAG_SOLID_SHIFT != 0;
  if (contact.is_blind || number == contact.triangle || !(t > 0) || t > contact.end) return {};
  if (!(t > contact.from - (is_open ? 0 : CONTACT_BEHIND * along))) return {};
  const bool emits = (tag & (is_front ? TRIANGLE_TAG_EMITS : TRIANGLE_TAG_EMITS_BACK)) != 0;
  const double rank = emits ? CONTACT_EMITTER : is_front ? CONTACT_FRONT : CONTACT_BACK;
  return {t - rank * along, CONTACT_TIE * along, number};
}

ContactKey contact_key(const Ray& ray, uint32_t tag, uint32_t number, double t, double cosine) {
  const Contact& contact = *ray.contact;
  const double along = contact_error(ray, t) / std::max(std::abs(cosine), CONTACT_MIN_COS);
  if ((tag & TRIANGLE_TAG_CLOSED) == 0) return plain_key(ray, tag, number, t, cosine < 0, along);
  const uint32_t solid = (tag >> TRIANGLE_TAG_SOLID_SHIFT) - 1;
  const bool is_entry = cosine < 0;
  const bool is_inside = contact.around.contain(solid);
  const double behind = CONTACT_BEHIND * along;
  if (contact.is_blind) {
    const bool counts = is_entry ? !is_inside : is_inside || !contact.holding.contain(solid);
    if (solid == contact.crossed && t < contact.from + behind) return {};
    // One after the other, as they lie: what was left must not count again as left without having been
    // entered.
    const uint32_t last = contact.around.contain(contact.crossed) ? contact.crossed : ~contact.crossed;
    const uint32_t order = is_entry ? solid : ~solid;
    const bool is_ahead = t > contact.from || (t == contact.from && order > last);
    if (!counts || !is_ahead || !(t > 0)) return {};
    return {t, 0, order};
  }
  if (is_inside == is_entry) return {};
  if (is_entry && solid == contact.left && t < behind) return {};
  if (is_entry && solid == contact.crossed && t < contact.from + behind) return {};
  if (!(t > contact.from - behind && t <= contact.end - CONTACT_FRONT * along)) return {};
  return {is_entry ? t - CONTACT_ENTRY * along : t, CONTACT_TIE * along, is_entry ? solid : ~solid};
}

}  // namespace

std::optional<Intersection> intersect(const Ray& ray, const dvec3 (&vertices)[3]) {
  // Shear so that the ray runs along its largest component.
  const dvec3 size = glm::abs(ray.direction);
  const int z = size.x > size.y && size.x > size.z ? 0 : size.y > size.z ? 1 : 2;
  const int x = (z + 1) % 3;
  const int y = (z + 2) % 3;
  const dvec3 shear(ray.direction[x] / ray.direction[z], ray.direction[y] / ray.direction[z],
                    1 / ray.direction[z]);
  dvec3 p[3];  // sheared x and y, plain z
  for (int i = 0; i < 3; ++i) {
    const dvec3 v = vertices[i] - ray.origin;
    p[i] = dvec3(v[x] - shear.x * v[z], v[y] - shear.y * v[z], v[z]);
  }
  const auto edge = [&](int a, int b) { return p[a].x * p[b].y - p[a].y * p[b].x; };
  const double e0 = edge(2, 1);
  const double e1 = edge(0, 2);
  const double e2 = edge(1, 0);
  if (std::min({e0, e1, e2}) < 0 && std::max({e0, e1, e2}) > 0) return std::nullopt;
  const double determinant = e0 + e1 + e2;
  if (determinant == 0) return std::nullopt;
  const double t = (e0 * p[0].z + e1 * p[1].z + e2 * p[2].z) * shear.z / determinant;
  if (!(t > ray.t_min && t < ray.t_max)) return std::nullopt;
  return Intersection{t, {e1 / determinant, e2 / determinant}, INVALID_INDEX};
}

double coverage_at(const scene::Scene& scene, uint32_t index, const glm::dvec2& barycentrics) {
  const Triangle triangle = scene::placed_triangle(scene, index).triangle;
  const Material& material = scene.materials[triangle.material];
  if ((material.flags & (MATERIAL_ALPHA_MASK | MATERIAL_ALPHA_BLEND)) == 0) return 1;
  const uint32_t corners[3] = {triangle.v0, triangle.v1, triangle.v2};
  const double weights[3] = {1 - barycentrics.x - barycentrics.y, barycentrics.x, barycentrics.y};
  double of_vertices = scene.vertex_colors.empty() ? 1 : 0;
  for (int i = 0; i < 3; ++i)
    if (!scene.vertex_colors.empty())
      of_vertices += weights[i] * static_cast<double>(scene.vertex_colors[corners[i]].a);
  double alpha = material.alpha * of_vertices;
  if (material.alpha_texture != INVALID_INDEX)
    alpha *=
        static_cast<double>(scene::sample_texture(scene, scene.textures[material.alpha_texture],
                                                  scene::texture_coordinates(
                                                      scene, triangle, {weights[0], weights[1], weights[2]}))
                                .a);
  if ((material.flags & MATERIAL_ALPHA_MASK) != 0) return alpha >= material.alpha_cutoff ? 1 : 0;
  return alpha;
}

bool is_covered(const scene::Scene& scene, uint32_t triangle, const glm::dvec2& barycentrics,
                const glm::vec3& origin, const glm::vec3& direction) {
  const double coverage = coverage_at(scene, triangle, barycentrics);
  if (coverage >= 1) return true;
  const auto bits_of = [](float value) { return std::bit_cast<uint32_t>(value); };
  // hash_bits takes its stream first: PCG4D of (origin, direction.x), then of that and the rest.
  const RandomBits first =
      hash_bits(bits_of(direction.x), bits_of(origin.x), bits_of(origin.y), bits_of(origin.z));
  const RandomBits bits = hash_bits(first[3], first[0] ^ bits_of(direction.y),
                                    first[1] ^ bits_of(direction.z), first[2] ^ triangle);
  return unit_interval(bits[0]) < coverage;
}

bool Traversal::is_covered(const Ray& ray, const Intersection& hit) const {
  if (scene_ == nullptr) return true;
  const glm::vec3 origin = ray.decision ? (*ray.decision)[0] : glm::vec3(ray.origin);
  const glm::vec3 direction = ray.decision ? (*ray.decision)[1] : glm::vec3(ray.direction);
  return reference::is_covered(*scene_, hit.triangle, hit.barycentrics, origin, direction);
}

void Traversal::take_contact(uint32_t tag, Intersection hit, const dvec3& normal, Search& search) const {
  const double cosine = dot(normal, search.ray.direction) / length(normal);
  const ContactKey key = contact_key(search.ray, tag, hit.triangle, hit.t, cosine);
  const bool is_first = key.value < search.key - key.tie ||
                        (key.value <= search.key + key.tie && search.nearest && key.order < search.order);
  if (!std::isfinite(key.value) || !is_first) return;
  if ((tag & TRIANGLE_TAG_ALPHA) != 0 && !is_covered(search.ray, hit)) return;
  hit.is_front = cosine < 0;
  search.key = key.value;
  search.order = key.order;
  search.nearest = hit;
  search.ray.t_max = std::max(hit.t, 0.0) + contact_reach(search.ray, hit.t);
}

void Traversal::intersect_leaf(const Visit& visit, Search& search) const {
  Ray& ray = search.ray;
  const uint32_t first = visit.reference & BVH_LEAF_FIRST_MASK;
  const uint32_t count = ((visit.reference & ~BVH_LEAF_BIT) >> BVH_LEAF_COUNT_SHIFT) + 1;
  const Instance* copy = visit.copy;
  for (uint32_t i = first; i < first + count; ++i) {
    const uint32_t number = copy != nullptr ? i - copy->first_triangle + copy->first_number : i;
    if (number == ray.skip_first || number == ray.skip_last) continue;
    const BvhTriangle& triangle = tree_.triangles[i];
    glm::vec3 p[3] = {triangle.v0, triangle.v1, triangle.v2};
    if (copy != nullptr) {
      for (glm::vec3& vertex : p) vertex = scene::placed_position(*copy, vertex);
      if (copy->is_mirrored != 0) std::swap(p[1], p[2]);
    }
    auto hit = intersect(ray, {dvec3(p[0]), dvec3(p[1]), dvec3(p[2])});
    if (!hit) continue;
    hit->triangle = number;
    if (ray.contact != nullptr) {
      take_contact(triangle.tag, *hit, cross(dvec3(p[1]) - dvec3(p[0]), dvec3(p[2]) - dvec3(p[0])), search);
      continue;
    }
    if ((triangle.tag & TRIANGLE_TAG_ALPHA) != 0 && !is_covered(ray, *hit)) continue;
    ray.t_max = hit->t;
    search.nearest = hit;
  }
}

std::optional<Intersection> Traversal::run(const Ray& given, bool any_hit) const {
  Search search{given};
  if (given.contact != nullptr) {
    search.ray.t_min = -contact_reach(given, 0);
    search.ray.t_max = given.contact->end + contact_reach(given, 0);
  }
  std::vector<Visit> stack{{0, nullptr}};
  while (!stack.empty() && !(any_hit && search.nearest)) {
    const Visit visit = stack.back();
    stack.pop_back();
    if ((visit.reference & BVH_LEAF_BIT) != 0) {
      intersect_leaf(visit, search);
      continue;
    }
    if ((visit.reference & BVH_INSTANCE_BIT) != 0) {
      const Instance& copy = scene_->instances[visit.reference ^ BVH_INSTANCE_BIT];
      stack.push_back({copy.root, &copy});
      continue;
    }
    const BvhNode& node = tree_.nodes[visit.reference];
    const LocalRay local = local_ray(search.ray, visit.copy);
    for (uint32_t slot = 0; slot < CHILDREN; ++slot) {
      std::optional<Box> box = child_box(node, slot);
      if (!box) continue;
      box->lower -= local.slack;
      box->upper += local.slack;
      if (meets(local.ray, *box)) stack.push_back({node.children[slot], visit.copy});
    }
  }
  return search.nearest;
}

std::optional<Intersection> Traversal::closest(const Ray& ray) const {
  return run(ray, false);
}

bool Traversal::is_occluded(const Ray& ray) const {
  return run(ray, true).has_value();
}

}  // namespace regulus::reference
