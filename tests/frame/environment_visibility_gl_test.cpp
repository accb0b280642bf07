// The environment's light and its shadows against a ray caster: what more samples converge to.
#include <cmath>

#include "renderer/compose.hpp"
#include "renderer/ibl/suns.hpp"
#include "renderer/scene/procedural.hpp"
#include "renderer/scene/transform.hpp"
#include "tests/frame/closed_form.hpp"
#include "tests/support/reference/direct_light.hpp"
#include "tests/support/reference/flip.hpp"

namespace furnace {
namespace {

using reference::Picture;

// FLIP's mean against the ray caster, from `high` quality on: design goal of the project.
constexpr double kBar = 0.02;

class EnvironmentVisibilityGlTest : public ClosedFormGlTest {
 protected:
  static MaterialOverride material(glm::vec3 color, float metallic, float roughness) {
    MaterialOverride m;
    m.base_color = glm::vec4(color, 1);
    m.metallic = metallic;
    m.perceptual_roughness = roughness;
    return m;
  }
  static RenderSpec spec_in(const char* environment) {
    RenderSpec spec;
    spec.environment.map = BuiltinName{environment};
    spec.environment.background = ColorBackground{};
    spec.output.width = spec.output.height = 64;
    spec.output.format = OutputFormat::kExr;
    spec.output.exr_type = SampleType::kFloat32;
    return spec;
  }
  static RenderSpec sphere_on_plane(const char* environment, float metallic, float roughness) {
    RenderSpec spec = spec_in(environment);
    spec.scene.nodes = {node("plane", "floor", {0, 0, 0}, 2.5f), node("sphere", "ball", {0, 0.5f, 0}, 1)};
    spec.scene.materials["floor"] = material(glm::vec3(0.7f), 0, 0.9f);
    spec.scene.materials["ball"] = material({0.9f, 0.5f, 0.3f}, metallic, roughness);
    return spec;
  }
  static RenderSpec pair_on_plane(const char* environment, const char* mesh,
                                  const MaterialOverride& surface) {
    RenderSpec spec = spec_in(environment);
    spec.scene.nodes = {node("plane", "floor", {0, 0, 0}, 3), node(mesh, "pair", {-0.52f, 0.5f, 0}, 1),
                        node(mesh, "pair", {0.52f, 0.4f, 0.1f}, 0.8f)};
    spec.scene.materials["floor"] = material(glm::vec3(0.5f), 0, 0.5f);
    spec.scene.materials["pair"] = surface;
    return spec;
  }
  // A box on the floor between two walls.
  static RenderSpec box_in_corner(const char* environment, float roughness) {
    RenderSpec spec = spec_in(environment);
    NodeSpec back = node("plane", "wall", {0, 1, -1}, 2), left = node("plane", "wall", {-1, 1, 0}, 2);
    back.rotation = glm::angleAxis(float(kPi / 2), glm::vec3(1, 0, 0));
    left.rotation = glm::angleAxis(float(-kPi / 2), glm::vec3(0, 0, 1));
    spec.scene.nodes = {node("plane", "wall", {0, 0, 0}, 2), back, left,
                        node("cube", "box", {-0.3f, 0.35f, -0.3f}, 0.7f)};
    spec.scene.materials["wall"] = material({0.8f, 0.75f, 0.7f}, 0, roughness);
    spec.scene.materials["box"] = material({0.9f, 0.8f, 0.6f}, 1, roughness);
    return spec;
  }
  static void add_lamp(RenderSpec& spec) {
    Light light;
    light.kind = LightKind::kDirectional;
    light.direction = glm::normalize(glm::dvec3(-1, -2, -0.7));
    light.intensity = glm::dvec3(1.5, 1.4, 1.2);
    spec.scene.lights = {light};
  }

  static glm::dvec3 vector_of(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }
  static Picture reference_of(const RenderSpec& spec) {
    const ComposedScene composed = compose_scene(spec.scene, nullptr);
    // As the renderer's, by default.
    const SunExtraction light =
        extract_suns(*builtin_environment(std::get<BuiltinName>(spec.environment.map).name), Deadline());
    std::vector<reference::DirectionalLight> lights;
    for (const Sun& sun : light.suns) lights.push_back({vector_of(sun.direction), vector_of(sun.irradiance)});
    for (const Light& light : spec.scene.lights) lights.push_back({-light.direction, light.intensity});
    const reference::DirectLight judge(composed.scene, light.residual, lights);
    Picture picture{{spec.output.width, spec.output.height}, {}};
    picture.pixels.resize(std::size_t(picture.extent.area()));
    const View view = make_view(spec.camera, composed.scene, picture.extent);
    WorkerPool pool(2);
    constexpr double kRowCostUs = 100'000;
    pool.parallel_for(std::size_t(picture.extent.height), kRowCostUs, [&](std::size_t y) {
      for (int x = 0; x < picture.extent.width; ++x)
        picture.pixels[y * std::size_t(picture.extent.width) + std::size_t(x)] =
            glm::clamp(judge.pixel(view, picture.extent, x, int(y)), 0.0, 1.0);
    });
    return picture;
  }
  static Picture drawn(RenderSpec spec, int samples) {
    spec.output.samples = samples;
    const Film film = render(spec);
    Picture picture{film.image.extent, {}};
    for (int y = 0; y < picture.extent.height; ++y) {
      for (int x = 0; x < picture.extent.width; ++x)
        picture.pixels.push_back(glm::clamp(glm::dvec3(pixel(film, x, y)), 0.0, 1.0));
    }
    return picture;
  }

