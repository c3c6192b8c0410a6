// The image is a function of scene, settings and seed alone: not of waves, and not of how samples are
// grouped.
#include <gtest/gtest.h>

#include "images/support/render_scene.hpp"
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
  constexpr uint32_t BPT = interface::TECHNIQUE_HIT | interface::TECHNIQUE_NEE | interface::TECHNIQUE_SPLAT |
                           interface::TECHNIQUE_CONNECT;
  constexpr uint32_t VCM = BPT | interface::TECHNIQUE_MERGE;
  for (const auto& [techniques, cache_connections] : {std::pair(BPT, 0u), std::pair(VCM, 2u)}) {
    RenderSettings whole = settings();
    whole.samples = 3;
    whole.techniques = techniques;
    whole.cache_connections = cache_connections;
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
  render::Renderer renderer(*device(), cornell_->scene, cornell_->bvh, waves);
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

}  // namespace
}  // namespace regulus::test
