#include "rays/triangle_test.hpp"

#include <algorithm>
#include <cmath>

namespace regulus::rays {

namespace {

glm::vec2 sheared(const glm::vec3& v, const glm::vec3& shear) {
  return {v.x - shear.x * v.z, v.y - shear.y * v.z};
}

float edge(const glm::vec2& p, const glm::vec2& q) {
  return p.x * q.y - p.y * q.x;
}

}  // namespace

TriangleTest::TriangleTest(const glm::vec3& origin, const glm::vec3& direction) : origin_(origin) {
  const glm::vec3 size = glm::abs(direction);
  x_is_longest_ = size.x > size.y && size.x >= size.z;
  y_is_longest_ = !x_is_longest_ && size.y > size.z;
  const glm::vec3 exchanged = exchange(direction);
  shear_ = {exchanged.x / exchanged.z, exchanged.y / exchanged.z, 1 / exchanged.z};
}

glm::vec3 TriangleTest::exchange(const glm::vec3& v) const {
  return {x_is_longest_ ? v.z : v.x, y_is_longest_ ? v.z : v.y,
          x_is_longest_ ? v.x : (y_is_longest_ ? v.y : v.z)};
}

TriangleTest::Result TriangleTest::run(const std::array<glm::vec3, 3>& corners) const {
  const glm::vec3 a = exchange(corners[0] - origin_);
  const glm::vec3 b = exchange(corners[1] - origin_);
  const glm::vec3 c = exchange(corners[2] - origin_);
  const glm::vec2 a_sheared = sheared(a, shear_), b_sheared = sheared(b, shear_),
                  c_sheared = sheared(c, shear_);
  const float edge_a = edge(c_sheared, b_sheared);
  const float edge_b = edge(a_sheared, c_sheared);
  const float edge_c = edge(b_sheared, a_sheared);
  const float determinant = edge_a + edge_b + edge_c;
  const float inverse = 1 / determinant;
  const float t = (edge_a * a.z + edge_b * b.z + edge_c * c.z) * shear_.z;
  const bool is_inside = std::min({edge_a, edge_b, edge_c}) >= 0 || std::max({edge_a, edge_b, edge_c}) <= 0;
  return {glm::vec3(t, edge_b, edge_c) * inverse, is_inside, determinant != 0 && std::isfinite(inverse)};
}

}  // namespace regulus::rays
