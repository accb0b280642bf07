// Bloom in whole pictures: energy, sizes, tiles, transparency, what emits.
#include <cmath>

#include "tests/frame/closed_form.hpp"

namespace furnace {
namespace {

class BloomGlTest : public ClosedFormGlTest {
 protected:
  // A glowing ball in the dark, a third of the picture wide.
  static RenderSpec ball(int side_px) {
    MaterialOverride bright;
    bright.base_color = glm::vec4(0, 0, 0, 1);
    bright.emissive = glm::vec3(8, 4, 2);
    RenderSpec spec = spec_of("sphere", bright, glm::vec3(0));
    spec.environment.background = ColorBackground{};
    spec.camera.view = LookAtCamera{{0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 0.7};
    spec.output.width = spec.output.height = side_px;
    return spec;
  }
  static Bloom& bloom_of(RenderSpec& spec) {
    Bloom& bloom = spec.output.bloom.emplace();
    bloom.intensity = 0.5;
    bloom.radius = 0.2;
    return bloom;
  }
  static glm::dvec3 sum_of(const Film& film) {
    glm::dvec3 sum(0);
    for (int y = 0; y < film.image.extent.height; ++y)
      for (int x = 0; x < film.image.extent.width; ++x) sum += glm::dvec3(pixel(film, x, y));
    return sum;
  }
  static float alpha(const Film& film, int x, int y) {
    return film.image.samples<float>()[std::size_t((y * film.image.extent.width + x) * 4 + 3)];
  }
};

TEST_F(BloomGlTest, WhatIsSpreadIsTakenFromWhereItWas) {
  for (const BloomSource source : {BloomSource::kAll, BloomSource::kEmission}) {
    for (const double threshold : {0.0, 1.0, 4.0}) {
      RenderSpec spec = ball(300);
      const Film plain = render(spec);
      Bloom& bloom = bloom_of(spec);
      bloom.source = source;
      bloom.threshold = threshold;
      const Film film = render(spec);
      const glm::dvec3 before = sum_of(plain), after = sum_of(film);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(after[c] / before[c], 1, 0.01) << threshold;
      EXPECT_EQ(pixel(plain, 60, 150), glm::vec3(0));
      const glm::vec3 glow = pixel(film, 60, 150);
      EXPECT_GT(glow.r, 0.02);
      EXPECT_NEAR(glow.g / glow.r, 0.5, 1e-3);  // of the ball's hue
      EXPECT_LT(pixel(film, 150, 150).r, 8);
    }
  }
}

TEST_F(BloomGlTest, NothingBrightNothingChanges) {
  RenderSpec spec = ball(64);
  const Film plain = render(spec);
  bloom_of(spec).threshold = 20;
  EXPECT_EQ(render(spec).image.pixels, plain.image.pixels);
}

TEST_F(BloomGlTest, AnEvenPictureStaysEven) {
  MaterialOverride mirror;
  mirror.base_color = glm::vec4(1);
  mirror.metallic = 1.f;
  RenderSpec spec = spec_of("sphere", mirror, glm::vec3(3));
  spec.output.width = 96;
  bloom_of(spec);
  const Film film = render(spec);
  for (const float value : film.image.samples<float>()) ASSERT_NEAR(value, 3, 0.02);  // the furnace itself
}

TEST_F(BloomGlTest, LargeAndSmallPicturesGlowAlike) {
  RenderSpec small = ball(128), large = ball(512);
  bloom_of(small);
  bloom_of(large);
  const Film coarse = render(small), fine = render(large);
  for (int y = 0; y < 128; ++y) {
    for (int x = 0; x < 128; ++x) {
      // The ball's edge is drawn as each size can.
      const double radius = std::hypot(x - 63.5, y - 63.5);
      if (radius > 19 && radius < 26) continue;
      glm::vec3 mean(0);
      for (int i = 0; i < 16; ++i) mean += pixel(fine, 4 * x + i % 4, 4 * y + i / 4) / 16.f;
      ASSERT_NEAR(pixel(coarse, x, y).r, mean.r, 0.005 + 0.01 * double(mean.r)) << x << " " << y;
    }
  }
}

TEST_F(BloomGlTest, TilesDoNotShow) {
  RenderSpec spec = ball(150);
  spec.output.samples = 2;
  bloom_of(spec);
  const Film whole = render(spec);
  WorkerPool pool(2);
  RendererConfig config;
  config.gl = {"software", gl::Determinism::kExact};
  config.max_tile_px = 64;
  Renderer tiled(config, pool, decode::in_process_decoder());
  const Film cut = tiled.render(spec, Deadline());
  const auto a = whole.image.samples<float>(), b = cut.image.samples<float>();
  for (std::size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], 1e-5f + 1e-5f * a[i]) << i;
}

// Over nothing the glow covers by its brightness: over black it is what it is, and straight colours can carry it.
TEST_F(BloomGlTest, GlowBeforeATransparentBackgroundHasAlpha) {
  RenderSpec spec = ball(128);
  spec.environment.background = TransparentBackground{};
  bloom_of(spec);
  const Film film = render(spec);
  for (const int x : {20, 28, 36}) {
    const float brightest = film.image.samples<float>()[std::size_t((64 * 128 + x) * 4)];
    EXPECT_GT(brightest, 0.01);
    EXPECT_NEAR(alpha(film, x, 64), std::min(brightest, 1.f), 1e-6) << x;
  }
  EXPECT_EQ(alpha(film, 64, 64), 1);
}

TEST_F(BloomGlTest, OnlyWhatEmitsGlowsWhereThatIsAsked) {
  RenderSpec spec = ball(128);
  const Film dark = render(spec);
  Bloom& bloom = bloom_of(spec);
  const glm::vec3 all = pixel(render(spec), 30, 64);
  bloom.source = BloomSource::kEmission;
  const glm::vec3 emitted = pixel(render(spec), 30, 64);
  EXPECT_NEAR(emitted.r, all.r, 1e-4);
  // A bright surrounding does not glow, nor does what is unlit.
  spec.environment.background = ColorBackground{glm::vec3(5)};
  EXPECT_NEAR(pixel(render(spec), 30, 64).r, 5 + emitted.r, 1e-4);
  MaterialOverride unlit;
  unlit.base_color = glm::vec4(1);
  unlit.unlit = true;
  spec.scene.materials["m"] = unlit;
  spec.environment.background = ColorBackground{};
  spec.camera.exposure_ev = 3;
  EXPECT_EQ(pixel(render(spec), 30, 64).r, 0);
  spec.output.bloom->source = BloomSource::kAll;
  EXPECT_GT(pixel(render(spec), 30, 64).r, 0.1);
}

// A blended surface that emits is part of it, as much as it covers.
TEST_F(BloomGlTest, VeilsEmitToo) {
  RenderSpec spec = ball(128);
  MaterialOverride& material = spec.scene.materials["m"];
  material.alpha_mode = AlphaMode::kBlend;
  material.base_color->a = 0.5f;
  bloom_of(spec).threshold = 0;
  const float all = pixel(render(spec), 30, 64).r;
  spec.output.bloom->source = BloomSource::kEmission;
  EXPECT_GT(all, 0.01);
  EXPECT_NEAR(pixel(render(spec), 30, 64).r, all, 2e-3 * double(all));  // half floats
}

}  // namespace
}  // namespace furnace
