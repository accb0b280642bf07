// Frames whose radiance is known in closed form.
#include <cmath>

#include <glm/gtc/quaternion.hpp>

#include "renderer/base/error.hpp"
#include "renderer/scene/transform.hpp"
#include "tests/frame/closed_form.hpp"

namespace furnace {
namespace {

struct FurnaceCase {
  float metallic, roughness;
};
class WhiteFurnace : public ClosedFormGlTest, public testing::WithParamInterface<FurnaceCase> {};

// Base colour 1 in an environment of radiance 1 reflects everything: the sphere vanishes. The bar is 0.5 % on every pixel.
TEST_P(WhiteFurnace, TheSphereVanishes) {
  MaterialOverride material;
  material.base_color = glm::vec4(1);
  material.metallic = GetParam().metallic;
  material.perceptual_roughness = GetParam().roughness;
  const Film film = render(spec_of("sphere", material, glm::vec3(1)));
  for (const float sample : film.image.samples<float>()) ASSERT_NEAR(sample, 1, 5e-3);
}

std::vector<FurnaceCase> furnace_cases() {
  std::vector<FurnaceCase> cases;
  for (const float metallic : {0.f, 0.5f, 1.f}) {
    for (int i = 0; i <= 10; ++i) cases.push_back({metallic, float(i) / 10});
  }
  return cases;
}
INSTANTIATE_TEST_SUITE_P(MetallicAndRoughness, WhiteFurnace, testing::ValuesIn(furnace_cases()));

// A Lambert plane in constant radiance L: outgoing radiance albedo * L for the diffuse part, plus at normal incidence
// F0 = 0.04 of the specular; at most their sum, at least the diffuse part.
TEST_F(ClosedFormGlTest, RoughDielectricPlaneReflectsItsAlbedo) {
  MaterialOverride material;
  material.base_color = glm::vec4(0.5f, 0.25f, 0, 1);
  material.metallic = 0.f;
  material.perceptual_roughness = 1.f;
  RenderSpec spec = spec_of("plane", material, glm::vec3(2));
  spec.camera.view = LookAtCamera{{0, 1, 0}, {0, 0, 0}, {0, 0, -1}, 0.5};
  const glm::vec3 center = pixel(render(spec), 32, 32);
  // The specular albedo s of the lobe appears alone in the black channel; the others are s + (1 - s) * albedo.
  const double s = double(center.b) / 2;
  EXPECT_GT(s, 0.01);  // F0 = 0.04 less what single scattering loses at roughness 1
  EXPECT_LT(s, 0.04);
  EXPECT_NEAR(center.r / 2, s + (1 - s) * 0.5, 1e-3);
  EXPECT_NEAR(center.g / 2, s + (1 - s) * 0.25, 1e-3);
}

TEST_F(ClosedFormGlTest, UnlitIsItsColourWhateverTheLight) {
  MaterialOverride material;
  material.base_color = glm::vec4(0.125f, 0.5f, 0.75f, 1);
  material.unlit = true;
  const Film film = render(spec_of("sphere", material, glm::vec3(7)));
  EXPECT_EQ(pixel(film, 32, 32), glm::vec3(0.125f, 0.5f, 0.75f));
}

TEST_F(ClosedFormGlTest, EmissionAddsItsStrength) {
  MaterialOverride material;
  material.base_color = glm::vec4(0, 0, 0, 1);
  material.metallic = 1.f;  // black metal: reflects only the grazing Fresnel rise
  material.perceptual_roughness = 1.f;
  material.emissive = glm::vec3(1, 0.5f, 0.25f);
  material.emissive_strength = 8.f;
  const glm::vec3 center = pixel(render(spec_of("sphere", material, glm::vec3(0))), 32, 32);
  EXPECT_EQ(center, glm::vec3(8, 4, 2));
}

TEST_F(ClosedFormGlTest, ExposureIsAPowerOfTwo) {
  MaterialOverride material;
  material.base_color = glm::vec4(0.25f, 0.25f, 0.25f, 1);
  material.unlit = true;
  RenderSpec spec = spec_of("sphere", material, glm::vec3(1));
  spec.camera.exposure_ev = 3;
  EXPECT_EQ(pixel(render(spec), 32, 32), glm::vec3(2));
}

// One radiance everywhere, told by two stops: what is baked for one description must not serve another.
TEST_F(ClosedFormGlTest, DescribedEnvironmentsAreToldApartByTheCaches) {
  RenderSpec spec = spec_of("sphere", {}, glm::vec3(0));
  for (const float radiance : {1.f, 2.f, 0.5f, 1.f}) {
    GradientEnvironment gradient;
    gradient.stops = {{-90, glm::dvec3(radiance)}, {90, glm::dvec3(radiance)}};
    spec.environment.map = ProceduralEnvironment(gradient);
    EXPECT_NEAR(pixel(render(spec), 1, 1).g, radiance, 1e-3f * radiance);
  }
}

TEST_F(ClosedFormGlTest, IntensityScalesLightAndBackground) {
  MaterialOverride material;
  material.base_color = glm::vec4(1);
  material.metallic = 1.f;
  RenderSpec spec = spec_of("sphere", material, glm::vec3(1));
  spec.environment.intensity = 3;
  const Film film = render(spec);
  EXPECT_NEAR(pixel(film, 0, 0).r, 3, 3 * 5e-3);
  EXPECT_NEAR(pixel(film, 32, 32).r, 3, 3 * 5e-3);
}

TEST_F(ClosedFormGlTest, SunsBeyondHalfFloatsSurvive) {
  MaterialOverride material;
  material.base_color = glm::vec4(1);
  material.metallic = 1.f;
  material.perceptual_roughness = 0.3f;
  constexpr float kSun = 222208;
  const Film film = render(spec_of("sphere", material, glm::vec3(kSun)));
  for (const float sample : film.image.samples<float>()) ASSERT_NEAR(sample / kSun, 1, 5e-3);
}

TEST_F(ClosedFormGlTest, HalfFilmOfASunIsFinite) {
  RenderSpec spec = spec_of("sphere", {}, glm::vec3(222208));
  spec.output.exr_type = SampleType::kFloat16;
  const Film film = render(spec);
  for (const std::uint16_t bits : film.image.samples<std::uint16_t>()) {
    ASSERT_TRUE(std::isfinite(float_from_half(bits)));
  }
}

TEST_F(ClosedFormGlTest, TransparentBackgroundIsEmptyAndTheObjectOpaque) {
  RenderSpec spec = spec_of("sphere", {}, glm::vec3(1));
  spec.environment.background = TransparentBackground{};
  const Film film = render(spec);
  ASSERT_EQ(film.image.channels, 4);
  const auto samples = film.image.samples<float>();
  EXPECT_EQ(samples[3], 0);
  EXPECT_EQ(samples[0], 0);
  EXPECT_EQ(samples[(32 * 64 + 32) * 4 + 3], 1);
}

// Two unlit layers: far one of alpha 1/2 over the background 1, near one of alpha 1/4 over that, whatever their order.
TEST_F(ClosedFormGlTest, BlendedLayersComposeBackToFront) {
  const auto layer = [](float red, float alpha) {
    MaterialOverride material;
    material.base_color = glm::vec4(red, 0, 0, alpha);
    material.unlit = true;
    material.alpha_mode = AlphaMode::kBlend;
    return material;
  };
  for (const bool reversed : {false, true}) {
    RenderSpec spec = spec_of("plane", layer(0.5f, 0.25f), glm::vec3(1));
    spec.scene.materials["far"] = layer(0.25f, 0.5f);
    NodeSpec far = spec.scene.nodes[0];
    far.material = "far";
    far.translation = {0, -1, 0};
    far.scale = glm::vec3(4);
    spec.scene.nodes.push_back(far);
    if (reversed) std::swap(spec.scene.nodes[0], spec.scene.nodes[1]);
    spec.camera.view = LookAtCamera{{0, 1, 0}, {0, 0, 0}, {0, 0, -1}, 0.5};
    const float behind = 0.25f * 0.5f + 1 * 0.5f;
    EXPECT_NEAR(pixel(render(spec), 32, 32).r, 0.5f * 0.25f + behind * 0.75f, 1e-6);
  }
}

// An edge takes the mean of four samples, and a whole one sees the true area. Turned by a little, it meets every phase of a
// pixel.
TEST_F(ClosedFormGlTest, EdgesAreSmoothAndOfTheRightArea) {
  MaterialOverride white;
  white.base_color = glm::vec4(1);
  white.unlit = true;
  RenderSpec spec = spec_of("plane", white, glm::vec3(0));
  NodeSpec& plane = spec.scene.nodes[0];
  plane.rotation = glm::angleAxis(glm::radians(7.f), glm::vec3(0, 1, 0));
  spec.camera.view = LookAtCamera{{0, 4, 0}, {0, 0, 0}, {0, 0, -1}, 2 * std::atan(0.5)};
  const Film film = render(spec);
  double sum = 0;
  int between = 0;
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      const float value = pixel(film, x, y).r;
      EXPECT_EQ(value * 4, std::round(value * 4));
      sum += value;
      between += value > 0 && value < 1;
    }
  }
  // The plane is 1 m wide; 4 m away the picture is 4 m high.
  EXPECT_NEAR(sum / (64 * 64), 1.0 / 16, 2e-4);
  EXPECT_GT(between, 30);
}

