// Lights and their shadows, where they are known in closed form.
#include <cmath>

#include "renderer/frame/light_plan.hpp"
#include "tests/frame/lit_floor.hpp"

namespace furnace {
namespace {

class LightGlTest : public LitFloorGlTest {};

Light point_at(double height_m, double candela) {
  Light light;
  light.position = {0.0625, height_m, 0.0625};  // over the middle of a pixel
  light.intensity = glm::dvec3(candela);
  return light;
}

TEST_F(LightGlTest, FallsWithTheSquareOfTheDistance) {
  const Film film = render(floor_under(point_at(1, 10)));
  const double under = light_at(film, 0.0625, 0.0625);
  EXPECT_GT(under, 0.9 * 0.95 * 0.5 * 10 / kPi);
  EXPECT_LT(under, 0.5 * 10 / kPi);
  for (const int cells : {4, 8, 16, 24}) {
    const double x = cells / 8.0, d2 = 1 + x * x;
    EXPECT_NEAR(light_at(film, x + 0.0625, 0.0625) / under, 1 / (d2 * std::sqrt(d2)), 5e-3) << x;
  }
}

TEST_F(LightGlTest, EndsAtItsRange) {
  Light light = point_at(1, 10);
  const double free = light_at(render(floor_under(light)), 1.0625, 0.0625);
  light.range_m = 2;  // d^2 = 2: the window is 1 - (2 / 4)^2
  EXPECT_NEAR(light_at(render(floor_under(light)), 1.0625, 0.0625) / free, 0.75, 1e-3);
  light.range_m = 1.4;
  EXPECT_EQ(light_at(render(floor_under(light)), 1.0625, 0.0625), 0);
}

TEST_F(LightGlTest, ASpotShinesInItsCone) {
  Light light = point_at(1, 10);
  const Film everywhere = render(floor_under(light));
  light.kind = LightKind::kSpot;
  light.direction = {0, -1, 0};
  light.inner_cone_rad = std::atan(1.0);
  light.outer_cone_rad = std::atan(2.0);
  const Film cone = render(floor_under(light));
  EXPECT_NEAR(light_at(cone, 0.9375, 0.0625), light_at(everywhere, 0.9375, 0.0625), 1e-4);
  EXPECT_EQ(light_at(cone, 2.1875, 0.0625), 0);
  // KHR_lights_punctual: squared, linear in the cosine between the cones.
  const double cosine = 1 / std::sqrt(1 + 1.5 * 1.5), outer = 1 / std::sqrt(5), inner = 1 / std::sqrt(2);
  EXPECT_NEAR(light_at(cone, 1.5625, 0.0625) / light_at(everywhere, 1.5625, 0.0625),
              std::pow((cosine - outer) / (inner - outer), 2), 5e-3);
}

// A plate of 2 m x 2 m, 1 m above the floor; light from the side, so that its shadow lies free.
class ShadowGlTest : public LightGlTest {
 protected:
  static RenderSpec plate_over_floor(const Light& light) {
    RenderSpec spec = floor_under(light);
    NodeSpec plate;
    plate.mesh = "plane";
    plate.material = "m";
    plate.translation = {-2.5f, 1, 0};
    plate.scale = glm::vec3(2);
    spec.scene.nodes.push_back(plate);
    return spec;
  }
  // 45 degrees from -x: the shadow of the plate, x from -3.5 to -1.5, falls on x from -2.5 to -0.5.
  static Light slanting() {
    Light light;
    light.kind = LightKind::kDirectional;
    light.direction = glm::normalize(glm::dvec3(1, -1, 0));
    light.intensity = glm::dvec3(3);
    return light;
  }
};

TEST_F(ShadowGlTest, FallsWhereTheLightIsKeptOff) {
  Light light = slanting();
  const Film film = render(plate_over_floor(light));
  const double lit = light_at(film, 1.0625, 0.0625);
  EXPECT_GT(lit, 0.9 * 0.95 * 0.5 * 3 * std::sqrt(0.5) / kPi);
  EXPECT_LT(light_at(film, -0.6875, 0.0625), 1e-3 * lit);
  EXPECT_LT(light_at(film, -1.3125, 0.8125), 1e-3 * lit);
  EXPECT_NEAR(light_at(film, -0.3125, 0.0625), lit, 1e-3 * lit);
  EXPECT_NEAR(light_at(film, -1.0625, 1.1875), lit, 1e-3 * lit);
  light.casts_shadow = false;
  EXPECT_NEAR(light_at(render(plate_over_floor(light)), -0.6875, 0.0625), lit, 1e-3 * lit);
}

// The disc of the light, of angular radius r, is cut by the plate's edge: at a distance y from the edge of the shadow, seen
// from the plate's edge at a distance d, the share (t - sin t) / (2 pi) of it is free, cos(t / 2) = -y / (d r).
TEST_F(ShadowGlTest, ConvergesToThePenumbraOfADisc) {
  Light light = slanting();
  light.angular_radius_rad = 0.1;
  RenderSpec spec = plate_over_floor(light);
  spec.output.samples = 128;
  const Film film = render(spec);
  spec.output.samples = 1;
  const Film draft = render(spec);
  const double lit = light_at(film, 1.0625, 0.0625);
  const double d = std::sqrt(2.0);                           // from the plate's edge to the floor
  for (const double z : {0.8125, 0.9375, 1.0625, 1.1875}) {  // across the edge along the light, z = 1
    const double q = std::clamp((z - 1) / (d * std::tan(0.1)), -1.0, 1.0);
    const double t = 2 * std::acos(-q);
    const double expected = (t - std::sin(t)) / (2 * kPi);
    // A pixel is nearly half as wide as the penumbra, and 128 places of pixel and light together are not even in all four axes.
    EXPECT_NEAR(light_at(film, -1.0625, z) / lit, expected, 0.02) << z;
    EXPECT_NEAR(light_at(draft, -1.0625, z) / lit, expected, 0.2) << z;  // recognisably the same
  }
}

TEST_F(ShadowGlTest, OfAPointLightSpreads) {
  Light light = point_at(3, 100);
  light.position = {-2.5, 3, 0};  // over the plate: its shadow is 1.5 times as large
  const Film film = render(plate_over_floor(light));
  const Film free = render(floor_under(light));
  EXPECT_NEAR(light_at(film, -0.8125, 0.0625), light_at(free, -0.8125, 0.0625), 1e-3);
  EXPECT_LT(light_at(film, -1.1875, 0.0625), 1e-3);
}

// Beyond the box that a light's view covers nothing casts a shadow, and nothing is lost: plan_lights holds the whole scene.
TEST(LightPlan, EveryViewHoldsTheScene) {
  const Bounds scene{{-1, -2, -3}, {4, 5, 6}};
  Light sun;
  sun.kind = LightKind::kDirectional;
  sun.direction = glm::normalize(glm::dvec3(0.3, -1, 0.2));
  sun.angular_radius_rad = 0.05;
  for (int subframe = 0; subframe < 8; ++subframe) {
    const LightPlan plan = plan_lights({sun}, scene, {0, 0}, subframe, 8);
    ASSERT_EQ(plan.views, 1);
    for (int corner = 0; corner < 8; ++corner) {
      const glm::vec4 at(corner & 1 ? scene.max.x : scene.min.x, corner & 2 ? scene.max.y : scene.min.y,
                         corner & 4 ? scene.max.z : scene.min.z, 1);
      const glm::vec4 clip = plan.block.shadow_from_world[0] * at;
      for (int axis = 0; axis < 2; ++axis) EXPECT_LT(std::abs(clip[axis] / clip.w), 1);
      EXPECT_GT(clip.z / clip.w, 0);
      EXPECT_LT(clip.z / clip.w, 1);
    }
  }
}

TEST(LightPlan, MapsAreGivenWhileThereAreSome) {
  const std::vector<Light> many(12);  // point lights, six views each
  const LightPlan plan = plan_lights(many, {{-1, -1, -1}, {1, 1, 1}}, {0, 0}, 0, 1);
  EXPECT_EQ(plan.views, int(gpu::MOST_SHADOW_VIEWS));
  EXPECT_EQ(plan.block.count, 12u);
  EXPECT_EQ(plan.block.lights[7].shadow.x, 42);
  EXPECT_EQ(plan.block.lights[8].shadow.x, -1);
  EXPECT_EQ(plan_lights(many, {}, {0, 0}, 0, 1).views, 0);
}

}  // namespace
}  // namespace furnace
