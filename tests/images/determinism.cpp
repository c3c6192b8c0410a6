// The image is a function of scene, settings and seed alone: not of waves, and not of how samples are
// grouped.
#include <gtest/gtest.h>

#include "images/support/render_scene.hpp"
#include "render/technique_sets.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

using render::RenderSettings;

class Determinism : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    cornell_ = new PreparedScene(prepare(own_scenes() / "cornell" / "cornell.gltf"));
  }
  static void TearDownTestSuite() {
    delete cornell_;
    cornell_ = nullptr;
  }
  void SetUp() override { REGULUS_SKIP_WITHOUT_DEVICE(); }

  static RenderSettings settings() {
    RenderSettings settings;  // with the default filter
    settings.width = 48;
    settings.height = 40;  // 1920 pixels: no wave size below divides them
    settings.samples = 8;
    settings.seed = 7;
    return settings;
  }

  static inline PreparedScene* cornell_ = nullptr;
};

TEST_F(Determinism, WaveSizeDoesNotChangeAnyBit) {
  const Rendered by_default = render(*cornell_, settings());
  for (const uint32_t wave : {1024u, 4096u}) {
    RenderSettings other = settings();
    other.wave_paths = wave;
    const Rendered rendered = render(*cornell_, other);
    std::printf("wave %u (default %u)\n", rendered.statistics.wave_capacity,
                by_default.statistics.wave_capacity);
    EXPECT_NE(rendered.statistics.wave_capacity, by_default.statistics.wave_capacity);
    EXPECT_TRUE(rendered.film.words == by_default.film.words) << "wave of " << wave << " paths";
  }
}

// Adds the 96-bit sums of two films.
std::vector<uint32_t> sum(const std::vector<uint32_t>& a, const std::vector<uint32_t>& b) {
  std::vector<uint32_t> result(a.size());
  for (size_t channel = 0; channel < a.size(); channel += 3) {
    uint64_t carry = 0;
    for (size_t word = channel; word < channel + 3; ++word) {
      carry += uint64_t{a[word]} + b[word];
      result[word] = static_cast<uint32_t>(carry);
      carry >>= 32;
    }
  }
  return result;
}

// Splats, connections and merges add up in whatever order they arrive. A large merge radius fills cells, a
// wave of 1024 walks the iteration's light paths and its pixels in pieces, and at 12 edges more vertices come
// than were expected.
TEST_F(Determinism, WaveSizeDoesNotChangeAnyBitWithLightSubpaths) {
  if (is_slow_device()) GTEST_SKIP() << "slow device";
  using namespace technique_sets;
  for (const auto& [techniques, cache_connections] : {std::pair(BPT, 0u), std::pair(VCM, 2u)}) {
    RenderSettings whole = settings();
    whole.samples = 3;
    whole.techniques = techniques;
    whole.cache_connections = cache_connections;
    whole.shadow_roulette = techniques == VCM ? 0.1f : 0;
    whole.merge_radius = 0.1f;
    RenderSettings pieces = whole;
    pieces.wave_paths = 1024;
    const Rendered first = render(*cornell_, whole), second = render(*cornell_, pieces);
    EXPECT_TRUE(first.film.words == second.film.words) << "techniques " << techniques;
    EXPECT_TRUE(first.film.splat_words == second.film.splat_words) << "techniques " << techniques;
  }
}

TEST_F(Determinism, SampleRangesAddUpWithLightSubpaths) {
  if (is_slow_device()) GTEST_SKIP() << "slow device";
  RenderSettings part = settings();
  part.techniques = interface::TECHNIQUE_HIT | interface::TECHNIQUE_NEE | interface::TECHNIQUE_SPLAT |
                    interface::TECHNIQUE_CONNECT | interface::TECHNIQUE_MERGE;
  part.merge_radius = 0.05f;
  part.shadow_roulette = 0.1f;
  part.samples = 4;
  const Rendered whole = render(*cornell_, part);
  part.samples = 2;
  const Rendered front = render(*cornell_, part);
  part.first_sample = 2;
  const Rendered back = render(*cornell_, part);
  EXPECT_TRUE(sum(front.film.words, back.film.words) == whole.film.words);
  EXPECT_TRUE(sum(front.film.splat_words, back.film.splat_words) == whole.film.splat_words);
}

TEST_F(Determinism, SameSeedTwiceIsIdenticalAndAnotherSeedIsNot) {
  const Rendered first = render(*cornell_, settings()), second = render(*cornell_, settings());
  EXPECT_TRUE(first.film.words == second.film.words);
  RenderSettings other = settings();
  other.seed = 8;
  const Rendered reseeded = render(*cornell_, other);
  size_t equal_pixels = 0;
  for (size_t i = 0; i < first.film.words.size(); i += interface::FILM_WORDS_PER_PIXEL)
    equal_pixels += std::equal(first.film.words.begin() + i,
                               first.film.words.begin() + i + interface::FILM_WORDS_PER_PIXEL,
                               reseeded.film.words.begin() + i);
  std::printf("%zu of %zu pixels equal under another seed\n", equal_pixels, size_t{48} * 40);
  // Eight samples of a pixel whose paths all end unlit, or all on the light, are equal by right. The Cornell
  // box fills the frame's middle half at least.
  EXPECT_LT(equal_pixels, size_t{48} * 40 / 2);
}

TEST_F(Determinism, SampleRangesAddUpToTheWhole) {
  const Rendered whole = render(*cornell_, settings());
  RenderSettings part = settings();
  part.samples = 4;
  const Rendered front = render(*cornell_, part);
  part.first_sample = 4;
  const Rendered back = render(*cornell_, part);
  EXPECT_TRUE(front.film.words != back.film.words);
  EXPECT_TRUE(sum(front.film.words, back.film.words) == whole.film.words);
}