TEST_F(ClosedFormGlTest, NearerSurfacesHideFartherOnes) {
  MaterialOverride red, green;
  red.base_color = glm::vec4(1, 0, 0, 1);
  red.unlit = true;
  green.base_color = glm::vec4(0, 1, 0, 1);
  green.unlit = true;
  RenderSpec spec = spec_of("plane", red, glm::vec3(0));
  spec.scene.materials["below"] = green;
  NodeSpec below = spec.scene.nodes[0];
  below.material = "below";
  below.translation = {0, -0.001f, 0};
  spec.scene.nodes.push_back(below);
  spec.camera.view = LookAtCamera{{0, 1, 0}, {0, 0, 0}, {0, 0, -1}, 0.5};
  EXPECT_EQ(pixel(render(spec), 32, 32), glm::vec3(1, 0, 0));
}

// Mirrored nodes turn their winding round: an outside stays an outside.
TEST_F(ClosedFormGlTest, NegativeScalesKeepTheirFrontFaces) {
  MaterialOverride material;
  material.base_color = glm::vec4(1, 0, 0, 1);
  material.unlit = true;
  RenderSpec spec = spec_of("plane", material, glm::vec3(0));
  spec.scene.nodes[0].scale = {-1, 1, 1};
  spec.camera.view = LookAtCamera{{0, 1, 0}, {0, 0, 0}, {0, 0, -1}, 0.5};
  EXPECT_EQ(pixel(render(spec), 32, 32), glm::vec3(1, 0, 0));
  // Its back is culled, unless it is double-sided.
  spec.camera.view = LookAtCamera{{0, -1, 0}, {0, 0, 0}, {0, 0, -1}, 0.5};
  EXPECT_EQ(pixel(render(spec), 32, 32), glm::vec3(0));
  spec.scene.materials["m"].double_sided = true;
  EXPECT_EQ(pixel(render(spec), 32, 32), glm::vec3(1, 0, 0));
}

