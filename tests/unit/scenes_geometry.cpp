// The scenes are built as scenes/README.md says: fronts and normals on the right side, closed solids, equal
// powers, and known values that follow from the geometry by another way than the generator's.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "unit/scene_facets.hpp"

namespace regulus::test {
namespace {

nlohmann::json expected_values(const std::string& stem) {
  std::ifstream stream(scene_path(stem));
  return nlohmann::json::parse(stream)["scenes"][0]["extras"]["regulus_expected"];
}

const char* const ALL_SCENES[] = {"cornell/cornell",
                                  "plates/plates",
                                  "mirrors/mirrors",
                                  "furnace/furnace",
                                  "furnace/furnace-glass",
                                  "furnace/furnace-mirror",
                                  "furnace/furnace-rough",
                                  "furnace/furnace-point",
                                  "watch/watch",
                                  "ring/ring",
                                  "pool/pool",
                                  "lamp/lamp",
                                  "smallvcm/smallvcm-sun",
                                  "smallvcm/smallvcm-ceiling",
                                  "smallvcm/smallvcm-point",
                                  "smallvcm/smallvcm-background",
                                  "gallery/gallery"};

TEST(Scenes, LoadWithoutWarningAndNormalsFaceTheFront) {
  for (const char* stem : ALL_SCENES) {
    const scene::Scene scene = scene::load(scene_path(stem));
    EXPECT_TRUE(scene.warnings.empty()) << stem << ": " << (scene.warnings.empty() ? "" : scene.warnings[0]);
    EXPECT_TRUE(scene.resolution.has_value()) << stem;
    EXPECT_EQ(scene.cameras.size(), 1u) << stem;
    EXPECT_TRUE(scene.settings.contains("spp") && scene.settings.contains("max-depth")) << stem;
    double smallest = 1;
    for (const interface::Triangle& triangle : scene.triangles) {
      const auto vertex = [&](uint32_t i) { return scene.vertices[i]; };
      const dvec3 normal = glm::normalize(
          glm::cross(dvec3(vertex(triangle.v1).position) - dvec3(vertex(triangle.v0).position),
                     dvec3(vertex(triangle.v2).position) - dvec3(vertex(triangle.v0).position)));
      for (uint32_t i : {triangle.v0, triangle.v1, triangle.v2})
        smallest = std::min(smallest, glm::dot(normal, dvec3(vertex(i).normal)));
    }
    // The coarsest smooth sphere, 12 facets along an icosahedron's edge of 63 degrees, turns 5.3 degrees per
    // facet, a vertex normal less than that against its facets: cos(5.3 degrees) = 0.9957.
    std::printf("%s: smallest cosine between shading and geometric normal %.5f\n", stem, smallest);
    EXPECT_GT(smallest, 0.9957) << stem;
  }
}

TEST(Scenes, CornellFacesItsRoom) {
  const scene::Scene scene = scene::load(scene_path("cornell/cornell"));
  const dvec3 inside(0, 0.3, -0.28);
  for (const char* wall : {"white", "red", "green"}) expect_facing(facets(scene, wall), inside, true);
  for (const Facet& facet : facets(scene, "lamp")) EXPECT_NEAR(facet.normal().y, -1, 1e-6);
  for (const char* ball : {"mirror", "glass"}) {
    const std::vector<Facet> surface = facets(scene, ball);
    dvec3 center(0), low(1e9), high(-1e9);
    for (const Facet& facet : surface) {
      low = glm::min(low, facet.p0);
      high = glm::max(high, facet.p0);
    }
    center = 0.5 * (low + high);
    expect_facing(surface, center, false);
    expect_closed(surface);
    EXPECT_GT(low.y, 0) << "touches the floor's plane";
    EXPECT_LT(high.y, 0.5488);
    EXPECT_GT(low.x, -0.2764);
    EXPECT_LT(high.x, 0.2764);
    EXPECT_GT(low.z, -0.5592);
  }
}

TEST(Scenes, PlatesMirrorTheLightsAndLightsHaveEqualPower) {
  const scene::Scene scene = scene::load(scene_path("plates/plates"));
  const dvec3 eye(scene.cameras[0].camera_to_world[3]);
  const dvec3 light_row(0, 4.2, 0);
  for (const char* roughness : {"0.07", "0.14", "0.25", "0.5"}) {
    const std::vector<Facet> plate = facets(scene, std::string("metal of roughness ") + roughness);
    ASSERT_EQ(plate.size(), 2u);
    const dvec3 center = 0.5 * (plate[0].center() + plate[1].center());
    const dvec3 mirrored = glm::reflect(glm::normalize(center - eye), plate[0].normal());
    EXPECT_NEAR(glm::dot(mirrored, glm::normalize(light_row - center)), 1, 1e-6) << roughness;
    EXPECT_GT(glm::dot(plate[0].normal(), eye - center), 0) << roughness;
  }
  std::vector<double> powers;
  for (const char* radius : {"0.033", "0.1", "0.3", "0.9"}) {
    double power = 0;
    const std::vector<Facet> light = facets(scene, std::string("emitter ") + radius);
    expect_closed(light);
    for (const Facet& facet : light)
      power += std::numbers::pi * facet.area() * glm::dot(facet.emission, dvec3(0.2126, 0.7152, 0.0722));
    powers.push_back(power);
  }
  for (double power : powers) EXPECT_NEAR(power, powers[0], 1e-5 * powers[0]);
}

TEST(Scenes, FurnacesAreClosedAndFaceInwards) {
  for (const char* stem : ALL_SCENES) {
    if (std::string(stem).rfind("furnace", 0) != 0) continue;
    const scene::Scene scene = scene::load(scene_path(stem));
    const bool has_solid = scene.materials.size() == 2;
    const std::vector<Facet> room = facets(scene, scene.material_names[0]);
    expect_facing(room, dvec3(0), true);
    expect_closed(room);
    if (has_solid) {
      const std::vector<Facet> solid = facets(scene, scene.material_names[1]);
      expect_facing(solid, dvec3(0), false);
      expect_closed(solid);
    }
  }
}

TEST(Scenes, FurnaceRadianceIsTheGeometricSeries) {
  const nlohmann::json expected = expected_values("furnace/furnace");
  const scene::Scene scene = scene::load(scene_path("furnace/furnace"));
  for (int channel = 0; channel < 3; ++channel) {
    const double emission = scene.materials[0].emission[channel];
    const double albedo = scene.materials[0].base_color[channel];
    double radiance = 0;
    for (int edge = expected["max_depth"]; edge > 0; --edge) radiance = emission + albedo * radiance;
    // Material factors are floats: 6e-8 relative in a, which 1 / (1 - a) enlarges by at most 5.
    EXPECT_NEAR(expected["radiance"][channel].get<double>(), radiance, 1e-6 * radiance);
  }
}

TEST(Scenes, RoughFurnaceAlbedoIsPlausible) {
  const nlohmann::json albedo = expected_values("furnace/furnace-rough")["ball_mean_albedo"];
  // Uncorrelated shadowing counts blocked light twice; V-cavities mask least at these angles.
  EXPECT_LT(albedo["smith_uncorrelated"], albedo["smith_correlated"]);
  EXPECT_LT(albedo["smith_correlated"], albedo["v_cavity"]);
  EXPECT_LT(albedo["v_cavity"], 1.0);
}

/// Where light meets the receiver's plane x = 4 in `mirrors`, and over which mirrors.
struct Arrival {
  dvec3 point;
  std::vector<std::string> mirrors;
};

/// Follows light from the point light in a direction, reflecting it at the planes z = 0 and z = 2.
Arrival follow(dvec3 direction) {
  dvec3 position(0, 0, 1.1);
  Arrival arrival;
  for (;;) {
    const double to_receiver = (4 - position.x) / direction.x;
    const double mirror_z = direction.z > 0 ? 2 : 0;
    const double to_mirror = direction.z == 0 ? 1e30 : (mirror_z - position.z) / direction.z;
    if (to_receiver <= to_mirror) {
      arrival.point = position + to_receiver * direction;
      return arrival;
    }
    position += to_mirror * direction;
    position.z = mirror_z;
    direction.z = -direction.z;
    arrival.mirrors.push_back(mirror_z == 0 ? "z=0" : "z=2");
  }
}

TEST(Scenes, MirrorChainsAreRealPathsWithIrradianceFluxPerArea) {
  const nlohmann::json expected = expected_values("mirrors/mirrors");
  constexpr double INTENSITY = 30;
  const dvec3 receiver(4, 0.3, 0.9);
  for (const nlohmann::json& chain : expected["irradiance_per_chain"]) {
    const auto mirrors = chain["mirrors_from_light"].get<std::vector<std::string>>();
    EXPECT_EQ(chain["edges"], mirrors.size() + 2);
    // How far the path climbs in all (downwards first: negative), from the order of its mirrors: to the first
    // mirror, 2 m per traverse, and from the last mirror to the receiver.
    const bool starts_up = mirrors.empty() ? false : mirrors[0] == "z=2";
    double climb = receiver.z - 1.1;
    if (!mirrors.empty()) {
      const auto traverses = static_cast<double>(mirrors.size() - 1);
      const double last = mirrors.back() == "z=2" ? 2 - receiver.z : receiver.z;
      climb = ((starts_up ? 2 - 1.1 : 1.1) + 2 * traverses + last) * (starts_up ? 1 : -1);
    }
    const auto arrive = [&](double slope_y, double slope_z) {
      return follow(glm::normalize(dvec3(1, slope_y, slope_z)));
    };
    const double slope_y = 0.3 / 4, slope_z = climb / 4;
    const Arrival arrival = arrive(slope_y, slope_z);
    EXPECT_EQ(arrival.mirrors, mirrors);
    EXPECT_LT(glm::length(arrival.point - receiver), 1e-9);

    // Irradiance as flux over area: the solid angle of a small square of slopes, over the square it lands on.
    constexpr double H = 1e-5;
    const dvec3 u = arrive(slope_y + H, slope_z).point - arrive(slope_y - H, slope_z).point;
    const dvec3 v = arrive(slope_y, slope_z + H).point - arrive(slope_y, slope_z - H).point;
    const double solid_angle = 4 * H * H / std::pow(1 + slope_y * slope_y + slope_z * slope_z, 1.5);
    const double irradiance = INTENSITY * solid_angle / glm::length(glm::cross(u, v));
    // Central differences of a linear map, rounding 1e-15 / H.
    EXPECT_NEAR(chain["irradiance"].get<double>(), irradiance, 1e-8 * irradiance);
  }
  // The value of the note on regularization for the chain z=0, z=2.
  EXPECT_NEAR(expected["irradiance_per_chain"][3]["irradiance"].get<double>() / INTENSITY, 0.020419, 5e-7);
}

TEST(Scenes, MirrorsAndReceiverStandWhereTheNoteSays) {
  const scene::Scene scene = scene::load(scene_path("mirrors/mirrors"));
  expect_facing(facets(scene, "mirror"), dvec3(0, 0, 1.1), true);
  const std::vector<Facet> receiver = facets(scene, "receiver");
  EXPECT_NEAR(glm::length(0.5 * (receiver[0].center() + receiver[1].center()) - dvec3(4, 0.3, 0.9)), 0, 1e-6);
  EXPECT_NEAR(receiver[0].normal().x, -1, 1e-6);
  ASSERT_EQ(scene.lights.size(), 1u);
  EXPECT_NEAR(glm::length(dvec3(scene.lights[0].position) - dvec3(0, 0, 1.1)), 0, 1e-6);
  EXPECT_TRUE(scene.cameras[0].is_orthographic);
}

}  // namespace
}  // namespace regulus::test
