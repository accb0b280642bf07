// Layers of materials in frames whose radiance is known.
#include <cmath>
#include <functional>
#include <string>

#include "renderer/scene/transform.hpp"
#include "tests/frame/closed_form.hpp"

namespace furnace {
namespace {

struct LayerCase {
  std::string name;
  std::function<void(MaterialOverride&, float)> put;  // over a white material, with a roughness
};

class LayeredFurnace : public ClosedFormGlTest, public testing::WithParamInterface<LayerCase> {};

// Whatever lies over what: in light of radiance 1 from everywhere a white surface that loses nothing vanishes. The bar is 0.5 %
// on every pixel.
TEST_P(LayeredFurnace, TheSphereVanishes) {
  for (int i = 0; i <= 9; ++i) {
    const float roughness = float(i) / 9;
    MaterialOverride material;
    material.base_color = glm::vec4(1);
    material.metallic = 0.f;
    material.perceptual_roughness = 0.4f;
    GetParam().put(material, roughness);
    const Film film = render(spec_of("sphere", material, glm::vec3(1)));
    for (const float sample : film.image.samples<float>()) ASSERT_NEAR(sample, 1, 5e-3) << roughness;
  }
}

const LayerCase kLayers[] = {
    {"Specular",
     [](MaterialOverride& m, float r) {
       m.perceptual_roughness = r;
       m.specular = 0.5f;
       m.ior = 2.f;
     }},
    {"Clearcoat",
     [](MaterialOverride& m, float r) {
       m.clearcoat = 1.f;
       m.clearcoat_perceptual_roughness = r;
     }},
    {"ClearcoatOverMetal",
     [](MaterialOverride& m, float r) {
       m.metallic = 1.f;
       m.clearcoat = 0.7f;
       m.clearcoat_perceptual_roughness = r;
     }},
    {"Sheen",
     [](MaterialOverride& m, float r) {
       m.sheen_color = glm::vec3(1);
       m.sheen_perceptual_roughness = r;
     }},
    {"AnisotropicMetal",
     [](MaterialOverride& m, float r) {
       m.metallic = 1.f;
       m.perceptual_roughness = r;
       m.anisotropy = 0.8f;
     }},
    {"AnisotropicDielectric",
     [](MaterialOverride& m, float r) {
       m.perceptual_roughness = r;
       m.anisotropy = 1.f;
     }},
    {"DiffuseTransmission",
     [](MaterialOverride& m, float r) {
       m.perceptual_roughness = r;
       m.diffuse_transmission = 0.6f;
     }},
    {"Transmission",
     [](MaterialOverride& m, float r) {
       m.perceptual_roughness = r;
       m.transmission = 1.f;
     }},
    {"VolumeWithDispersion",
     [](MaterialOverride& m, float r) {
       m.perceptual_roughness = r;
       m.transmission = 0.8f;
       m.thickness_m = 0.5f;
       m.dispersion = 1.f;
     }},
    {"AllOverOneAnother",
     [](MaterialOverride& m, float r) {
       m.perceptual_roughness = r;
       m.clearcoat = 0.5f;
       m.sheen_color = glm::vec3(0.5f);
       m.sheen_perceptual_roughness = 0.5f;
       m.transmission = 0.3f;
       m.diffuse_transmission = 0.3f;
       m.anisotropy = 0.5f;
     }},
};
INSTANTIATE_TEST_SUITE_P(Each, LayeredFurnace, testing::ValuesIn(kLayers),
                         [](const auto& row) { return row.param.name; });

// A pane across the view, seen at right angles; `behind` a second one of a plain colour, if it is to have one.
class LayersGlTest : public ClosedFormGlTest {
 protected:
  static RenderSpec pane(const MaterialOverride& material, float radiance) {
    RenderSpec spec = spec_of("plane", material, glm::vec3(radiance));
    spec.camera.view = LookAtCamera{{0, 1, 0}, {0, 0, 0}, {0, 0, -1}, 0.3};
    return spec;
  }
  static void put_behind(RenderSpec& spec, glm::vec3 color) {
    NodeSpec node;
    node.mesh = "plane";
    node.material = "behind";
    node.translation = {0, -0.2f, 0};
    spec.scene.nodes.push_back(node);
    MaterialOverride plain;
    plain.base_color = glm::vec4(color, 1);
    plain.unlit = true;
    spec.scene.materials["behind"] = plain;
  }
  static MaterialOverride glass() {
    MaterialOverride material;
    material.base_color = glm::vec4(1);
    material.metallic = 0.f;
    material.perceptual_roughness = 0.f;
    material.transmission = 1.f;
    material.double_sided = true;
    return material;
  }
};

TEST_F(LayersGlTest, APaneLetsThroughWhatItDoesNotReflect) {
  MaterialOverride material = glass();
  material.base_color = glm::vec4(0.5f, 1, 1, 1);
  RenderSpec spec = pane(material, 0);
  put_behind(spec, {0.8f, 0.4f, 0.2f});
  const glm::vec3 center = pixel(render(spec), 32, 32);
  // F0 of index of refraction 1.5 is 0.04.
  EXPECT_NEAR(center.r, 0.96 * 0.5 * 0.8, 2e-3);
  EXPECT_NEAR(center.g, 0.96 * 0.4, 2e-3);
  EXPECT_NEAR(center.b, 0.96 * 0.2, 2e-3);
}

TEST_F(LayersGlTest, AVolumeAbsorbsByBeersLaw) {
  MaterialOverride material = glass();
  material.thickness_m = 0.1f;
  material.attenuation_distance_m = 0.05f;
  material.attenuation_color = glm::vec3(0.5f, 0.9f, 1);
  RenderSpec spec = pane(material, 0);
  put_behind(spec, glm::vec3(1));
  const glm::vec3 center = pixel(render(spec), 32, 32);
  EXPECT_NEAR(center.r, 0.96 * 0.25, 2e-3);
  EXPECT_NEAR(center.g, 0.96 * 0.81, 2e-3);
  EXPECT_NEAR(center.b, 0.96, 2e-3);
}

// What lets the page be seen has so little alpha: laid over a colour, the transparent picture is the one with that background.
TEST_F(LayersGlTest, TransparentGlassLaidOverAColourIsThatOfTheColour) {
  for (const float thickness_m : {0.f, 0.3f}) {
    MaterialOverride material = glass();
    material.base_color = glm::vec4(0.7f, 0.7f, 0.7f, 1);
    material.perceptual_roughness = 0.3f;
    material.thickness_m = thickness_m;
    RenderSpec spec = spec_of("sphere", material, glm::vec3(0.6f));
    put_behind(spec, {0.1f, 0.3f, 0.5f});
    spec.environment.background = TransparentBackground{};
    const Film over_nothing = render(spec);
    const float color = 0.4f;
    spec.environment.background = ColorBackground{glm::vec3(color)};
    const Film over_color = render(spec);
    const auto a = over_nothing.image.samples<float>(), b = over_color.image.samples<float>();
    ASSERT_EQ(over_nothing.image.channels, 4);
    const auto channels = std::size_t(over_color.image.channels);
    bool seen = false;
    for (std::size_t i = 0; i < a.size() / 4; ++i) {
      seen = seen || (a[4 * i + 3] > 0.05f && a[4 * i + 3] < 0.6f);
      for (std::size_t c = 0; c < 3; ++c)
        ASSERT_NEAR(a[4 * i + c] + (1 - a[4 * i + 3]) * color, b[channels * i + c], 2e-3) << i;
    }
    EXPECT_TRUE(seen);
  }
}

TEST_F(LayersGlTest, ALeafIsLitFromBehind) {
  MaterialOverride material;
  material.base_color = glm::vec4(0, 0, 0, 1);
  material.metallic = 0.f;
  material.perceptual_roughness = 1.f;
  material.double_sided = true;
  material.diffuse_transmission = 1.f;
  material.diffuse_transmission_color = glm::vec3(0.2f, 0.8f, 0.1f);
  RenderSpec spec = pane(material, 0);
  Light light;
  light.kind = LightKind::kDirectional;
  light.direction = {0, 1, 0};  // from below
  light.intensity = glm::dvec3(kPi);
  light.casts_shadow = false;
  spec.scene.lights = {light};
  const glm::vec3 center = pixel(render(spec), 32, 32);
  // What a Lambert surface of that colour would send back, less what the surface reflects at roughness 1.
  EXPECT_GT(center.g, 0.8 * 0.94);
  EXPECT_LT(center.g, 0.8);
  EXPECT_NEAR(center.r / center.g, 0.25, 1e-3);
}

TEST_F(LayersGlTest, ASpecularColourSetsF0) {
  MaterialOverride material;
  material.base_color = glm::vec4(0, 0, 0, 1);
  material.metallic = 0.f;
  material.perceptual_roughness = 0.f;
  material.specular_color = glm::vec3(10, 20, 0);  // F0 0.4, 0.8, 0
  const glm::vec3 center = pixel(render(pane(material, 1)), 32, 32);
  EXPECT_NEAR(center.r, 0.4, 5e-3);
  EXPECT_NEAR(center.g, 0.8, 5e-3);
  EXPECT_NEAR(center.b, 0, 5e-3);
}

// Above is light, below dark: through a ball up is down, through a pane it is not.
TEST_F(LayersGlTest, ABallTurnsItsViewOverAndAPaneDoesNot) {
  MaterialOverride material = glass();
  material.double_sided = false;
  material.thickness_m = 1.f;
  RenderSpec spec = spec_of("sphere", material, glm::vec3(0));
  spec.environment.map =
      GradientEnvironment{{{-1, glm::dvec3(0)}, {1, glm::dvec3(1)}}, GradientBlend::kLinear};
  spec.environment.background = EnvironmentBackground{};
  OrbitCamera level;
  level.azimuth_rad = level.elevation_rad = 0;
  spec.camera.view = level;
  const Film ball = render(spec);
  EXPECT_LT(pixel(ball, 32, 24).g, 0.3f);
  EXPECT_GT(pixel(ball, 32, 40).g, 0.7f);

  spec.scene.nodes[0].mesh = "cube";
  material.thickness_m = 0.01f;
  spec.scene.materials[*spec.scene.nodes[0].material] = material;
  const Film pane = render(spec);
  EXPECT_GT(pixel(pane, 32, 24).g, 0.7f);
  EXPECT_LT(pixel(pane, 32, 40).g, 0.3f);
}

// Anisotropy of almost nothing is a surface of almost none.
TEST_F(LayersGlTest, AnisotropySetsInSmoothly) {
  MaterialOverride material;
  material.base_color = glm::vec4(1);
  material.metallic = 1.f;
  for (const float roughness : {0.3f, 0.6f, 0.9f}) {
    material.perceptual_roughness = roughness;
    const auto row = [&](float anisotropy) {
      material.anisotropy = anisotropy;
      RenderSpec spec = spec_of("sphere", material, glm::vec3(0));
      spec.environment.map = BuiltinName{"studio"};
      return render(spec);
    };
    const Film round = row(0), nearly = row(1e-3f);
    for (int x = 12; x < 52; x += 4)
      EXPECT_NEAR(pixel(nearly, x, 28).g, pixel(round, x, 28).g, 0.02f * pixel(round, x, 28).g) << roughness;
  }
}

// A texture may leave a mirror no anisotropy at all; so does a strength whose square is 0.
TEST_F(LayersGlTest, AMirrorWithoutWidthShowsALight) {
  MaterialOverride material;
  material.metallic = 1.f;
  material.perceptual_roughness = 0.f;
  material.anisotropy = 1e-30f;
  RenderSpec spec = spec_of("plane", material, glm::vec3(0.5f));
  OrbitCamera above;
  above.elevation_rad = kPi / 2;
  above.azimuth_rad = 0;
  above.orthographic = true;
  spec.camera.view = above;
  Light light;  // so that every pixel's half vector is the normal
  light.kind = LightKind::kDirectional;
  light.direction = {0, -1, 0};
  spec.scene.lights = {light};
  // Not a number would become black.
  EXPECT_GT(pixel(render(spec), 32, 32).g, 1e3f);
}

}  // namespace
}  // namespace furnace
