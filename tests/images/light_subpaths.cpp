// Every set of techniques estimates the same image. The sets are compared with path tracing, which shares
// with them the walks and the bsdfs but neither light subpaths, splats, connections, merges nor their
// weights.
#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>
#include <map>
#include <span>

#include "images/support/comparison.hpp"
#include "images/support/render_scene.hpp"
#include "images/support/room.hpp"
#include "render/technique_sets.hpp"
#include "support/device.hpp"
#include "support/random.hpp"
#include "support/run_length.hpp"

namespace regulus::test {
namespace {

using namespace interface;
using render::RenderSettings;

constexpr int BATCHES = 11;
constexpr uint32_t SIZE = 16;

using namespace technique_sets;

struct NamedSet {
  const char* name;
  uint32_t techniques;
};

// Connections to drawn vertices and merges of an iteration that has more light paths than the film has
// pixels.
RenderSettings settings_of(uint32_t techniques, uint32_t cache_connections) {
  RenderSettings settings = box_filtered(SIZE, SIZE, is_slow_device() ? 4 : 24, 5);
  settings.techniques = techniques;
  settings.cache_connections = cache_connections;
  if ((techniques & TECHNIQUE_MERGE) != 0) {
    settings.light_paths = 2048;
    settings.merge_radius = 0.02f;
    settings.merge_reduction = 0;
  }
  return settings;
}

class LightSubpaths : public testing::Test {
 protected:
  void SetUp() override { REGULUS_SKIP_WITHOUT_DEVICE(); }

  void expect_sets_agree(const char* name, const GltfScene& scene, const std::vector<NamedSet>& sets,
                         uint32_t reference = PT) {
    expect_sets_agree(name, prepare(scene), sets, reference);
  }

