// Exposure, grade and tone curve of whole pictures whose radiance is known.
#include <cmath>

#include "renderer/image/color.hpp"
#include "tests/frame/closed_form.hpp"

namespace furnace {
namespace {

class FilmGlTest : public ClosedFormGlTest {
 protected:
  // A mirror ball in a constant environment: every pixel is `radiance`.
  static RenderSpec furnace_of(glm::vec3 radiance) {
    MaterialOverride material;
    material.base_color = glm::vec4(1);
    material.metallic = 1.f;
    return spec_of("sphere", material, radiance);
  }
  static int byte_at(const Film& film, int x, int y, int channel) {
    const auto samples = film.image.samples<std::uint8_t>();
    return samples[(std::size_t(y) * std::size_t(film.image.extent.width) + std::size_t(x)) *
                       std::size_t(film.image.channels) +
                   std::size_t(channel)];
  }
};

TEST_F(FilmGlTest, PhysicalExposureIsOneAtSaturation) {
  RenderSpec spec = furnace_of(glm::vec3(1.2f * 1024));
  spec.camera.metering = PhysicalExposure{10};
  const Film film = render(spec);
  EXPECT_NEAR(pixel(film, 0, 0).g, 1, 5e-4);  // the environment is stored in half floats
  EXPECT_NEAR(film.exposure_ev, -10 - std::log2(1.2), 1e-12);
}

TEST_F(FilmGlTest, AutomaticExposureMakesItMidGrey) {
  for (const float radiance : {0.001f, 0.04f, 3.f, 40000.f}) {
    RenderSpec spec = furnace_of(glm::vec3(radiance));
    spec.camera.metering = AutoExposure{};
    spec.camera.exposure_ev = 1;
    const Film film = render(spec);
    EXPECT_NEAR(film.exposure_ev, std::log2(0.18 / double(radiance)) + 1, 0.006) << radiance;  // hundredths
    EXPECT_NEAR(pixel(film, 0, 0).g / 0.36f, 1, 5e-3) << radiance;
  }
}

TEST_F(FilmGlTest, TheStopsThatAreToldDrawTheSamePicture) {
  RenderSpec spec;
  NodeSpec ball;
  ball.mesh = "shader-ball";
  ball.material = "gold";
  spec.scene.nodes = {ball};
  spec.output.width = 80;
  spec.output.height = 50;
  spec.camera.metering = AutoExposure{};
  const Film chosen = render(spec);
  spec.camera.metering = UnmeteredExposure{};
  spec.camera.exposure_ev = chosen.exposure_ev;
  EXPECT_EQ(render(spec).image.pixels, chosen.image.pixels);
  spec.camera.exposure_ev += 0.01;
  EXPECT_NE(render(spec).image.pixels, chosen.image.pixels);
}

TEST_F(FilmGlTest, ABackgroundThatIsNoLightIsNotMetered) {
  RenderSpec spec = furnace_of(glm::vec3(0.02f));
  spec.camera.metering = AutoExposure{};
  const double whole = render(spec).exposure_ev;
  for (const float grey : {0.f, 0.5f, 100.f}) {
    spec.environment.background = ColorBackground{glm::vec3(grey)};
    const Film film = render(spec);
    EXPECT_EQ(film.exposure_ev, whole);
    EXPECT_NEAR(pixel(film, 0, 0).g, grey, 1e-4f * grey);  // as it is asked for, whatever the exposure
  }
  spec.environment.background = TransparentBackground{};
  EXPECT_EQ(render(spec).exposure_ev, whole);
}

TEST_F(FilmGlTest, ALampsLightIsBalancedInTheFile) {
  // Illuminant A: tests/frame/film_test.cpp.
  RenderSpec spec = furnace_of(glm::vec3(1.84517f, 0.82623f, 0.23332f));
  spec.output.grade.white_balance_kelvin = 2856;
  const glm::vec3 white = pixel(render(spec), 32, 32);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(white[c], 1, 1e-2);
  // A colour behind it is no light: it stays what it is.
  spec.environment.background = ColorBackground{{0.2f, 0.4f, 0.6f}};
  spec.output.grade.white_balance_tint = 20;
  const glm::vec3 behind = pixel(render(spec), 0, 0);
  EXPECT_NEAR(behind.r, 0.2, 1e-5);
  EXPECT_NEAR(behind.g, 0.4, 1e-5);
  EXPECT_NEAR(behind.b, 0.6, 1e-5);
}

TEST_F(FilmGlTest, ContrastIsOfExposedStraightColour) {
  RenderSpec spec = furnace_of(glm::vec3(0.18f));
  spec.camera.exposure_ev = 1;
  spec.output.grade.contrast = 2;
  EXPECT_NEAR(pixel(render(spec), 32, 32).g, 0.18 * 4, 5e-3);
  // A half transparent pixel of 0.36: 0.72 as well, premultiplied 0.36.
  MaterialOverride half;
  half.base_color = glm::vec4(0.18f, 0.18f, 0.18f, 0.5f);
  half.unlit = true;
  half.alpha_mode = AlphaMode::kBlend;
  spec.scene.nodes[0].mesh = "plane";
  spec.scene.materials["m"] = half;
  spec.camera.view = LookAtCamera{{0, 1, 0}, {0, 0, 0}, {0, 0, -1}, 1.5};
  spec.environment.background = TransparentBackground{};
  const Film film = render(spec);
  const auto samples = film.image.samples<float>();
  EXPECT_NEAR(samples[(32 * 64 + 32) * 4 + 1], 0.36, 2e-3);  // the veil's half floats
  EXPECT_EQ(samples[(32 * 64 + 32) * 4 + 3], 0.5f);
  EXPECT_EQ(samples[1], 0);
}

TEST_F(FilmGlTest, SixteenBitsRoundToTheSameEight) {
  RenderSpec spec;
  NodeSpec ball;
  ball.mesh = "shader-ball";
  ball.material = "gold";
  spec.scene.nodes = {ball};
  spec.output.width = spec.output.height = 48;
  const Film narrow = render(spec);
  spec.output.bit_depth = 16;
  const Film wide = render(spec);
  ASSERT_EQ(wide.image.type, SampleType::kUint16);
  ASSERT_EQ(wide.image.color_space, ColorSpace::kSrgb);
  const auto eight = narrow.image.samples<std::uint8_t>();
  const auto sixteen = wide.image.samples<std::uint16_t>();
  ASSERT_EQ(eight.size(), sixteen.size());
  bool finer = false;
  for (std::size_t i = 0; i < eight.size(); ++i) {
    ASSERT_NEAR(sixteen[i] / 257.0, eight[i], 0.51) << i;  // rounding, and that of the sixteen
    finer = finer || sixteen[i] % 257 != 0;
  }
  EXPECT_TRUE(finer);
}

// A dark gradient of a few steps: the mean of each row is what 16 bits hold, where rounding leaves bands half a step off.
TEST_F(FilmGlTest, DitherKeepsTheMean) {
  RenderSpec spec;
  NodeSpec ball;
  ball.mesh = "sphere";
  spec.scene.nodes = {ball};
  spec.camera.view = LookAtCamera{{0, 5, 0}, {0, 10, 0}, {0, 0, 1}, 0.5};  // away from it
  spec.environment.background =
      GradientBackground{glm::vec3(0.05f, 0.06f, 0.07f), glm::vec3(0.052f, 0.062f, 0.08f)};
  spec.output.width = spec.output.height = 64;
  spec.output.tone_map = ToneMap::kNone;
  spec.output.bit_depth = 16;
  const Film exact = render(spec);
  spec.output.bit_depth = 8;
  const auto worst_row = [&](const Film& film) {
    double worst = 0;
    for (int y = 0; y < 64; ++y) {
      for (int c = 0; c < 3; ++c) {
        double error = 0;
        for (int x = 0; x < 64; ++x) {
          const std::size_t at = std::size_t((y * 64 + x) * film.image.channels + c);
          const double difference =
              film.image.samples<std::uint8_t>()[at] - exact.image.samples<std::uint16_t>()[at] / 257.0;
          EXPECT_LT(std::abs(difference), 1.01);
          error += difference / 64;
        }
        worst = std::max(worst, std::abs(error));
      }
    }
    return worst;
  };
  EXPECT_GT(worst_row(render(spec)), 0.4);
  spec.output.dither = true;
  const Film dithered = render(spec);
  EXPECT_LT(worst_row(dithered), 0.06);
  EXPECT_EQ(render(spec).image.pixels, dithered.image.pixels);
}

TEST_F(FilmGlTest, DitherLeavesWhatEightBitsHoldAndTilesTheSame) {
  RenderSpec spec;
  spec.output.width = spec.output.height = 64;
  NodeSpec ball;
  ball.mesh = "sphere";
  spec.scene.nodes = {ball};
  spec.camera.view = LookAtCamera{{0, 5, 0}, {0, 10, 0}, {0, 0, 1}, 0.5};
  spec.output.tone_map = ToneMap::kNone;
  spec.output.dither = true;
  for (const int code : {0, 1, 64, 200, 254, 255}) {
    const float linear = linear_from_srgb(float(code) / 255);
    spec.environment.background = ColorBackground{glm::vec3(linear)};
    const Film film = render(spec);
    for (int i = 0; i < 64; ++i) ASSERT_EQ(byte_at(film, i, 63 - i, i % 3), code);
  }
  // The pattern is the picture's, not the tile's.
  spec.environment.background = ColorBackground{glm::vec3(0.3f)};
  WorkerPool pool(2);
  RendererConfig config;
  config.gl = {"software", gl::Determinism::kExact};
  config.max_tile_px = 40;
  Renderer tiled(config, pool, decode::in_process_decoder());
  EXPECT_EQ(tiled.render(spec, Deadline()).image.pixels, render(spec).image.pixels);
  spec.environment.background = TransparentBackground{};
  const Film empty = render(spec);
  for (const std::uint8_t sample : empty.image.samples<std::uint8_t>()) ASSERT_EQ(sample, 0);
}

TEST_F(FilmGlTest, EachCurveIsItsOwn) {
  RenderSpec spec = furnace_of(glm::vec3(0.18f));
  spec.output.format = OutputFormat::kPng;
  const auto grey = [&](ToneMap curve) {
    spec.output.tone_map = curve;
    return byte_at(render(spec), 32, 32, 1);
  };
  const auto encoded = [](double linear) { return 255 * srgb_from_linear(linear); };
  EXPECT_NEAR(grey(ToneMap::kLinear), encoded(0.18), 1);
  EXPECT_NEAR(grey(ToneMap::kReinhard), encoded(0.18 / 1.18), 1);
  EXPECT_NEAR(grey(ToneMap::kPbrNeutral), encoded(0.14), 1);
  EXPECT_NEAR(grey(ToneMap::kAgx), encoded(std::pow(0.4967, 2.2)), 1);  // Wrensch's polynomial at log2(0.18)
  // Hill's fit of 0.3: (0.0974 - 0) / (0.0885 + 0.1299 + 0.2381).
  EXPECT_NEAR(
      grey(ToneMap::kAces),
      encoded((0.3 * (0.3 + 0.0245786) - 0.000090537) / (0.3 * (0.983729 * 0.3 + 0.4329510) + 0.238081)), 1);
}

}  // namespace
}  // namespace furnace
