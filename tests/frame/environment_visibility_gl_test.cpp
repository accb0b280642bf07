// The environment's light and its shadows against a ray caster: what more samples converge to.
#include <cmath>
#include <fstream>

#include "renderer/compose.hpp"
#include "renderer/scene/procedural.hpp"
#include "renderer/scene/transform.hpp"
#include "tests/frame/closed_form.hpp"
#include "tests/support/reference/direct_light.hpp"
#include "tests/support/reference/flip.hpp"

namespace furnace {
namespace {

using reference::Picture;

class EnvironmentVisibilityGlTest : public ClosedFormGlTest {
 protected:
  static MaterialOverride material(glm::vec3 color, float metallic, float roughness) {
    MaterialOverride m;
    m.base_color = glm::vec4(color, 1);
    m.metallic = metallic;
    m.perceptual_roughness = roughness;
    return m;
  }
  static NodeSpec node(const char* mesh, const char* material, glm::vec3 at, float scale) {
    NodeSpec n;
    n.mesh = mesh;
    n.material = material;
    n.translation = at;
    n.scale = glm::vec3(scale);
    return n;
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

  static Picture reference_of(const RenderSpec& spec) {
    const ComposedScene composed = compose_scene(spec.scene, nullptr);
    const Image map = *builtin_environment(std::get<BuiltinName>(spec.environment.map).name);
    std::vector<reference::DirectionalLight> lights;
    for (const Light& light : spec.scene.lights) lights.push_back({-light.direction, light.intensity});
    const reference::DirectLight judge(composed.scene, map, lights);
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

  static void dump(const Picture& p, const std::string& name) {
    std::ofstream f("/tmp/vd/" + name + ".pic", std::ios::binary);
    f.write(reinterpret_cast<const char*>(&p.extent), sizeof p.extent);
    f.write(reinterpret_cast<const char*>(p.pixels.data()), std::streamsize(p.pixels.size() * sizeof p.pixels[0]));
  }
  static bool load(Picture& p, const std::string& name) {
    std::ifstream f("/tmp/vd/" + name + ".pic", std::ios::binary);
    if (!f) return false;
    f.read(reinterpret_cast<char*>(&p.extent), sizeof p.extent);
    p.pixels.resize(std::size_t(p.extent.area()));
    f.read(reinterpret_cast<char*>(p.pixels.data()), std::streamsize(p.pixels.size() * sizeof p.pixels[0]));
    return true;
  }
  static void expect_convergence(RenderSpec spec) {
    const std::string me = testing::UnitTest::GetInstance()->current_test_info()->name();
    Picture judge;
    if (!load(judge, me + "-ref")) { judge = reference_of(spec); dump(judge, me + "-ref"); }
    spec.environment.visibility = EnvironmentVisibility::kOff;
    dump(drawn(spec, 16), me + "-off");
    const double without = reference::flip_mean(judge, drawn(spec, 16));
    spec.environment.visibility = EnvironmentVisibility::kOn;
    printf("%s off: %.4f\n", me.c_str(), without);
    double before = 1;
    for (const int samples : {16, 64}) {
      const Picture now_p = drawn(spec, samples);
      dump(now_p, me + "-" + std::to_string(samples));
      const double now = reference::flip_mean(judge, now_p);
      printf("%s %d: %.4f\n", me.c_str(), samples, now); fflush(stdout);
      RecordProperty(std::to_string(samples) + "-samples", std::to_string(now));
      EXPECT_LT(now, before + 0.001) << samples;
      if (samples >= kVisibilitySamples) {
        EXPECT_LE(now, 0.02) << samples;
      }
      before = now;
    }
    EXPECT_GT(without, 2 * before);
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

}  // namespace
}  // namespace furnace