  void expect_sets_agree(const char* name, const PreparedScene& prepared, const std::vector<NamedSet>& sets,
                         uint32_t reference = PT) {
    // A slow device compiles and runs two sets in one scene only: what it could get wrong is the driver's.
    // Two sets in each scene meet all kinds of surfaces and lights, and in the first, by name, all sets.
    const bool is_first = std::string(name) == "diffuse room";
    if (is_slow_device() && !is_first) GTEST_SKIP() << "slow device";
    const bool has_all = is_full_run() || (is_first && !is_slow_device());
    const size_t set_count = has_all ? sets.size() : std::min<size_t>(2, sets.size());
    const auto known = render_batches(prepared, settings_of(reference, 0), BATCHES, 100);
    std::printf("%s: mean %.4f\n", name, mean_of(known[0])[0]);
    EXPECT_GT(mean_of(known[0])[0], 0);
    uint32_t stream = 101;
    for (const NamedSet& set : std::span(sets).first(set_count)) {
      const bool is_cached = std::string(set.name).find("cache") != std::string::npos;
      const auto batches =
          render_batches(prepared, settings_of(set.techniques, is_cached ? 3 : 0), BATCHES, stream++);
      ComparisonOptions options;
      // A merge averages over its disk, which matters near edges and corners.
      if ((set.techniques & TECHNIQUE_MERGE) != 0) options.relative_tolerance = 3e-3;
      expect_equal((std::string(name) + ", " + set.name).c_str(), batches, known, options);
    }
  }
};

// Compiling takes most of the time, so scenes unite what does not hide each other's faults, and each is
// rendered by `vcm`, which weighs all techniques, and by sets that leave most of the light to what is new in
// the scene.
TEST_F(LightSubpaths, AgreeOnDiffuseSurfaces) {
  GltfScene scene = room(WHITE, WHITE, WHITE);
  scene.add({ceiling_light()}, emitter({2, 1.5, 1}));
  expect_sets_agree("diffuse room", scene,
                    {{"bpt", BPT},
                     {"vcm", VCM},
                     {"bpt, cache", BPT},
                     {"bpm", PT | TECHNIQUE_MERGE},
                     {"lt", TECHNIQUE_SPLAT},
                     {"vcm, cache", VCM}});
}

// One lamp shines up and down, another stands on the front wall.
TEST_F(LightSubpaths, AgreeOnGlossySurfacesAndDoubleSidedLights) {
  GltfScene scene =
      room(plastic({0.4, 0.4, 0.6}, 0.5), metal({0.9, 0.7, 0.4}, 0.5), plastic({0.2, 0.5, 0.3}, 0.7));
  scene.add({quad({-0.4, 0.35, -0.4}, {0.8, 0, 0}, {0, 0, 0.8})}, emitter({2, 1.5, 1}, true));
  scene.add({quad({-0.6, 0.3, 0.999}, {0, 0.5, 0}, {1.2, 0, 0})}, emitter({0.5, 1, 2}));
  expect_sets_agree("glossy room", scene,
                    {{"vcm", VCM},
                     {"hit, connect", TECHNIQUE_HIT | TECHNIQUE_CONNECT},
                     {"nee, splat", TECHNIQUE_NEE | TECHNIQUE_SPLAT}});
}

// Rough and clear glass that absorbs: the eta^2 of light walks, the medium of edges, delta events in the
// weights.
TEST_F(LightSubpaths, AgreeOnGlass) {
  GltfScene scene = room(WHITE, glass(1.5, 0.5, {0.9, 0.6, 0.5}), glass(1.4, 0, {0.3, 0.8, 0.9}));
  scene.add({ceiling_light()}, emitter({2, 1.5, 1}));
  expect_sets_agree("glass", scene,
                    {{"vcm", VCM},
                     {"bpt, cache", BPT},
                     {"hit, splat, merge", TECHNIQUE_HIT | TECHNIQUE_SPLAT | TECHNIQUE_MERGE}});
}

// Lights that cannot be hit, of every kind, together with one that can.
TEST_F(LightSubpaths, AgreeOnPunctualLights) {
  GltfScene scene = room(plastic({0.5, 0.4, 0.6}, 0.6), WHITE, glass(1.5, 0.6));
  scene.add({ceiling_light()}, emitter({0.5, 0.4, 0.3}));
  scene.add_point_light({0.3, 0.4, 0.2}, {0.2, 0.3, 0.4});
  scene.add_spot_light({-0.5, 0.6, 0.4}, {0.3, -1, -0.4}, 0.8, 0.2, 0.7);
  expect_sets_agree("punctual lights", scene, {{"vcm", VCM}, {"bpt", BPT}});
}

// A room that is lit through a window in its ceiling, by a sky with a small sun, and by a lamp. What the sun
// reaches through glass is seen by few of these sets in few samples, so the boxes are rough.
TEST_F(LightSubpaths, AgreeOnAnEnvironmentSeenThroughAWindow) {
  GltfScene scene;
  const Polygons walls = turned(box({-1, -1, -1}, {1, 1, 1}));
  for (const size_t wall : {0u, 1u, 2u, 4u, 5u})
    scene.add({walls[wall]}, wall == 2 ? plastic({0.4, 0.4, 0.6}, 0.5) : WHITE);
  scene.add({quad({-1, 1, -1}, {2, 0, 0}, {0, 0, 0.6}), quad({-1, 1, 0.2}, {2, 0, 0}, {0, 0, 0.8})}, WHITE);
  scene.add(box({-0.6, -1, -0.5}, {-0.1, -0.4, 0}), metal({0.9, 0.7, 0.4}, 0.6));
  scene.add(box({0.2, -0.9, -0.3}, {0.6, -0.6, 0.2}), glass(1.5, 0.6));
  scene.add({quad({-0.2, 0.2, -0.999}, {0.4, 0, 0}, {0, 0.2, 0})}, emitter({1, 0.5, 0.5}));
  scene.set_perspective(look_at({0, -0.2, 0.95}, {0, -1, -0.6}), 0.85);
  image::Image sky{16, 8, {}};
  for (uint32_t i = 0; i < 16 * 8; ++i)
    for (const double channel : {0.4, 0.6, 1.0})
      sky.rgb.push_back(static_cast<float>(i == 2 * 16 + 5 ? 40 : i < 64 ? channel * (1 + i % 3) : 0.1));
  expect_sets_agree("window", prepare(scene, sky, 25),
                    {{"vcm", VCM}, {"nee, splat", TECHNIQUE_NEE | TECHNIQUE_SPLAT}});
}

// Hundreds of lamps of every kind, however nee chooses among them: by power as the reference, by the light
// tree, whose probabilities depend on the surface, uniformly.
TEST_F(LightSubpaths, AgreeOnManyLightsHoweverTheyAreChosen) {
  if (is_slow_device()) GTEST_SKIP() << "slow device";
  GltfScene scene = room(plastic({0.4, 0.4, 0.6}, 0.5), WHITE, glass(1.5, 0.6));
  Random random(210);
  Polygons dim, bright, two_sided;
  for (int i = 0; i < 300; ++i) {
    const glm::dvec3 place = 1.8 * random.cube() - 0.9, u = 0.02 * random.direction();
    const Polygon panel = quad(place, u, 0.02 * normalize(cross(u, random.direction())));
    (i % 8 == 0 ? bright : i % 8 == 1 ? two_sided : dim).push_back(panel);
  }
  scene.add(dim, emitter({4, 3, 2}));
  scene.add(bright, emitter({20, 20, 30}));
  scene.add(two_sided, emitter({9, 3, 3}, true));
  scene.add_point_light({0.3, 0.4, 0.2}, {0.02, 0.03, 0.04});
  scene.add_spot_light({-0.5, 0.6, 0.4}, {0.3, -1, -0.4}, 0.08, 0.2, 0.7);
  const PreparedScene prepared = prepare(scene);
  const auto batches_of = [&](uint32_t techniques, uint32_t light_sampling, uint32_t stream) {
    RenderSettings settings = settings_of(techniques, 0);
    settings.light_sampling = light_sampling;
    return render_batches(prepared, settings, BATCHES, stream);
  };
  const auto known = batches_of(PT, LIGHT_SAMPLING_POWER, 220);
  expect_equal("many lights, pt, bvh", batches_of(PT, LIGHT_SAMPLING_BVH, 221), known);
  expect_equal("many lights, pt, uniform", batches_of(PT, LIGHT_SAMPLING_UNIFORM, 222), known);
  expect_equal("many lights, bpt, bvh", batches_of(BPT, LIGHT_SAMPLING_BVH, 223), known);
  expect_equal("many lights, nee and splat, bvh",
               batches_of(TECHNIQUE_NEE | TECHNIQUE_SPLAT, LIGHT_SAMPLING_BVH, 225), known);
  ComparisonOptions blurred;
  blurred.relative_tolerance = 3e-3;  // as in expect_sets_agree()
  expect_equal("many lights, vcm, bvh", batches_of(VCM, LIGHT_SAMPLING_BVH, 226), known, blurred);
}

// A floor with boxes under a distant light.
TEST_F(LightSubpaths, AgreeOnDirectionalLights) {
  GltfScene scene;
  scene.add({quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2})}, WHITE);
  scene.add(box({-0.6, 0, -0.4}, {-0.1, 0.7, 0.1}), plastic({0.3, 0.6, 0.4}, 0.5));
  scene.add(sphere({0.45, 0.35, 0.1}, 0.3, 12), metal({0.9, 0.8, 0.6}, 0.6));
  scene.add_directional_light({-0.4, -1, -0.3}, 2);
  scene.set_perspective(look_at({0, 1.2, 2.2}, {0, 0.2, 0}), 0.7);
  expect_sets_agree("directional light", scene, {{"bpt", BPT}, {"bpm", PT | TECHNIQUE_MERGE}}, TECHNIQUE_NEE);
}