TEST_F(Determinism, AStoppedRenderHoldsWholeSamplesOfTheFirstPixels) {
  RenderSettings waves = settings();
  waves.wave_paths = 1024;
  render::Renderer renderer(*device(), *cornell_, make_plan(*cornell_, waves));
  renderer.render([](uint64_t done, uint64_t) { return done < 4096; });
  const render::Film& film = renderer.film();
  ASSERT_GE(film.paths, 4096u);
  ASSERT_LT(film.paths, uint64_t{48} * 40 * 8);
  std::printf("stopped after %llu paths\n", static_cast<unsigned long long>(film.paths));

  // A render of just as many whole samples agrees wherever a pixel has that many.
  RenderSettings fewer = settings();
  fewer.samples = static_cast<uint32_t>(film.samples(0));
  const Rendered reference = render(*cornell_, fewer);
  for (uint64_t pixel = 0; pixel < uint64_t{48} * 40 && film.samples(pixel) == fewer.samples; ++pixel)
    ASSERT_TRUE(std::equal(film.words.begin() + pixel * interface::FILM_WORDS_PER_PIXEL,
                           film.words.begin() + (pixel + 1) * interface::FILM_WORDS_PER_PIXEL,
                           reference.film.words.begin() + pixel * interface::FILM_WORDS_PER_PIXEL))
        << "pixel " << pixel;
}

using namespace technique_sets;

// A floor under a lamp: few kernels, which take longer to compile than to run.
PreparedScene lamp_over_floor() {
  GltfScene scene;
  scene.add({quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2})}, lambert({0.5, 0.5, 0.5}));
  scene.add({quad({-0.5, 0.3, -0.5}, {1, 0, 0}, {0, 0, 1})}, emitter({10, 10, 10}, true));
  scene.set_perspective(look_at({0, 2, 0}, {0, 0, 0.001}), 1.0);
  return prepare(scene);
}

// With light subpaths that connect, merge and splat into the crop from everywhere.
TEST_F(Determinism, ACropHoldsThePixelsOfTheWhole) {
  const PreparedScene scene = lamp_over_floor();
  for (const uint32_t techniques : is_slow_device() ? std::vector{PT} : std::vector{PT, VCM}) {
    RenderSettings whole = settings();
    whole.samples = 2;
    whole.techniques = techniques;
    whole.merge_radius = 0.1f;
    whole.shadow_roulette = techniques == VCM ? 0.1f : 0;
    RenderSettings part = whole;
    part.crop = {17, 5, 20, 30};
    const Rendered reference = render(scene, whole), cropped = render(scene, part);
    ASSERT_EQ(cropped.image.width, 20u);
    ASSERT_EQ(cropped.image.height, 30u);
    size_t lit = 0;
    for (uint32_t y = 0; y < 30; ++y)
      for (uint32_t i = 0; i < 3 * 20; ++i) {
        const float value = cropped.image.rgb[y * 3 * 20 + i];
        ASSERT_EQ(value, reference.image.rgb[((y + 5) * 48 + 17) * 3 + i]) << "techniques " << techniques;
        lit += value > 0;
      }
    EXPECT_GT(lit, 1000u);
  }
}

// Stopped in the middle of a sample or of its light paths, and gone on with by another renderer. A wave holds
// 512 paths of the 1920 pixels and 6000 light paths.
TEST_F(Determinism, AResumedRenderIsTheUninterruptedOne) {
  struct Case {
    uint32_t techniques, aovs;
    uint64_t waves;  // after which it is stopped, preparations counted; two are on their way
  };
  const Case pt{PT, render::AOV_VARIANCE, 5}, lt{interface::TECHNIQUE_SPLAT, 0, 15},
      vcm_in_light{VCM, render::AOV_VARIANCE, 17 + 5}, vcm_in_camera{VCM, render::AOV_VARIANCE, 17 + 13 + 1};
  const PreparedScene scene = lamp_over_floor();
  for (const Case& each :
       is_slow_device() ? std::vector{pt} : std::vector{pt, lt, vcm_in_light, vcm_in_camera}) {
    RenderSettings settings = Determinism::settings();
    settings.samples = 3;
    settings.techniques = each.techniques;
    settings.aovs = each.aovs;
    settings.merge_radius = 0.1f;
    settings.wave_paths = 512;
    settings.light_paths = 6000;
    const Rendered whole = render(scene, settings);

    render::Renderer first(*device(), scene, make_plan(scene, settings));
    uint64_t waves = 0;
    first.render([&](uint64_t, uint64_t) { return ++waves < each.waves; });
    const render::Film state = first.film();
    std::printf("techniques %u stopped after %llu paths, %llu light paths\n", each.techniques,
                static_cast<unsigned long long>(state.paths),
                static_cast<unsigned long long>(state.light_paths));
    EXPECT_TRUE(state.paths % (48 * 40) != 0 || state.light_paths % *settings.light_paths != 0)
        << "no mid-sample";
    render::Renderer second(*device(), scene, make_plan(scene, settings));
    second.resume(state);
    second.render([](uint64_t, uint64_t) { return true; });
    EXPECT_EQ(second.film().paths, whole.film.paths);
    EXPECT_EQ(second.film().light_paths, whole.film.light_paths);
    EXPECT_TRUE(second.film().words == whole.film.words);
    EXPECT_TRUE(second.film().splat_words == whole.film.splat_words);
    EXPECT_TRUE(second.film().square_words == whole.film.square_words);
    EXPECT_TRUE(second.film().earlier_words == whole.film.earlier_words);
  }
}

}  // namespace
}  // namespace regulus::test