TEST_F(ClosedFormGlTest, ThePictureStandsUpright) {
  MaterialOverride material;
  material.base_color = glm::vec4(1, 0, 0, 1);
  material.unlit = true;
  RenderSpec spec = spec_of("sphere", material, glm::vec3(0));
  spec.scene.nodes[0].translation = {1, 1, 0};
  spec.camera.view = LookAtCamera{{0, 0, 10}, {0, 0, 0}, {0, 1, 0}, 0.5};
  const Film film = render(spec);
  EXPECT_EQ(pixel(film, 44, 19), glm::vec3(1, 0, 0));  // up and to the right
  EXPECT_EQ(pixel(film, 44, 44), glm::vec3(0));
  EXPECT_EQ(pixel(film, 19, 19), glm::vec3(0));
}

TEST_F(ClosedFormGlTest, TheSameRequestGivesTheSamePixels) {
  RenderSpec spec;
  spec.output.width = 96;
  spec.output.height = 80;
  NodeSpec ball;
  ball.mesh = "shader-ball";
  ball.material = "gold";
  spec.scene.nodes = {ball};
  const Film first = render(spec), second = render(spec);
  EXPECT_EQ(first.image.pixels, second.image.pixels);
  EXPECT_TRUE(second.times.bake_hit);
  EXPECT_TRUE(second.times.upload_hit);
}

TEST_F(ClosedFormGlTest, MoreSubFramesConverge) {
  RenderSpec spec;
  spec.output.width = spec.output.height = 64;
  spec.output.format = OutputFormat::kExr;
  spec.output.exr_type = SampleType::kFloat32;
  NodeSpec torus;
  torus.mesh = "torus";
  torus.material = "chrome";
  spec.scene.nodes = {torus};
  const auto at = [&](int samples) {
    spec.output.samples = samples;
    return render(spec).image;
  };
  const Image reference = at(64);
  double previous = 1e9;
  for (const int samples : {1, 4, 16}) {
    const Image image = at(samples);
    double sum = 0;
    const auto a = image.samples<float>(), b = reference.samples<float>();
    for (std::size_t i = 0; i < a.size(); ++i) sum += double(a[i] - b[i]) * double(a[i] - b[i]);
    EXPECT_LT(sum, previous) << samples;
    previous = sum;
  }
}

TEST_F(ClosedFormGlTest, ADeadlineInThePastIsRefused) {
  try {
    renderer().render(spec_of("sphere", {}, glm::vec3(1)), Deadline(std::chrono::milliseconds(-1)));
    FAIL() << "rendered after its deadline";
  } catch (const Error& error) {
    EXPECT_EQ(error.code, ErrorCode::kDeadlineExceeded);
  }
}

TEST_F(ClosedFormGlTest, ProbeIsWhite) {
  EXPECT_TRUE(renderer().probe(Deadline()));
}

}  // namespace
}  // namespace furnace
