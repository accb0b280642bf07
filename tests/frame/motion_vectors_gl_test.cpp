// How far pixels have moved, in closed form.
#include <algorithm>

#include "renderer/scene/sequence.hpp"
#include "tests/frame/moving_quad.hpp"

namespace furnace {
namespace {

constexpr double kShutterS = 0.25;

class MotionVectorsGlTest : public ClosedFormGlTest {
 protected:
  static RenderSpec vectors_spec(const GltfBuilder& builder, double shutter_s = kShutterS) {
    RenderSpec spec = moving_spec(builder, 1, shutter_s);
    spec.output.layers = {FilmLayer::kMotion};
    return spec;
  }
  static glm::vec2 motion(const Film& film, int x, int y) {
    const Image& image = film.layers.at(0).image;
    const std::size_t at = 2 * (std::size_t(y) * std::size_t(image.extent.width) + std::size_t(x));
    return {image.samples<float>()[at], image.samples<float>()[at + 1]};
  }
};

TEST_F(MotionVectorsGlTest, OfNodesMorphTargetsAndJoints) {
  for (const GltfBuilder& builder : {moving_quad(), morphing_quad(), skinned_quad()}) {
    const Film film = render(vectors_spec(builder));
    EXPECT_TRUE(film.notes.empty());
    for (const int x : {25, 32, 38}) {
      EXPECT_NEAR(motion(film, x, 32).x, kPxPerMetre * kShutterS, 1e-4);
      EXPECT_NEAR(motion(film, x, 32).y, 0, 1e-5);
    }
    EXPECT_EQ(motion(film, 5, 5), glm::vec2(0));
  }
}

// Upwards is negative, as rows grow downwards; what scales moves away from its middle.
TEST_F(MotionVectorsGlTest, PointRightAndDown) {
  GltfBuilder up = quad_builder();
  animate(up, {{"node", 0}, {"path", "translation"}}, "VEC3", {0, -1, 0, 0, 1, 0});
  EXPECT_NEAR(motion(render(vectors_spec(up)), 32, 32).y, -kPxPerMetre * kShutterS, 1e-4);

  GltfBuilder growing = quad_builder();
  animate(growing, {{"node", 0}, {"path", "scale"}}, "VEC3", {0, 0, 1, 2, 2, 1});
  const Film film = render(vectors_spec(growing));
  for (const int x : {26, 37}) {
    for (const int y : {25, 36}) {
      // A quarter of a second before it was 3/4 as large.
      EXPECT_NEAR(motion(film, x, y).x, (x - 31.5) * 0.25, 1e-4);
      EXPECT_NEAR(motion(film, x, y).y, (y - 31.5) * 0.25, 1e-4);
    }
  }
}

TEST_F(MotionVectorsGlTest, WhatStandsStillHasNone) {
  RenderSpec spec = vectors_spec(quad_builder());
  spec.scene.animations.clear();
  const Film film = render(spec);
  for (const float number : film.layers.at(0).image.samples<float>()) ASSERT_EQ(number, 0);

  // An animation that moves nothing else than another node.
  GltfBuilder builder = quad_builder();
  builder.add("nodes", Json::object());
  animate(builder, {{"node", 1}, {"path", "translation"}}, "VEC3", {-1, 0, 0, 1, 0, 0});
  const Film other = render(vectors_spec(builder));
  for (const float number : other.layers.at(0).image.samples<float>()) ASSERT_EQ(number, 0);
}

TEST_F(MotionVectorsGlTest, OfTheCameraToo) {
  GltfBuilder builder = quad_builder();
  builder.add("cameras",
              {{"type", "perspective"}, {"perspective", {{"yfov", 2 * std::atan(0.5)}, {"znear", 0.1}}}});
  builder.add("nodes", {{"camera", 0}});
  builder.add("scenes", {{"nodes", {0, 1}}});
  // It comes nearer: 4 m away now, a quarter of a metre more before.
  animate(builder, {{"node", 1}, {"path", "translation"}}, "VEC3", {0, 0, 5, 0, 0, 3});
  RenderSpec spec = vectors_spec(builder);
  spec.camera.view = GltfCamera{0};
  const Film film = render(spec);
  const double ndc_px = 36.5 - 32;
  EXPECT_NEAR(motion(film, 36, 32).x, ndc_px * (1 - 4 / 4.25), 1e-4);
}

// Without a shutter the frames of a sequence say how long the interval is; without both nothing does.
TEST_F(MotionVectorsGlTest, OfASequenceAreFromFrameToFrame) {
  RenderSpec spec = vectors_spec(moving_quad(), 0);
  spec.output.sequence.emplace().frames = 4;
  spec.output.sequence->frames_per_second = 8;
  const RenderSpec frame = frames_of(spec, 4)[1];
  EXPECT_NEAR(motion(render(frame), 34, 32).x, kPxPerMetre / 8, 1e-4);

  RenderSpec alone = vectors_spec(moving_quad(), 0);
  const Film film = render(alone);
  EXPECT_EQ(motion(film, 32, 32), glm::vec2(0));
  ASSERT_EQ(film.notes.size(), 1u);
  EXPECT_EQ(film.notes[0].code, "motion-needs-interval");
}

// The mean picture changes nothing in it, nor do tiles; a turntable's is that of its camera.
TEST_F(MotionVectorsGlTest, AreThoseOfTheMiddleWhateverTheSamples) {
  RenderSpec spec = vectors_spec(skinned_quad());
  const Film one = render(spec);
  spec.output.samples = 8;
  EXPECT_EQ(render(spec).layers.at(0).image.pixels, one.layers.at(0).image.pixels);
}

TEST_F(MotionVectorsGlTest, ShownTheyAreSixtyFourPixelsFromBlackToWhite) {
  RenderSpec spec = vectors_spec(moving_quad());
  spec.output.layers.clear();
  spec.output.shown = FilmLayer::kMotion;
  spec.output.format = OutputFormat::kPng;
  const Film film = render(spec);
  const auto samples = film.image.samples<std::uint8_t>();
  const std::size_t at = (32 * 64 + 32) * std::size_t(film.image.channels);
  // 4 px to the right: 1/2 + 4/64.
  EXPECT_EQ(samples[at], 143);
  EXPECT_EQ(samples[at + 1], 128);
}

}  // namespace
}  // namespace furnace