// Relief on a floor and on a glossy box: shading normals far from the geometric ones, so that many directions
// lie on different sides of the two.
TEST_F(LightSubpaths, AgreeOnNormalMaps) {
  GltfScene scene = room(WHITE, plastic({0.2, 0.5, 0.3}, 0.6), WHITE);
  const auto uvs_of = [](const Polygons& polygons) {
    std::vector<glm::vec2> uvs;
    for (const Polygon& polygon : polygons)
      for (const glm::dvec3& p : polygon) uvs.emplace_back(2 * p.x + 0.5 * p.y, 2 * p.z - p.y);
    return uvs;
  };
  const Polygons floor = {quad({-0.95, -0.95, -0.95}, {0, 0, 1.9}, {1.9, 0, 0})};
  Corners corners;
  corners.uvs = uvs_of(floor);
  scene.add(floor, bumpy(scene, lambert({0.7, 0.7, 0.7})), glm::dmat4(1), corners);
  const Polygons block = box({-0.1, -0.8, 0.1}, {0.3, -0.5, 0.4});
  corners.uvs = uvs_of(block);
  scene.add(block, bumpy(scene, metal({0.9, 0.7, 0.4}, 0.6)), glm::dmat4(1), corners);
  scene.add({ceiling_light()}, emitter({2, 1.5, 1}));
  expect_sets_agree("normal maps", scene, {{"vcm", VCM}, {"lt", TECHNIQUE_SPLAT}});
}

