// Emitters that lie in one another: each point shines once.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

#include "images/support/gltf_scene.hpp"
#include "images/support/prepared_scene.hpp"

namespace regulus::test {
namespace {

using glm::dmat4;
using glm::dvec3;

/// A square of the plane y = 0, front up.
Polygon square(double x, double z, double size) {
  return quad({x, 0, z}, {0, 0, size}, {size, 0, 0});
}

Polygon faced_down(const Polygon& polygon) {
  return turned({polygon})[0];
}

/// The square around the origin, turned about the vertical axis.
Polygon square_at_angle(double size, double angle) {
  return transformed(glm::rotate(dmat4(1), angle, dvec3(0, 1, 0)), {square(-size / 2, -size / 2, size)})[0];
}

struct Lamp {
  Polygon polygon;
  double radiance = 1;
  bool is_double_sided = false;
};

struct Arrangement {
  const char* name;
  std::vector<Lamp> lamps;
  bool is_cut;
  double power_over_pi;  ///< sum of radiance times area, a double-sided lamp's twice
};

std::vector<Arrangement> arrangements() {
  const double octagon = 2 * (std::numbers::sqrt2 - 1);  // of two unit squares at 45 degrees
  return {
      {"beside each other", {{square(0, 0, 1)}, {square(1, 0, 1)}}, false, 2},
      {"overlapping in part", {{square(0, 0, 1)}, {square(0.5, 0.5, 1), 3}}, true, 1 + 3 * 0.75},
      {"small in large", {{square(0.25, 0.25, 0.5), 5}, {square(0, 0, 1)}}, true, 5 * 0.25 + 0.75},
      {"small behind large", {{square(0, 0, 1)}, {square(0.25, 0.25, 0.5), 5}}, true, 1},
      {"twins", {{square(0, 0, 1)}, {square(0, 0, 1)}}, true, 1},
      {"a star", {{square_at_angle(1, 0)}, {square_at_angle(1, std::numbers::pi / 4)}}, true, 2 - octagon},
      {"three", {{square(0, 0, 1)}, {square(0.5, 0, 1)}, {square(0.25, 0, 1), 7}}, true, 1.5},
      {"facing away", {{square(0, 0, 1)}, {faced_down(square(0, 0, 1))}}, false, 2},
      {"from both sides and from one", {{square(0, 0, 1)}, {square(0.5, 0, 1), 3, true}}, true, 0.5 + 2 * 3},
      {"a hair apart",
       {{square(0, 0, 1)},
        {transformed(glm::translate(dmat4(1), dvec3(0, 2e-7, 0)), {square(0.5, 0, 1)})[0]}},
       true,
       1.5},
      {"a millimetre apart",
       {{square(0, 0, 1)},
        {transformed(glm::translate(dmat4(1), dvec3(0, 1e-3, 0)), {square(0.5, 0, 1)})[0]}},
       false,
       2},
  };
}

double power_over_pi(const scene::Scene& scene) {
  double sum = 0;
  for (const interface::Light& light : scene.lights) {
    const bool is_double_sided =
        (scene.materials[light.material].flags & interface::MATERIAL_DOUBLE_SIDED) != 0;
    sum += double{light.intensity.x} * light.area * (is_double_sided ? 2 : 1);
  }
  return sum;
}

TEST(EmitterOverlap, EachPointShinesOnce) {
  const dmat4 tilt =
      glm::rotate(glm::translate(dmat4(1), dvec3(0.3, -0.7, 0.2)), 0.7, glm::normalize(dvec3(0.3, 1, 0.4)));
  for (const dmat4& matrix : {dmat4(1), tilt})
    for (const Arrangement& arrangement : arrangements()) {
      GltfScene file;
      for (const Lamp& lamp : arrangement.lamps)
        file.add(transformed(matrix, {lamp.polygon}), emitter(dvec3(lamp.radiance), lamp.is_double_sided));
      if (arrangement.is_cut) file.expect_warning("each point shines once");
      // A hair is 2e-7 m, of which placing a corner takes up to half.
      EXPECT_NEAR(power_over_pi(prepare(file).scene), arrangement.power_over_pi, 1e-5) << arrangement.name;
    }
}

// What is cut keeps what its vertices carry.
TEST(EmitterOverlap, PiecesInterpolateTheirVertices) {
  GltfScene file;
  file.add({square(0, 0, 1)}, emitter(dvec3(1)));
  Corners corners;
  corners.uvs = {{0.4F, 0.3F}, {0.4F, 1.3F}, {1.4F, 1.3F}, {1.4F, 0.3F}};
  file.add({square(0.4, 0.3, 1)}, emitter(dvec3(2)), dmat4(1), corners);
  file.expect_warning("each point shines once");
  const PreparedScene prepared = prepare(file);
  size_t pieces = 0;
  for (const interface::Triangle& t : prepared.scene.triangles) {
    if (prepared.scene.materials[t.material].emission.x != 2) continue;
    ++pieces;
    for (const uint32_t v : {t.v0, t.v1, t.v2}) {
      const interface::Vertex& vertex = prepared.scene.vertices[v];
      EXPECT_NEAR(vertex.uv.x, vertex.position.x, 1e-6);
      EXPECT_NEAR(vertex.uv.y, vertex.position.z, 1e-6);
      EXPECT_EQ(vertex.normal, glm::vec3(0, 1, 0));
    }
  }
  EXPECT_GT(pieces, 2u);
}

// Through the holes of a mask what lies behind shines as well: both are lights, as before.
TEST(EmitterOverlap, SurfacesWithHolesHideNothing) {
  GltfScene file;
  nlohmann::json mask = emitter(dvec3(3));
  mask["alphaMode"] = "MASK";
  mask["pbrMetallicRoughness"]["baseColorTexture"] = {
      {"index",
       file.add_texture(2, {255, 255, 255, 255, 255, 255, 255, 0, 255, 255, 255, 0, 255, 255, 255, 255})}};
  Corners corners;
  corners.uvs = {{0, 0}, {0, 1}, {1, 1}, {1, 0}};
  file.add({square(0, 0, 1)}, mask, dmat4(1), corners);
  file.add({square(0.5, 0, 1)}, emitter(dvec3(1)));
  file.expect_warning("each point shines once");
  const PreparedScene prepared = prepare(file);
  // Of the two, what has no holes stays whole, and the other one loses what lies in it.
  double area_with_holes = 0, area_without = 0;
  for (const interface::Light& light : prepared.scene.lights)
    (light.intensity.x == 3 ? area_with_holes : area_without) += double{light.area};
  EXPECT_NEAR(area_without, 1, 1e-6);
  EXPECT_NEAR(area_with_holes, 0.5, 1e-6);
}

}  // namespace
}  // namespace regulus::test