  static void expect_convergence(RenderSpec spec) {
    const Picture judge = reference_of(spec);
    spec.environment.visibility = EnvironmentVisibility::kOff;
    const double without = reference::flip_mean(judge, drawn(spec, kVisibilitySamples));
    spec.environment.visibility = EnvironmentVisibility::kOn;
    double before = 1;
    for (const int samples : {1, 4, 16, 64, 256}) {
      const double now = reference::flip_mean(judge, drawn(spec, samples));
      RecordProperty(std::to_string(samples) + "-samples", std::to_string(now));
      if (samples >= kVisibilitySamples) {
        EXPECT_LE(now, kBar) << samples;
      }
      // The judge itself is uncertain by some thousandths.
      EXPECT_LT(now, before + 0.001) << samples;
      before = now;
    }
    EXPECT_GT(without, 2 * before);
  }
  static void expect_agreement(const RenderSpec& spec) {
    const double difference = reference::flip_mean(reference_of(spec), drawn(spec, kVisibilitySamples));
    RecordProperty("high", std::to_string(difference));
    EXPECT_LE(difference, kBar);
  }
};

TEST(Flip, OfEqualPicturesIsNothingAndOfBlackAndWhiteNearlyAll) {
  const Picture black{{16, 16}, std::vector<glm::dvec3>(256, glm::dvec3(0))};
  const Picture white{{16, 16}, std::vector<glm::dvec3>(256, glm::dvec3(1))};
  EXPECT_EQ(reference::flip_mean(white, white), 0);
  // By hand: 100^0.7 = 25.12 of at most 308.3^0.7 = 55.3.
  EXPECT_NEAR(reference::flip_mean(black, white), 0.967, 2e-3);
}

TEST_F(EnvironmentVisibilityGlTest, DielectricSphereOnAPlane) {
  expect_convergence(sphere_on_plane("overcast", 0, 0.4f));
}

TEST_F(EnvironmentVisibilityGlTest, MetalSphereInAStudio) {
  expect_convergence(sphere_on_plane("studio", 1, 0.35f));
}

TEST_F(EnvironmentVisibilityGlTest, BoxInACorner) {
  RenderSpec spec = box_in_corner("studio", 0.5f);
  add_lamp(spec);
  expect_convergence(spec);
}

TEST_F(EnvironmentVisibilityGlTest, MetalSpheresOfEachRoughness) {
  for (const float roughness : {0.2f, 0.4f, 0.6f, 0.8f, 1.f}) {
    SCOPED_TRACE(roughness);
    expect_agreement(pair_on_plane("studio", "sphere", material({0.95f, 0.9f, 0.8f}, 1, roughness)));
  }
}

TEST_F(EnvironmentVisibilityGlTest, SpheresUnderASun) {
  for (const float metallic : {0.f, 1.f}) {
    SCOPED_TRACE(metallic);
    expect_agreement(pair_on_plane("clear-sky", "sphere", material({0.6f, 0.5f, 0.4f}, metallic, 0.5f)));
  }
}

TEST_F(EnvironmentVisibilityGlTest, BoxesOnAPlane) {
  expect_agreement(pair_on_plane("studio", "cube", material({0.3f, 0.5f, 0.7f}, 0, 0.3f)));
  expect_agreement(pair_on_plane("overcast", "cube", material({0.9f, 0.8f, 0.6f}, 1, 0.6f)));
}

TEST_F(EnvironmentVisibilityGlTest, RoughBoxInACorner) {
  expect_agreement(box_in_corner("studio", 0.9f));
}

TEST_F(EnvironmentVisibilityGlTest, CoatedSpheres) {
  MaterialOverride coated = material({0.6f, 0.1f, 0.1f}, 0.5f, 0.8f);
  coated.clearcoat = 1;
  for (const float roughness : {0.25f, 0.6f}) {
    SCOPED_TRACE(roughness);
    coated.clearcoat_perceptual_roughness = roughness;
    expect_agreement(pair_on_plane("studio", "sphere", coated));
  }
}

// White furnace: what is convex and alone hides nothing from itself.
TEST_F(EnvironmentVisibilityGlTest, ALoneSphereVanishesInAWhiteRoom) {
  for (const float metallic : {0.f, 1.f}) {
    for (const float roughness : {0.1f, 0.3f, 0.5f, 0.7f, 1.f}) {
      RenderSpec spec = spec_in("furnace");
      spec.environment.visibility = EnvironmentVisibility::kOn;
      spec.environment.background = EnvironmentBackground{};
      spec.scene.nodes = {node("sphere", "ball", {0, 0, 0}, 1)};
      spec.scene.materials["ball"] = material(glm::vec3(1), metallic, roughness);
      spec.output.samples = kVisibilitySamples;
      const Film film = render(spec);
      double worst = 0;
      for (int y = 0; y < spec.output.height; ++y) {
        for (int x = 0; x < spec.output.width; ++x)
          worst = std::max(worst, double(std::abs(pixel(film, x, y).g - 1)));
      }
      EXPECT_LE(worst, 0.005) << metallic << " " << roughness;
    }
  }
}

// Nothing reflects specularly: no lobe to divide by.
TEST_F(EnvironmentVisibilityGlTest, SurfacesWithoutALobeKeepTheirDiffuseLight) {
  RenderSpec spec = sphere_on_plane("studio", 0, 0.5f);
  spec.scene.materials["ball"].specular = 0.f;
  spec.output.samples = kVisibilitySamples;
  spec.camera.view = LookAtCamera{{0, 0.5f, 4}, {0, 0.5f, 0}};
  const int middle = spec.output.width / 2;
  const Film film = render(spec);
  spec.environment.visibility = EnvironmentVisibility::kOff;
  EXPECT_NEAR(pixel(film, middle, middle).r / pixel(render(spec), middle, middle).r, 0.9, 0.1);
}

}  // namespace
}  // namespace furnace