// A blended box and floor, and a light that is masked: what is there by chance is met once, whichever
// technique finds it.
TEST_F(LightSubpaths, AgreeOnAlpha) {
  const auto with_alpha = [](nlohmann::json material, double alpha, const char* mode) {
    material["pbrMetallicRoughness"]["baseColorFactor"][3] = alpha;
    material["alphaMode"] = mode;
    return material;
  };
  GltfScene scene = room(WHITE, with_alpha(plastic({0.2, 0.5, 0.3}, 0.6), 0.4, "BLEND"), WHITE);
  scene.add({quad({-0.95, -0.9, -0.95}, {0, 0, 1.9}, {1.9, 0, 0})},
            with_alpha(lambert({0.8, 0.3, 0.2}), 0.5, "BLEND"));
  std::vector<uint8_t> rgba;
  for (int i = 0; i < 4; ++i)
    for (const int code : {255, 255, 255, i == 1 ? 0 : 255}) rgba.push_back(static_cast<uint8_t>(code));
  nlohmann::json light = with_alpha(emitter({2, 1.5, 1}), 0.7, "BLEND");
  light["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", scene.add_texture(2, rgba, true)}};
  Corners corners;
  corners.uvs = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
  scene.add({ceiling_light()}, light, glm::dmat4(1), corners);
  // Of merges alone beside path tracing, so that they carry much of the light.
  expect_sets_agree("alpha", scene, {{"vcm", VCM}, {"bpm", PT | TECHNIQUE_MERGE}, {"lt", TECHNIQUE_SPLAT}});
}

// A smooth coat over paint, a rough one over a mirror, a brushed metal: two microfacet lobes at one vertex,
// one of them a delta or not; and coats whose relief is not that of what they cover.
TEST_F(LightSubpaths, AgreeOnCoatsAndAnisotropy) {
  nlohmann::json brushed = metal({0.7, 0.7, 0.7}, 0.4);
  brushed["extensions"]["KHR_materials_anisotropy"] = {{"anisotropyStrength", 0.7},
                                                       {"anisotropyRotation", 0.5}};
  GltfScene scene =
      room(coated(plastic({0.5, 0.2, 0.2}, 0.6), 0), coated(metal({0.9, 0.8, 0.6}, 0), 0.5), WHITE);
  const Polygons block = box({-0.2, -0.99, 0.1}, {0.2, -0.7, 0.4});
  Corners corners;
  for (const Polygon& polygon : block)
    for (const glm::dvec3& p : polygon) corners.uvs.emplace_back(p.x + 0.5 * p.y, p.z - p.y);
  scene.add(block, coated(brushed, 0.5, relief(scene)), glm::dmat4(1), corners);
  const glm::dmat4 aside = glm::translate(glm::dmat4(1), {-0.65, 0.1, 0.2});
  scene.add(block, bumpy(scene, coated(plastic({0.2, 0.5, 0.3}, 0.7), 0)), aside, corners);
  scene.add({ceiling_light()}, emitter({2, 1.5, 1}));
  expect_sets_agree("coats", scene, {{"vcm", VCM}});
}

// Strategy images: the weighted ones sum to the picture, and what a strategy finds alone is what a render of
// nothing else finds with the same random numbers.
TEST_F(LightSubpaths, StrategyImagesSumToThePicture) {
  if (is_slow_device()) GTEST_SKIP() << "slow device";
  GltfScene scene = room(WHITE, plastic({0.2, 0.5, 0.3}, 0.5), WHITE);
  scene.add({ceiling_light()}, emitter({2, 1.5, 1}));
  const PreparedScene prepared = prepare(scene);
  RenderSettings settings = box_filtered(SIZE, SIZE, 4, 4);
  settings.techniques = VCM;
  settings.merge_radius = 0.1f;
  settings.has_strategy_images = true;
  render::Renderer renderer(*device(), prepared, make_plan(prepared, settings));
  renderer.render([](uint64_t, uint64_t) { return true; });
  const image::Image whole = resolve(renderer.film());
  std::vector<double> sum(whole.rgb.size());
  std::map<std::string, image::Image> alone;
  renderer.for_each_strategy([&](const render::StrategyImages& images) {
    // The lamp itself is out of sight.
    if (images.strategy.edges() > 1) {
      EXPECT_GT(mean_of(images.weighted)[0], 0) << images.strategy.name();
    }
    for (size_t i = 0; i < sum.size(); ++i) sum[i] += images.weighted.rgb[i];
    alone[images.strategy.name()] = images.unweighted;
  });
  // Of paths of 1 ... 4 edges: hit 4 (the first of what the camera sees itself), nee 3, splat 3, connect 1 +
  // 2, merge 1 + 2 + 3.
  EXPECT_EQ(alone.size(), 19u);
  for (size_t i = 0; i < sum.size(); ++i) EXPECT_NEAR(sum[i], whole.rgb[i], 1e-5 * (1 + whole.rgb[i])) << i;

  settings.has_strategy_images = false;
  settings.max_depth = 2;
  const std::pair<const char*, uint32_t> direct[] = {
      {"hit-s0-t3", TECHNIQUE_HIT}, {"nee-s1-t2", TECHNIQUE_NEE}, {"splat-s2-t1", TECHNIQUE_SPLAT}};
  for (const auto& [name, technique] : direct) {
    settings.techniques = technique;
    const image::Image known = render(prepared, settings).image;
    const image::Image& image = alone.at(name);
    for (size_t i = 0; i < known.rgb.size(); ++i)
      EXPECT_NEAR(image.rgb[i], known.rgb[i], 1e-5 * (1 + known.rgb[i])) << name << " " << i;
  }
}

