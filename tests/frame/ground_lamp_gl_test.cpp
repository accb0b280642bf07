// The shadow on the ground of lights that have a place, against closed forms and sums over their points.
#include "renderer/scene/transform.hpp"
#include "tests/frame/closed_form.hpp"

namespace furnace {
namespace {

// A plate of 1 m x 1 m at y = 0 over the ground, seen from above by parallel rays, 16 pixels a metre.
class GroundLampGlTest : public ClosedFormGlTest {
 protected:
  static constexpr double kLevel = -0.5;

  static RenderSpec plate_under(const Light& lamp, glm::vec3 sky) {
    RenderSpec spec = spec_of("plane", {}, sky);
    spec.environment.background = TransparentBackground{};
    spec.environment.ground = GroundSpec{};
    spec.environment.ground->level_m = kLevel;
    LookAtCamera above;
    above.eye = {0, 5, 0};
    above.target = {0, 0, 0};
    above.up = {0, 0, -1};
    above.height_m = 4;
    spec.camera.view = above;
    spec.scene.lights = {lamp};
    return spec;
  }
  static Light lamp_at(LightKind kind, glm::dvec3 position, double intensity) {
    Light light;
    light.kind = kind;
    light.position = position;
    light.direction = {0, -1, 0};
    light.intensity = glm::dvec3(intensity);
    return light;
  }
  // The share of its light that the ground lacks at (x, z), m.
  static double lacks(const Film& film, double x, double z) {
    const int column = int(std::floor((x + 2) * 16)), row = int(std::floor((z + 2) * 16));
    return double(film.image.samples<float>()[std::size_t(row * 64 + column) * 4 + 3]);
  }
  static bool meets_plate(const glm::dvec3& from, const glm::dvec3& to) {
    const glm::dvec3 at = glm::mix(from, to, from.y / (from.y - to.y));
    return from.y > 0 && std::abs(at.x) < 0.5 && std::abs(at.z) < 0.5;
  }
};

constexpr double kPx = 1.0 / 32;  // to the middle of a pixel

TEST_F(GroundLampGlTest, APointCastsACentralProjection) {
  const Film film = render(plate_under(lamp_at(LightKind::kPoint, {0, 1, 0}, 1), glm::vec3(0)));
  for (const double x : {-0.70, -0.56, 0.56, 0.65}) EXPECT_NEAR(lacks(film, x + kPx, kPx), 1, 1e-3) << x;
  for (const double x : {-1.5, -0.85, 0.80, 0.9, 1.7}) EXPECT_NEAR(lacks(film, x + kPx, kPx), 0, 1e-3) << x;
  EXPECT_NEAR(lacks(film, 0.65, 0.65), 1, 1e-3);
  EXPECT_NEAR(lacks(film, 0.85, 0.65), 0, 1e-3);
}

// From beside the plate its shadow lies on the other side, and what is higher than the lamp casts none.
TEST_F(GroundLampGlTest, OnlyWhatIsBelowTheLampCasts) {
  const Film aside = render(plate_under(lamp_at(LightKind::kPoint, {1, 0.5, 0}, 1), glm::vec3(0)));
  EXPECT_NEAR(lacks(aside, -1.5 + kPx, kPx), 1, 1e-3);
  EXPECT_NEAR(lacks(aside, 0.8, kPx), 0, 1e-3);
  RenderSpec spec = plate_under(lamp_at(LightKind::kPoint, {0.8, 0.3, 0}, 1), glm::vec3(0));
  spec.scene.nodes.push_back(node("plane", "m", {0, 1, 0}));  // above the lamp
  const Film both = render(spec);
  spec.scene.nodes.pop_back();
  EXPECT_NEAR(lacks(both, -1 + kPx, kPx), 1, 1e-3);
  EXPECT_NEAR(lacks(both, 1.2 + kPx, kPx), 0, 1e-3);
  EXPECT_NEAR(lacks(both, 0.8 + kPx, 1 + kPx), 0, 1e-3);
}

// Every part of a disc weighs what it sheds on the place.
TEST_F(GroundLampGlTest, ASizeMakesAPenumbra) {
  Light lamp = lamp_at(LightKind::kDisc, {0, 1, 0}, 1);
  lamp.radius_m = 0.5;
  const Film film = render(plate_under(lamp, glm::vec3(0)));
  double worst = 0, between = 0;
  for (double x = 0.53125; x < 1.5; x += 1.0 / 16) {
    double hidden = 0, all = 0;
    constexpr int kSide = 100;
    for (int i = 0; i < kSide * kSide; ++i) {
      const double u = (i % kSide + 0.5) / kSide * 2 - 1, v = (double(i / kSide) + 0.5) / kSide * 2 - 1;
      if (u * u + v * v > 1) continue;
      const glm::dvec3 from = lamp.position + glm::dvec3(u, 0, v) * lamp.radius_m, to(x, kLevel, kPx);
      const double weight = 1 / std::pow(glm::dot(from - to, from - to), 2);
      all += weight;
      if (meets_plate(from, to)) hidden += weight;
    }
    worst = std::max(worst, std::abs(lacks(film, x, kPx) - hidden / all));
    between += hidden / all * (1 - hidden / all);
  }
  EXPECT_GT(between, 0.5) << "there is a penumbra to be judged";
  EXPECT_LT(worst, 0.02);  // 128 places
}

// Against the sky's light a lamp's counts as what falls from it on that very place.
TEST_F(GroundLampGlTest, LampsAndSkyWeighTheirIrradiance) {
  const glm::dvec3 position(0.3, 0.7, -0.2);
  Light lamp = lamp_at(LightKind::kPoint, position, 0);
  const Film dark = render(plate_under(lamp, glm::vec3(1)));
  const auto expect = [&](const Light& light, auto irradiance_at, double tolerance) {
    for (const bool casts : {false, true}) {
      Light shining = light;
      shining.casts_shadow = casts;
      const Film film = render(plate_under(shining, glm::vec3(1)));
      for (const auto& [x, z] :
           {std::pair{-0.7, 0.1}, std::pair{0.55, 0.0}, std::pair{1.1, -0.9}, std::pair{-1.4, 1.3}}) {
        const glm::dvec3 to(std::floor(x * 16) / 16 + kPx, kLevel, std::floor(z * 16) / 16 + kPx);
        const double irradiance = irradiance_at(to);
        const double hidden = casts && meets_plate(position, to) ? irradiance : 0;
        EXPECT_NEAR(lacks(film, x, z), (kPi * lacks(dark, x, z) + hidden) / (kPi + irradiance), tolerance)
            << x << ", " << z << (casts ? " with" : " without") << " its shadow";
      }
    }
  };
  lamp.intensity = glm::dvec3(5);
  expect(
      lamp,
      [&](const glm::dvec3& to) {
        const glm::dvec3 way = position - to;
        return 5 * way.y / std::pow(glm::length(way), 3);
      },
      4e-3);

  Light spot = lamp;
  spot.kind = LightKind::kSpot;
  spot.outer_cone_rad = 0.6;
  spot.inner_cone_rad = 0.59;
  expect(
      spot,
      [&](const glm::dvec3& to) {
        const glm::dvec3 way = position - to;
        const double angle = std::acos(way.y / glm::length(way));
        return angle < 0.59 ? 5 * way.y / std::pow(glm::length(way), 3) : 0;
      },
      4e-3);

  // Small enough to cast hard shadows at these places.
  Light panel = lamp_at(LightKind::kRectangle, position, 0);
  panel.width_m = 0.2;
  panel.height_m = 0.1;
  panel.intensity = glm::dvec3(5 / 0.02);
  expect(
      panel,
      [&](const glm::dvec3& to) {
        const glm::dvec3 way = position - to;
        return 5 * way.y * way.y / std::pow(glm::dot(way, way), 2);
      },
      1e-2);
}

}  // namespace
}  // namespace furnace
