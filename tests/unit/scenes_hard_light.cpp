// The scenes with light that is hard to find: solids are closed and the right way out, lamps shine at what
// they should and sit where they should, and volumes are those of the shapes they are meant to be.
#include <gtest/gtest.h>

#include <numbers>

#include "unit/scene_facets.hpp"

namespace regulus::test {
namespace {

using std::numbers::pi;

/// All facets of these materials together are the boundary of a solid. @returns its volume.
double expect_solid(const scene::Scene& scene, const std::vector<std::string>& materials) {
  std::vector<Facet> surface;
  for (const std::string& material : materials) {
    const std::vector<Facet> part = facets(scene, material);
    surface.insert(surface.end(), part.begin(), part.end());
  }
  SCOPED_TRACE(materials[0]);
  expect_watertight(surface);
  const double volume = volume_of(surface);
  EXPECT_GT(volume, 0);
  return volume;
}

double farthest(const std::vector<Facet>& surface, const dvec3& from) {
  double distance = 0;
  for (const Facet& facet : surface) distance = std::max(distance, glm::length(facet.p0 - from));
  return distance;
}

double nearest(const std::vector<Facet>& surface, const dvec3& from) {
  double distance = 1e30;
  for (const Facet& facet : surface) distance = std::min(distance, glm::length(facet.p0 - from));
  return distance;
}

TEST(HardLight, WatchIsMadeOfClosedSolids) {
  const scene::Scene scene = scene::load(scene_path("watch/watch"));
  const double steel = expect_solid(scene, {"brushed steel", "polished steel", "satin steel"});
  expect_solid(scene, {"polished gold"});
  expect_solid(scene, {"leather"});
  // Two spherical caps over cylinders, one inside of the other, in mm: the outer sphere rises 2.6 over a rim
  // of radius 17.4, 1.3 above the foot; the inner one is 1.3 closer to its centre and has a rim of
  // radius 15.8.
  const auto cap = [](double radius, double height) { return pi * height * height * (radius - height / 3); };
  const double outer = (17.4 * 17.4 + 2.6 * 2.6) / (2 * 2.6), inner = outer - 1.3;
  const double inner_rim = std::sqrt(inner * inner - 15.8 * 15.8);  // above the spheres' centre
  const double foot = outer - 2.6 - 1.3;                            // likewise
  const double outside = cap(outer, 2.6) + pi * 17.4 * 17.4 * 1.3;
  const double hollow = cap(inner, inner - inner_rim) + pi * 15.8 * 15.8 * (inner_rim - foot);
  // Polygons of 192 sides have 0.9998 of a circle's area.
  EXPECT_NEAR(expect_solid(scene, {"sapphire"}) / (1e-9 * (outside - hollow)), 1, 0.002);
  // Less than the cylinder around case and lugs, more than half of the case's own.
  EXPECT_LT(steel, 1e-9 * pi * 20 * 20 * 8);
  EXPECT_GT(steel, 0.5e-9 * pi * 20 * 20 * 7);
}

TEST(HardLight, WatchIsLitThroughItsCrystalOnly) {
  const scene::Scene scene = scene::load(scene_path("watch/watch"));
  const std::vector<Facet> crystal = facets(scene, "sapphire"), gold = facets(scene, "polished gold"),
                           printing = facets(scene, "white ink");
  double crystal_radius = 0, crystal_top = 0, foot = 1;
  for (const Facet& facet : crystal) {
    crystal_radius = std::max(crystal_radius, std::hypot(facet.p0.x, facet.p0.z));
    crystal_top = std::max(crystal_top, facet.p0.y);
    foot = std::min(foot, facet.p0.y);
  }
  for (const std::vector<Facet>* part : {&gold, &printing})
    for (const Facet& facet : *part) {
      EXPECT_LT(std::hypot(facet.p0.x, facet.p0.z), crystal_radius);
      EXPECT_LT(facet.p0.y, crystal_top);
    }
  for (const Facet& facet : printing) EXPECT_GT(facet.normal().y, 0.999999);
  for (const char* lamp : {"lamp 1", "lamp 2", "lamp 3"}) {
    EXPECT_GT(nearest(facets(scene, lamp), {0, 0, 0}), 0.1);
    expect_facing(facets(scene, lamp), dvec3(0), true);
  }
  expect_facing(facets(scene, "panel"), dvec3(0), true);
}

TEST(HardLight, RingsAreClosedAndStandOnTheTable) {
  const scene::Scene scene = scene::load(scene_path("ring/ring"));
  expect_solid(scene, {"gold"});
  // A torus; its polygons lose (1 - sin(x) / x), x = 2 pi / 40 and 2 pi / 192, of each circle.
  const double torus = 2 * pi * pi * 0.0088 * 0.0008 * 0.0008;
  EXPECT_NEAR(expect_solid(scene, {"silver"}), torus, 0.006 * torus);
  for (const char* ring : {"gold", "silver"}) {
    double lowest = 1;
    for (const Facet& facet : facets(scene, ring)) lowest = std::min(lowest, facet.p0.y);
    EXPECT_NEAR(lowest, 0, 1e-4) << ring;
  }
  expect_facing(facets(scene, "panel"), dvec3(0), true);
}

TEST(HardLight, PoolHoldsItsWater) {
  const scene::Scene scene = scene::load(scene_path("pool/pool"));
  // 4 m x 3 m x 1.1 m and 2 cm more on each side; waves of a few wavelengths move the mean by less than 1 cm.
  const double area = 4.04 * 3.04;
  EXPECT_NEAR(expect_solid(scene, {"water"}), 1.12 * area, 0.01 * area);
  for (const char* solid : {"stone", "red", "yellow"}) expect_solid(scene, {solid});
  // Tiles and grout close the basin behind the water's surface.
  const dvec3 in_the_basin(0, -0.5, 0);
  expect_facing(facets(scene, "tile"), in_the_basin, true);
  expect_facing(facets(scene, "grout"), in_the_basin, true);
  expect_facing(facets(scene, "sun"), dvec3(0), true);
  expect_facing(facets(scene, "sky"), dvec3(0), true);
  // A disk seen under the sun's 0.27 degrees.
  double sun_area = 0;
  for (const Facet& facet : facets(scene, "sun")) sun_area += facet.area();
  EXPECT_NEAR(std::sqrt(sun_area / pi) / 14, std::tan(0.27 * pi / 180), 0.01 * 0.0047);
}

TEST(HardLight, LampsAreInsideTheirGlass) {
  const scene::Scene scene = scene::load(scene_path("lamp/lamp"));
  const struct {
    const char *glass, *filament;
    dvec3 center;
    double radius, thickness;
  } lamps[] = {{"frosted glass", "filament of the globe", {-0.42, 1.02, -0.35}, 0.13, 0.005},
               {"clear glass", "filament of the bulb", {0.38, 1.50, -0.25}, 0.075, 0.002}};
  for (const auto& lamp : lamps) {
    const double inner = lamp.radius - lamp.thickness;
    const double shell = 4 * pi / 3 * (std::pow(lamp.radius, 3) - std::pow(inner, 3));
    EXPECT_NEAR(expect_solid(scene, {lamp.glass}), shell, 0.01 * shell) << lamp.glass;
    EXPECT_NEAR(nearest(facets(scene, lamp.glass), lamp.center), inner, 1e-6);
    EXPECT_LT(farthest(facets(scene, lamp.filament), lamp.center), 0.5 * inner);
  }
  for (const char* solid : {"wood", "glaze", "cloth", "brass"}) expect_solid(scene, {solid});
  // The room is closed.
  std::vector<Facet> room;
  for (const char* wall : {"plaster", "painted plaster", "boards"}) {
    const std::vector<Facet> part = facets(scene, wall);
    room.insert(room.end(), part.begin(), part.end());
  }
  expect_watertight(room);
  EXPECT_NEAR(volume_of(room), -3.0 * 2.2 * 2.8, 1e-5) << "fronts face inwards";
}

TEST(HardLight, SmallVcmBoxesHaveItsMeasures) {
  for (const char* variant : {"sun", "ceiling", "point", "background"}) {
    const scene::Scene scene = scene::load(scene_path(std::string("smallvcm/smallvcm-") + variant));
    const bool is_large = std::string(variant) == "ceiling";
    const double radius = is_large ? 0.8 : 0.5, ball = 4 * pi / 3 * std::pow(radius, 3);
    // 20,480 facets: their corners are on the sphere.
    EXPECT_NEAR(expect_solid(scene, {"mirror"}), ball, 0.002 * ball) << variant;
    if (!is_large) {
      EXPECT_NEAR(expect_solid(scene, {"glass"}), ball, 0.002 * ball) << variant;
    }
    for (const char* wall : {"glossy", "white", "blue", "green", "red"})
      expect_facing(facets(scene, wall), dvec3(0), true);
    const bool has_punctual = std::string(variant) == "sun" || std::string(variant) == "point";
    EXPECT_EQ(scene.lights.size(), has_punctual ? 1u : 0u) << variant << ": those that are not surfaces";
    if (is_large) {
      for (const Facet& facet : facets(scene, "lamp")) EXPECT_NEAR(facet.normal().y, -1, 1e-6);
    }
  }
  const scene::Scene sun = scene::load(scene_path("smallvcm/smallvcm-sun"));
  EXPECT_LT(glm::length(dvec3(sun.lights[0].direction) - glm::normalize(dvec3(-1, -1, -1.5))), 1e-6);
  EXPECT_NEAR(sun.lights[0].intensity.x, 10, 1e-5);
  const scene::Scene point = scene::load(scene_path("smallvcm/smallvcm-point"));
  EXPECT_LT(glm::length(dvec3(point.lights[0].position) - dvec3(0, 1, 0.5)), 1e-6);
  const scene::Scene sky = scene::load(scene_path("smallvcm/smallvcm-background"));
  ASSERT_TRUE(sky.environment && !sky.environment->is_map());
  EXPECT_LT(glm::length(dvec3(sky.environment->parameters.radiance) * 255.0 - dvec3(135, 206, 250)), 1e-4);
}

}  // namespace
}  // namespace regulus::test