// Nearly all shadow rays play, and most are not traced: what is left stands for them.
TEST_F(LightSubpaths, RouletteOfShadowRaysKeepsTheMean) {
  if (is_slow_device()) GTEST_SKIP() << "slow device";
  GltfScene scene = room(WHITE, WHITE, WHITE);
  scene.add({ceiling_light()}, emitter({2, 1.5, 1}));
  const PreparedScene prepared = prepare(scene);
  const auto known = render_batches(prepared, settings_of(PT, 0), BATCHES, 220);
  RenderSettings settings = settings_of(BPT, 0);
  const uint64_t all = render(prepared, settings).statistics.visibility_rays();
  settings.shadow_roulette = 0.5f * static_cast<float>(mean_of(known[0])[0]);
  const uint64_t traced = render(prepared, settings).statistics.visibility_rays();
  std::printf("%.3f of the shadow rays\n", static_cast<double>(traced) / static_cast<double>(all));
  EXPECT_LT(traced, all / 2);
  expect_equal("bpt, roulette", render_batches(prepared, settings, BATCHES, 221), known, {});
}

// Of one edge there is only what the camera sees itself: here nothing that shines. `lt` showed the lamp's own
// light on the walls. Of two edges all sets find the same, less than half of what three edges bring.
TEST_F(LightSubpaths, NoPathIsLongerThanAskedFor) {
  GltfScene scene = room(WHITE, WHITE, WHITE);
  scene.add({ceiling_light()}, emitter({2, 1.5, 1}));
  const PreparedScene prepared = prepare(scene);
  const std::vector<NamedSet> sets = {{"lt", TECHNIQUE_SPLAT}, {"bpt", BPT}, {"vcm", VCM}};
  for (const NamedSet& set : sets)
    for (const uint32_t cache : {0u, 3u}) {
      RenderSettings settings = settings_of(set.techniques, cache);
      settings.max_depth = 1;
      settings.samples = 2;
      for (const float value : render(prepared, settings).image.rgb) ASSERT_EQ(value, 0) << set.name;
    }
  if (is_slow_device()) return;
  const auto batches = [&](uint32_t techniques, uint32_t stream) {
    RenderSettings settings = settings_of(techniques, 0);
    settings.max_depth = 2;
    settings.samples = 8;
    return render_batches(prepared, settings, BATCHES, stream);
  };
  const auto known = batches(PT, 210);
  uint32_t stream = 211;
  for (const NamedSet& set : sets) expect_equal(set.name, batches(set.techniques, stream++), known, {});
}

// The film's border and a camera without perspective: splats through the wide filter reach pixels from film
// points outside the film, and the density of film points is that of parallel rays.
TEST_F(LightSubpaths, SplatsPassThroughTheSameFilterOnAnOrthographicFilm) {
  if (is_slow_device()) GTEST_SKIP() << "slow device";
  GltfScene scene = room(WHITE, WHITE, plastic({0.2, 0.5, 0.3}, 0.5));
  scene.add({ceiling_light()}, emitter({2, 1.5, 1}));
  scene.set_orthographic(look_at({0, -0.1, 0.95}, {0, -0.6, -0.6}), 0.5, 0.4);
  const PreparedScene prepared = prepare(scene);
  RenderSettings settings = settings_of(PT, 0);
  settings.filter = FILTER_GAUSSIAN;
  settings.filter_radius = 1.5f;
  const auto known = render_batches(prepared, settings, BATCHES, 200);
  settings.techniques = TECHNIQUE_SPLAT;
  const auto splats = render_batches(prepared, settings, BATCHES, 201);
  ComparisonOptions options;
  options.tile = 2;
  expect_equal("orthographic, lt", splats, known, options);
}

}  // namespace
}  // namespace regulus::test
