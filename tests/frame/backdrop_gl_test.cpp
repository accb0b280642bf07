// Light, background and ground of an environment, where they are known in closed form.
#include <cmath>

#include "renderer/base/error.hpp"
#include "renderer/image/encode.hpp"
#include "renderer/scene/transform.hpp"
#include "tests/frame/closed_form.hpp"

namespace furnace {
namespace {

using BackdropGlTest = ClosedFormGlTest;

TEST_F(BackdropGlTest, IlluminanceCalibratesTheEnvironment) {
  MaterialOverride material;
  material.base_color = glm::vec4(1);
  material.metallic = 1.f;
  RenderSpec spec = spec_of("sphere", material, glm::vec3(0.25f));
  spec.environment.illuminance_lux = 1000;  // of a constant sky: pi times its luminance
  EXPECT_NEAR(pixel(render(spec), 0, 0).g, 1000 / kPi, 1e-3 * 1000 / kPi);
  spec.environment.intensity = 2;
  EXPECT_NEAR(pixel(render(spec), 32, 32).g, 2000 / kPi, 5e-3 * 2000 / kPi);
  spec.environment.map = EnvironmentColor{glm::vec3(0)};
  EXPECT_THROW(render(spec), Error);
}

TEST_F(BackdropGlTest, AGradientRunsFromTopToBottomWhateverTheExposureAndTiles) {
  RenderSpec spec = spec_of("sphere", {}, glm::vec3(1));
  spec.environment.background = GradientBackground{{1, 0.5f, 0}, {0, 0.25f, 1}};
  spec.camera.exposure_ev = 2;
  spec.output.samples = 2;
  const Film film = render(spec);
  for (int y = 0; y < 64; ++y) {
    const float t = (float(y) + 0.5f) / 64;
    EXPECT_NEAR(pixel(film, 0, y).r, 1 - t, 1e-5);
    EXPECT_NEAR(pixel(film, 0, y).g, 0.5f - 0.25f * t, 1e-5);
  }
}

// A dim sky with a sun of 2 x 2 texels, 0.7 degrees each, 51 degrees high.
EnvironmentFile sky_with_sun() {
  Image sky = make_image({512, 256}, 3, SampleType::kFloat32, ColorSpace::kLinear);
  const std::span<float> samples(reinterpret_cast<float*>(sky.pixels.data()),
                                 sky.pixels.size() / sizeof(float));
  std::fill(samples.begin(), samples.end(), 0.5f);
  for (const int j : {55, 56}) {
    for (const int i : {380, 381}) {
      const std::size_t at = (std::size_t(j) * 512 + std::size_t(i)) * 3;
      samples[at] = 20000;
      samples[at + 1] = 18000;
      samples[at + 2] = 15000;
    }
  }
  return {Blob(encode_exr(sky, {}))};
}

class SunGlTest : public ClosedFormGlTest {
 protected:
  // Mean over the picture with the sun as a light, over that with the sun in the map, green.
  static double extracted_to_kept(const char* mesh, float metallic, float roughness) {
    MaterialOverride material;
    material.base_color = glm::vec4(0.8f, 0.8f, 0.8f, 1);
    material.metallic = metallic;
    material.perceptual_roughness = roughness;
    RenderSpec spec = spec_of(mesh, material, glm::vec3(0));
    spec.environment.map = sky_with_sun();
    spec.environment.background = ColorBackground{};
    spec.environment.rotation_rad = 0.4;
    double sums[2] = {};
    for (const bool extract : {false, true}) {
      spec.environment.sun = extract ? SunMode::kExtract : SunMode::kKeep;
      const auto film = render(spec);
      const auto samples = film.image.samples<float>();
      for (std::size_t i = 1; i < samples.size(); i += 3) sums[extract] += double(samples[i]);
    }
    return sums[1] / sums[0];
  }
};

TEST_F(SunGlTest, LightsADiffuseSurfaceAsItDidFromTheMap) {
  EXPECT_NEAR(extracted_to_kept("plane", 0, 1), 1,
              2e-2);  // seen at 15 degrees, where the rough gloss counts too
  EXPECT_NEAR(extracted_to_kept("sphere", 0, 1), 1, 5e-3);
}

// The split sum blurs the map by a round lobe where the light's own lobe is stretched: what they reflect in all agrees less
// well the rougher and the more grazing.
TEST_F(SunGlTest, IsReflectedWithTheSameLight) {
  EXPECT_NEAR(extracted_to_kept("sphere", 1, 0.1f), 1, 0.03);
  EXPECT_NEAR(extracted_to_kept("sphere", 1, 0.3f), 1, 0.03);
  EXPECT_NEAR(extracted_to_kept("sphere", 1, 0.6f), 1, 0.05);
  EXPECT_NEAR(extracted_to_kept("sphere", 1, 1), 1, 0.08);
}

TEST_F(SunGlTest, StaysInTheBackground) {
  RenderSpec spec = spec_of("sphere", {}, glm::vec3(0));
  spec.environment.map = sky_with_sun();
  spec.environment.sun = SunMode::kExtract;
  // Towards the sun: u = 381 / 512, v = 56 / 256.
  const double phi = 2 * kPi * (381.0 / 512 - 0.5), theta = kPi * 56 / 256;
  const glm::vec3 towards(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
  spec.camera.view = LookAtCamera{towards * 3.f, towards * 6.f, {0, 1, 0}, 0.02};
  EXPECT_GT(pixel(render(spec), 32, 32).r, 5000);
}

// A square plate over the ground under a constant sky takes the configuration factor of the plate, seen from the ground, off
// its light: Howell, "A Catalog of Radiation Heat Transfer Configuration Factors", B-4, four times its quarter.
double plate_factor(double half_side, double height) {
  const double a = half_side / height, root = std::sqrt(1 + a * a);
  return 4 / kPi * a / root * std::atan(a / root);
}

class GroundGlTest : public ClosedFormGlTest {
 protected:
  static constexpr float kHeight = 0.5f, kLevel = -0.5f;

  static RenderSpec plate_over_ground() {
    RenderSpec spec = spec_of("plane", {}, glm::vec3(1));  // 1 m x 1 m at y = 0
    spec.environment.background = TransparentBackground{};
    spec.environment.ground = GroundSpec{};
    spec.environment.ground->level_m = kLevel;
    spec.camera.view = LookAtCamera{{3, -0.1f, 0}, {0, kLevel, 0}, {0, 1, 0}, 0.2};
    return spec;
  }
  static double alpha_in_the_middle(const Film& film) {
    EXPECT_EQ(film.image.channels, 4);
    const auto samples = film.image.samples<float>();
    double sum = 0;
    for (const int at : {31 * 64 + 31, 31 * 64 + 32, 32 * 64 + 31, 32 * 64 + 32})
      sum += samples[std::size_t(at) * 4 + 3];
    return sum / 4;
  }
};

TEST_F(GroundGlTest, APlateTakesItsConfigurationFactor) {
  RenderSpec spec = plate_over_ground();
  const double expected = plate_factor(0.5, kHeight);
  // 128 directions, then 1024: each is a hard shadow, so the error is about that of a quasi-random sum.
  EXPECT_NEAR(alpha_in_the_middle(render(spec)), expected, 2e-2);
  spec.output.samples = 32;
  EXPECT_NEAR(alpha_in_the_middle(render(spec)), expected, 5e-3);
  spec.output.samples = 1;
  spec.environment.ground->shadow_strength = 0.5;
  EXPECT_NEAR(alpha_in_the_middle(render(spec)), 0.5 * expected, 1e-2);
  spec.environment.ground->shadow = false;
  EXPECT_EQ(alpha_in_the_middle(render(spec)), 0);
}

TEST_F(GroundGlTest, ParallelRaysSeeTheSamePlace) {
  RenderSpec spec = plate_over_ground();
  OrbitCamera orbit;
  orbit.azimuth_rad = 1.2;
  orbit.elevation_rad = 0.35;
  orbit.fit = 2;
  spec.camera.view = orbit;
  const Film perspective = render(spec);
  orbit.fov_y_rad = 0.01;  // from far away
  spec.camera.view = orbit;
  const Film far = render(spec);
  orbit.orthographic = true;
  spec.camera.view = orbit;
  const Film parallel = render(spec);
  double difference = 0, shadow = 0;
  for (std::size_t i = 3; i < std::size_t(64 * 64 * 4); i += 4) {
    difference += std::abs(double(parallel.image.samples<float>()[i]) - far.image.samples<float>()[i]);
    shadow += double(far.image.samples<float>()[i]);
  }
  EXPECT_GT(shadow, 100);
  EXPECT_LT(difference / shadow, 0.02);
}

TEST_F(GroundGlTest, HalfTransparentSurfacesCastHalf) {
  RenderSpec spec = plate_over_ground();
  spec.scene.materials["m"].base_color = glm::vec4(1, 1, 1, 0.5f);
  spec.scene.materials["m"].alpha_mode = AlphaMode::kBlend;
  spec.output.samples = 32;
  EXPECT_NEAR(alpha_in_the_middle(render(spec)), 0.5 * plate_factor(0.5, kHeight), 1e-2);
}

// A light that casts no shadow still reaches the ground; one of the scene counts against the environment's intensity, whatever
// was drawn before.
TEST_F(GroundGlTest, OtherLightsThinTheShadow) {
  RenderSpec spec = plate_over_ground();
  Light free;
  free.kind = LightKind::kDirectional;
  free.intensity = glm::dvec3(kPi);  // as much as the sky
  free.casts_shadow = false;
  spec.scene.lights = {free};
  const double factor = plate_factor(0.5, kHeight);
  EXPECT_NEAR(alpha_in_the_middle(render(spec)), factor / 2, 1e-2);
  spec.environment.intensity = 3;
  EXPECT_NEAR(alpha_in_the_middle(render(spec)), factor * 3 / 4, 2e-2);
  spec.scene.lights[0].casts_shadow = true;  // straight down onto the plate
  EXPECT_NEAR(alpha_in_the_middle(render(spec)), 1 - (1 - factor) * 3 / 4, 2e-2);
}

TEST_F(GroundGlTest, IsNotSeenFromBelow) {
  RenderSpec spec = plate_over_ground();
  spec.camera.view = LookAtCamera{{3, -1, 0}, {0, kLevel, 0}, {0, 1, 0}, 0.1};
  EXPECT_EQ(alpha_in_the_middle(render(spec)), 0);
}

// The shadow multiplies what is behind it, and leaves the rest alone.
TEST_F(GroundGlTest, DarkensTheBackground) {
  RenderSpec spec = plate_over_ground();
  spec.environment.background = ColorBackground{glm::vec3(0.5f)};
  const Film film = render(spec);
  EXPECT_NEAR(pixel(film, 32, 32).r, 0.5 * (1 - plate_factor(0.5, kHeight)), 1e-2);
  spec.environment.background = EnvironmentBackground{};
  spec.environment.ground->projection = GroundProjection{};
  EXPECT_NEAR(pixel(render(spec), 32, 32).r, 1 - plate_factor(0.5, kHeight), 2e-2);
}

}  // namespace
}  // namespace furnace
