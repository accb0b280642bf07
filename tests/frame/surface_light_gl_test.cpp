// Lights that are surfaces against closed forms and sums over their points, and photometric profiles.
#include <functional>

#include "renderer/scene/framing.hpp"
#include "tests/frame/lit_floor.hpp"

namespace furnace {
namespace {

class SurfaceLightGlTest : public LitFloorGlTest {
 protected:
  static Light down(LightKind kind, double height_m) {
    Light light;
    light.kind = kind;
    light.position = {0.0625, height_m, 0.0625};  // over the middle of a pixel
    light.direction = {0, -1, 0};
    light.intensity = glm::dvec3(1);
    light.casts_shadow = false;
    return light;
  }
  // Of a diffuse light: E on the floor at (x, z) by midpoints over a rectangle.
  static double irradiance_of_rectangle(const Light& light, double x, double z) {
    const LightAxes axes = axes_of_light(light);
    constexpr int kSide = 200;
    double sum = 0;
    for (int i = 0; i < kSide; ++i) {
      for (int j = 0; j < kSide; ++j) {
        const glm::dvec3 point = light.position + axes.x * (light.width_m * ((i + 0.5) / kSide - 0.5)) +
                                 axes.y * (light.height_m * ((j + 0.5) / kSide - 0.5));
        const glm::dvec3 to_light = point - glm::dvec3(x, 0, z);
        const double d2 = glm::dot(to_light, to_light), d = std::sqrt(d2);
        const double at_light = glm::dot(light.direction, -to_light) / d, at_floor = to_light.y / d;
        if (at_light > 0 && at_floor > 0) sum += at_light * at_floor / d2;
      }
    }
    return light.intensity.x * sum * light.width_m * light.height_m / (kSide * kSide);
  }
  static double all_light(const Film& film) {
    double sum = 0;
    for (int cell = 0; cell < 64 * 64; ++cell)
      sum += light_at(film, (cell % 64 + 0.5) / 8 - 4, (cell / 64 + 0.5) / 8 - 4);
    return sum;
  }
  // As floor_under() draws it, for its camera.
  static Scene floor_scene() {
    Scene scene;
    Mesh floor;
    floor.positions = {{-4, 0, -4}, {4, 0, -4}, {4, 0, 4}, {-4, 0, 4}};
    floor.indices = {0, 1, 2, 0, 2, 3};
    for (const glm::vec3& corner : floor.positions) floor.bounds.add(corner);
    scene.meshes = {std::make_shared<const Mesh>(std::move(floor))};
    scene.instances = {Instance{}};
    return scene;
  }
  // What a point light straight above a place gives for a unit of irradiance there.
  static double light_per_irradiance() {
    Light point = down(LightKind::kPoint, 2);
    return light_at(render(floor_under(point)), 0.0625, 0.0625) * 4;
  }
};

TEST_F(SurfaceLightGlTest, ARectangleIsTheSumOfItsPoints) {
  Light light = down(LightKind::kRectangle, 1);
  light.width_m = 2;
  light.height_m = 0.5;
  light.roll_rad = 0.4;
  const double unit = light_per_irradiance();
  const Film film = render(floor_under(light));
  for (const glm::dvec2 at :
       {glm::dvec2(0.0625, 0.0625), {1.0625, 0.0625}, {0.0625, 1.0625}, {-2.0625, 1.5625}}) {
    const double expected = unit * irradiance_of_rectangle(light, at.x, at.y);
    EXPECT_NEAR(light_at(film, at.x, at.y), expected, 0.01 * expected) << at.x << " " << at.y;
  }
}

// Upright, half of it under the floor: only the upper half lights, and only what lies before it.
TEST_F(SurfaceLightGlTest, TheHorizonCutsALight) {
  Light light = down(LightKind::kRectangle, 0);
  light.direction = {0, 0, 1};
  light.width_m = 1;
  light.height_m = 2;
  const double unit = light_per_irradiance();
  const Film film = render(floor_under(light));
  for (const glm::dvec2 at : {glm::dvec2(0.0625, 0.5625), {0.0625, 2.0625}, {1.0625, 0.5625}}) {
    const double expected = unit * irradiance_of_rectangle(light, at.x, at.y);
    EXPECT_NEAR(light_at(film, at.x, at.y), expected, 0.01 * expected) << at.x << " " << at.y;
  }
  EXPECT_EQ(light_at(film, 0.0625, -1.0625), 0);
  light.two_sided = true;
  const Film both = render(floor_under(light));
  EXPECT_NEAR(light_at(both, 0.0625, -1.0625 + 0.125), light_at(both, 0.0625, 1.0625),
              0.02 * light_at(both, 0.0625, 1.0625));
}

// Of radiance 1: on the axis of a disc pi r^2 / (r^2 + h^2); under a ball wholly above the horizon that of a point of pi r^2 cd.
TEST_F(SurfaceLightGlTest, DiscsAndBallsHaveTheirClosedForms) {
  const double unit = light_per_irradiance();
  Light disc = down(LightKind::kDisc, 1);
  disc.radius_m = 0.8;
  EXPECT_NEAR(light_at(render(floor_under(disc)), 0.0625, 0.0625), unit * kPi * 0.64 / 1.64, 0.01 * unit);
  Light ball = down(LightKind::kSphere, 1.5);
  ball.radius_m = 0.6;
  const Film film = render(floor_under(ball));
  for (const double x : {0.0, 1.0, 2.0, 3.0}) {
    const double d2 = x * x + 2.25, expected = unit * kPi * 0.36 * 1.5 / (d2 * std::sqrt(d2));
    EXPECT_NEAR(light_at(film, x + 0.0625, 0.0625), expected, 0.01 * expected) << x;
  }
}

// Without anything in the way the parts of many sub-frames are the whole of one. Summed over the floor, since each part falls on
// another place within the pixel, which are an eighth of a metre wide here.
TEST_F(SurfaceLightGlTest, PartsAddUpToTheWhole) {
  for (const LightKind kind : {LightKind::kRectangle, LightKind::kDisc}) {
    Light light = down(kind, 0.7);
    light.radius_m = 0.5;
    RenderSpec spec = floor_under(light);
    const Film one = render(spec);
    spec.output.samples = 7;
    const Film many = render(spec);
    EXPECT_NEAR(all_light(many), all_light(one), 5e-3 * all_light(one));
  }
}

// A long straight edge over the middle of a strip of light hides just so much of it.
TEST_F(SurfaceLightGlTest, ShadowsConvergeToTheShareThatIsFree) {
  Light light = down(LightKind::kRectangle, 2);
  light.position.x += 1;
  light.casts_shadow = true;
  light.width_m = 1;
  light.height_m = 0.2;
  RenderSpec spec = floor_under(light);
  NodeSpec plate;
  plate.mesh = "plane";
  plate.material = "m";
  plate.translation = {1, 1, 0};  // its edge is at x = 0, half way up
  plate.scale = glm::vec3(2);
  spec.scene.nodes.push_back(plate);
  spec.output.samples = 64;
  const Film film = render(spec);
  spec.scene.nodes.pop_back();
  const Film free = render(spec);
  // From x the edge hides what lies beyond -x on the light, which goes from 0.5625 to 1.5625.
  for (const double x : {-0.6875, -0.8125, -1.0625, -1.3125, -1.5625}) {
    Light part = light;
    part.width_m = -x - 0.5625;
    part.position.x = 0.5625 + part.width_m / 2;
    const double share = irradiance_of_rectangle(part, x, 0.0625) / irradiance_of_rectangle(light, x, 0.0625);
    EXPECT_NEAR(light_at(film, x, 0.0625) / light_at(free, x, 0.0625), share, 0.05) << x;
  }
}

// What a mirror of some roughness shows of a rectangle, against the sum of D V (n.l) over its points.
TEST_F(SurfaceLightGlTest, HighlightsAreThoseOfTheLobe) {
  for (const double roughness : {0.3, 0.5, 0.8}) {
    Light light = down(LightKind::kRectangle, 1.5);
    light.width_m = 1.6;
    light.height_m = 0.7;
    RenderSpec spec = floor_under(light);
    MaterialOverride& metal = spec.scene.materials["m"];
    metal.base_color = glm::vec4(1);
    metal.metallic = 1.f;
    metal.perceptual_roughness = float(roughness);
    OrbitCamera camera;
    camera.elevation_rad = radians_from_degrees(50);
    camera.azimuth_rad = 0;
    camera.orthographic = true;
    spec.camera.view = camera;
    const Film film = render(spec);
    const View view = make_view(spec.camera, floor_scene(), {64, 64});
    const glm::dvec3 v(0, std::sin(radians_from_degrees(50)), std::cos(radians_from_degrees(50)));
    const double alpha2 = std::pow(roughness, 4);
    for (const glm::dvec3 place : {glm::dvec3(0, 0, 0.2), {0, 0, 1.2}, {0.7, 0, 0.8}, {-1, 0, 2}}) {
      const auto lobe = [&](const glm::dvec3& l) {
        const glm::dvec3 h = glm::normalize(l + v);
        const double q = h.y * h.y * (alpha2 - 1) + 1, D = alpha2 / (kPi * q * q);
        return D * 0.5 /
               (l.y * std::sqrt(alpha2 + (1 - alpha2) * v.y * v.y) +
                v.y * std::sqrt(alpha2 + (1 - alpha2) * l.y * l.y));
      };
      constexpr int kSide = 200;
      double sum = 0;
      for (int i = 0; i < kSide * kSide; ++i) {
        const glm::dvec3 to_light = light.position +
                                    glm::dvec3(light.width_m * ((i % kSide + 0.5) / kSide - 0.5), 0,
                                               light.height_m * ((i / kSide + 0.5) / kSide - 0.5)) -
                                    place;
        const double d2 = glm::dot(to_light, to_light);
        const glm::dvec3 l = to_light / std::sqrt(d2);
        sum += lobe(l) * l.y * l.y / d2 * light.width_m * light.height_m / (kSide * kSide);
      }
      const glm::vec4 clip = view.clip_from_view * (view.view_from_world * glm::vec4(place, 1));
      const glm::ivec2 at((clip.x / clip.w * 0.5 + 0.5) * 64, (0.5 - clip.y / clip.w * 0.5) * 64);
      // A fitted cosine has no tail like GGX (renderer/ibl/ltc.hpp): beside the highlight, whose peak is 0.9, up to 0.06 off.
      EXPECT_NEAR(pixel(film, at.x, at.y).g, sum, 0.1 * sum + 0.06)
          << roughness << " " << place.x << " " << place.z;
    }
  }
}

// Twice as bright towards +x as towards -x, nothing beyond 45 degrees.
constexpr const char* kLopsided =
    "IESNA:LM-63-2002\n[TEST] made for this test\nTILT=NONE\n"
    "1 1000 2 5 3 1 2 0 0 0 1 1 10\n0 15 30 45 45.1\n0 90 180\n"
    "100 100 100 100 0\n100 75 75 75 0\n100 50 50 50 0\n";

TEST_F(SurfaceLightGlTest, AProfileIsItsFile) {
  Light light = down(LightKind::kPoint, 2);
  const Film even = render(floor_under(light));
  light.profile = std::make_shared<const LightProfile>(parse_ies(kLopsided));
  const Film film = render(floor_under(light));
  const auto share = [&](double x) { return light_at(film, x, 0.0625) / light_at(even, x, 0.0625); };
  EXPECT_NEAR(share(0.0625), 1, 0.01);
  EXPECT_NEAR(share(1.0625), 1, 0.01);
  EXPECT_NEAR(share(-0.9375), 0.5, 0.01);
  EXPECT_NEAR(light_at(film, 0.0625, 1.0625) / light_at(even, 0.0625, 1.0625), 0.75, 0.01);
  EXPECT_EQ(light_at(film, 2.3125, 0.0625), 0);
  light.roll_rad = kPi;
  EXPECT_NEAR(light_at(render(floor_under(light)), -0.9375, 0.0625) / light_at(even, -0.9375, 0.0625), 1,
              0.01);
}

}  // namespace
}  // namespace furnace
