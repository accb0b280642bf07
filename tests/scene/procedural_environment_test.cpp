#include "renderer/scene/procedural_environment.hpp"

#include "renderer/image/color.hpp"
#include "renderer/base/error.hpp"
#include "tests/scene/equirect_sums.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

namespace furnace {
namespace {

const float* texel(const Image& image, int row, int column) {
  return &image.samples<float>()[3 * (std::size_t(row) * image.extent.width + column)];
}

double elevation_deg(const Image& image, int row) {
  return 90 - 180 * (row + 0.5) / image.extent.height;
}

double luminance(const glm::dvec3& color) {
  return luminance_rec709(color.r, color.g, color.b);
}

constexpr double kHalfRounding = 1.0 / 2048;

void expect_sane(const Image& image) {
  EXPECT_EQ(image.extent.width, 2 * image.extent.height);
  for (const float sample : image.samples<float>()) ASSERT_TRUE(std::isfinite(sample) && sample >= 0);
}

// --- Gradient

TEST(Gradient, IsLinearInElevation) {
  GradientEnvironment gradient;
  gradient.stops = {{-30, {1, 0, 4}}, {10, {3, 8, 4}}, {60, {3, 8, 0}}};
  const Image image = paint_environment(gradient);
  for (int row = 0; row < image.extent.height; row += 7) {
    const double elevation = elevation_deg(image, row);
    const double first = std::clamp((elevation + 30) / 40, 0.0, 1.0),
                 second = std::clamp((elevation - 10) / 50, 0.0, 1.0);
    for (const int column : {0, 500, 1023}) {
      EXPECT_NEAR(texel(image, row, column)[0], 1 + 2 * first, 3 * kHalfRounding);
      EXPECT_NEAR(texel(image, row, column)[1], 8 * first, 8 * kHalfRounding);
      EXPECT_NEAR(texel(image, row, column)[2], 4 - 4 * second, 4 * kHalfRounding);
    }
  }
}

TEST(Gradient, TwoStopsAtOneElevationAreAStep) {
  GradientEnvironment gradient;
  gradient.stops = {{-90, glm::dvec3(1)}, {0, glm::dvec3(1)}, {0, glm::dvec3(3)}, {90, glm::dvec3(3)}};
  const Image image = paint_environment(gradient);
  for (int row = 0; row < image.extent.height; ++row)
    ASSERT_EQ(texel(image, row, 0)[0], row < image.extent.height / 2 ? 3 : 1);
  gradient.stops = {{0, glm::dvec3(1)}, {0, glm::dvec3(3)}};
  EXPECT_EQ(texel(paint_environment(gradient), 0, 0)[0], 3);
  EXPECT_EQ(texel(paint_environment(gradient), 511, 0)[0], 1);
}

TEST(Gradient, SmoothHasNoSlopeAtItsStops) {
  GradientEnvironment gradient;
  gradient.stops = {{-90, glm::dvec3(0)}, {90, glm::dvec3(1)}};
  gradient.blend = GradientBlend::kSmooth;
  const Image image = paint_environment(gradient);
  for (const int row : {0, 100, 256, 400}) {
    const double t = (elevation_deg(image, row) + 90) / 180;
    EXPECT_NEAR(texel(image, row, 0)[0], t * t * (3 - 2 * t), kHalfRounding);
  }
}

TEST(Gradient, DefaultIsExposedLikeTheBuiltIns) {
  const glm::dvec3 card = irradiance_over_pi(paint_environment(GradientEnvironment{}), {0, 1, 0});
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(card[i], 1, 0.25);
}

// --- Overcast

TEST(OvercastEnvironment, ScalesWithZenithAndGround) {
  const Image sky = paint_environment(OvercastEnvironment{4000, 0.5});
  const double card = 4000 * 7.0 / 9;
  EXPECT_NEAR(irradiance_over_pi(sky, {0, 1, 0}).g, card, 1e-3 * card);  // 128 rows
  EXPECT_NEAR(texel(sky, 127, 0)[1], 0.5 * card, 0.025 * card);          // the haze between
}

// --- Studio

StudioEnvironment studio_of(const SoftBox& light) {
  StudioEnvironment studio;
  studio.room.stops = {{-90, glm::dvec3(0)}, {90, glm::dvec3(0)}};
  studio.lights = {light};
  return studio;
}

// Arvo 2001, "Stratified sampling of 2-manifolds": solid angle of a rectangle seen from above its middle.
double rectangle_sr(double width_rad, double height_rad) {
  return 4 * std::asin(std::sin(width_rad / 2) * std::sin(height_rad / 2));
}

double cone_sr(double angle_rad) {
  return 2 * kPi * (1 - std::cos(angle_rad / 2));
}

struct Placement {
  double azimuth_deg, elevation_deg, roll_deg, width_deg, height_deg;
};
// In the middle, over the seam of the map, over both poles, small, thin and as large as may be.
constexpr Placement kPlacements[] = {{90, 10, 0, 40, 25},    {-90, 20, 30, 30, 50},   {10, 90, 20, 20, 20},
                                     {200, -88, 45, 35, 10}, {33, 47, 13, 1, 1},      {-61, 35, 5, 0.5, 60},
                                     {123, 5, 0, 160, 160},  {-170, -20, 70, 90, 120}};

SoftBox light_at(const Placement& place) {
  SoftBox light;
  light.azimuth_rad = radians_from_degrees(place.azimuth_deg);
  light.elevation_rad = radians_from_degrees(place.elevation_deg);
  light.roll_rad = radians_from_degrees(place.roll_deg);
  light.width_rad = radians_from_degrees(place.width_deg);
  light.height_rad = radians_from_degrees(place.height_deg);
  light.feather = 0;
  light.luminance = 3;
  return light;
}

glm::dvec3 towards(double azimuth_rad, double elevation_rad) {
  return {std::sin(azimuth_rad) * std::cos(elevation_rad), std::sin(elevation_rad),
          std::cos(azimuth_rad) * std::cos(elevation_rad)};
}

TEST(StudioEnvironment, RectangleStandsInItsPlaceWithTheEnergyOfItsSolidAngle) {
  for (const Placement& place : kPlacements) {
    SCOPED_TRACE(testing::Message() << place.azimuth_deg << " " << place.elevation_deg);
    const SoftBox light = light_at(place);
    const Image image = paint_environment(studio_of(light));
    expect_sane(image);
    glm::dvec3 moment(0);
    const double energy = luminance(integrate(image, [](const glm::dvec3&) { return 1.0; }));
    for (int axis = 0; axis < 3; ++axis)
      moment[axis] = integrate(image, [axis](const glm::dvec3& d) { return d[axis]; }).g;
    EXPECT_NEAR(energy / (3 * rectangle_sr(light.width_rad, light.height_rad)), 1, 0.01);
    EXPECT_GT(glm::dot(glm::normalize(moment), towards(light.azimuth_rad, light.elevation_rad)),
              std::cos(radians_from_degrees(0.1)));
  }
}

TEST(StudioEnvironment, DiscHasTheEnergyOfItsSolidAngle) {
  for (const Placement& place : kPlacements) {
    SoftBox light = light_at(place);
    light.shape = LightShape::kDisc;
    light.height_rad = light.width_rad;
    light.color = {0.2, 0, 5};  // of which only the chromaticity counts
    const double energy =
        luminance(integrate(paint_environment(studio_of(light)), [](const glm::dvec3&) { return 1.0; }));
    // A disc of half a degree covers 6 texels, each by 256 samples.
    const double tolerance = place.width_deg < 1 ? 0.02 : 0.01;
    EXPECT_NEAR(energy / (3 * cone_sr(light.width_rad)), 1, tolerance)
        << place.azimuth_deg << " " << place.elevation_deg;
  }
}

TEST(StudioEnvironment, RollIsCounterClockwiseSeenFromTheCentre) {
  SoftBox light;
  light.azimuth_rad = 0;
  light.elevation_rad = 0;
  light.width_rad = radians_from_degrees(40);
  light.height_rad = radians_from_degrees(5);
  light.roll_rad = radians_from_degrees(30);
  // Towards +Z, -X is to the right: the right end is lifted.
  const glm::dvec3 skew =
      integrate(paint_environment(studio_of(light)), [](const glm::dvec3& d) { return -d.x * d.y; });
  EXPECT_GT(skew.g, 0);
}

TEST(StudioEnvironment, FeatherAndHotspotStayInsideOfTheLight) {
  SoftBox light = light_at({90, 10, 0, 40, 30});
  light.feather = 1;
  light.hotspot = 2;
  const Image soft = paint_environment(studio_of(light));
  double peak = 0, neighbours = 0;
  for (int row = 0; row < soft.extent.height; ++row)
    for (int column = 0; column + 1 < soft.extent.width; ++column) {
      const double here = texel(soft, row, column)[1];
      peak = std::max(peak, here);
      neighbours = std::max(neighbours, std::abs(here - texel(soft, row, column + 1)[1]));
    }
  EXPECT_NEAR(peak, 6, 0.01);
  EXPECT_LT(neighbours, 0.04 * peak);  // the steepest part is 1.5 in 15 degrees, a texel is 0.35
  const double energy = integrate(soft, [](const glm::dvec3&) { return 1.0; }).g;
  EXPECT_LT(energy, 6 * rectangle_sr(light.width_rad, light.height_rad));
}

// --- Clear sky

ClearSkyEnvironment sky_at(double sun_elevation_deg, double turbidity = 2.5) {
  ClearSkyEnvironment sky;
  sky.sun_elevation_rad = radians_from_degrees(sun_elevation_deg);
  sky.turbidity = turbidity;
  sky.calibration = SkyCalibration::kPhysical;
  return sky;
}

TEST(ClearSkyEnvironment, IsSaneFromTwilightToZenith) {
  for (const double elevation : {-6.0, 0.0, 90.0})
    for (const double turbidity : {2.0, 10.0}) {
      SCOPED_TRACE(elevation);
      ClearSkyEnvironment described = sky_at(elevation, turbidity);
      described.sun_disc = elevation == 0;
      const Image sky = paint_environment(described);
      expect_sane(sky);
      for (int row = 0; row < sky.extent.height; row += 31)
        for (int column = 0; column < sky.extent.width; column += 61)
          ASSERT_GT(texel(sky, row, column)[1], 0.01);
    }
}

TEST(ClearSkyEnvironment, IsTheSameWhoeverPaintsIt) {
  WorkerPool pool(3);
  const ClearSkyEnvironment described = sky_at(20, 3);
  EXPECT_EQ(paint_environment(described, {&pool, {}}).pixels, paint_environment(described).pixels);
}

TEST(ClearSkyEnvironment, IsNotPaintedAfterItsTime) {
  WorkerPool pool(2);
  for (WorkerPool* workers : {static_cast<WorkerPool*>(nullptr), &pool}) {
    try {
      paint_environment(sky_at(20, 3), {workers, Deadline(std::chrono::milliseconds(0))});
      FAIL() << "painted";
    } catch (const Error& error) {
      EXPECT_EQ(error.code, ErrorCode::kDeadlineExceeded);
    }
  }
}

glm::dvec3 light_vector_luminance(const Image& image) {
  glm::dvec3 vector;
  for (int axis = 0; axis < 3; ++axis)
    vector[axis] =
        luminance(integrate(image, [axis](const glm::dvec3& d) { return d.y > 0 ? d[axis] / kPi : 0.0; }));
  return vector;
}

// CIE 15:2004, D55 is a phase of daylight: at noon the card is white.
TEST(ClearSkyEnvironment, WhiteCardShowsOneNeutralAtNoonWarmInTheEveningBlueInTwilight) {
  const auto card = [](double elevation_deg, const glm::dvec3& normal) {
    ClearSkyEnvironment sky = sky_at(elevation_deg);
    sky.calibration = SkyCalibration::kWhiteCard;
    const Image image = paint_environment(sky);
    // Turned to the light; 1e-3: half rounding of the sun's few texels.
    EXPECT_NEAR(glm::length(light_vector_luminance(image)), 1, 1e-3) << elevation_deg;
    return irradiance_over_pi(image, normal);
  };
  const glm::dvec3 up(0, 1, 0), to_sun = towards(radians_from_degrees(-20), 0);
  const glm::dvec3 noon = card(60, up), evening = card(8, to_sun), twilight = card(-5, up);
  EXPECT_NEAR(noon.r / noon.g, 1, 0.1);  // D55 is the mean of many days
  EXPECT_NEAR(noon.b / noon.g, 1, 0.1);
  EXPECT_GT(evening.r, 1.3 * evening.g);
  EXPECT_GT(evening.g, 1.5 * evening.b);
  EXPECT_GT(twilight.b, 1.3 * twilight.r);
}

TEST(ClearSkyEnvironment, SunStandsWhereItIsAskedFor) {
  ClearSkyEnvironment sky = sky_at(30);
  sky.sun_azimuth_rad = radians_from_degrees(90);
  const Image image = paint_environment(sky);
  const glm::dvec3 wanted = towards(sky.sun_azimuth_rad, sky.sun_elevation_rad);
  glm::dvec3 brightest(0);
  double most = 0;
  for (int row = 0; row < image.extent.height; ++row)
    for (int column = 0; column < image.extent.width; ++column)
      if (const double value = texel(image, row, column)[1]; value > most) {
        most = value;
        brightest = direction(image, row, column);
      }
  EXPECT_GT(glm::dot(brightest, wanted), std::cos(radians_from_degrees(0.27)));
}

// The sun's own light is the difference to the sky without its disc, whatever the disc's size.
TEST(ClearSkyEnvironment, DiscOfAnySizeHasTheSameLight) {
  ClearSkyEnvironment sky = sky_at(50);
  const glm::dvec3 small = irradiance_over_pi(paint_environment(sky), {0, 1, 0});
  sky.sun_radius_rad = radians_from_degrees(5);
  const glm::dvec3 large = irradiance_over_pi(paint_environment(sky), {0, 1, 0});
  sky.sun_disc = false;
  const glm::dvec3 none = irradiance_over_pi(paint_environment(sky), {0, 1, 0});
  EXPECT_NEAR(small.g, large.g,
              3e-3 * small.g);  // a cap's mean cosine, and the air is deeper below its middle
  EXPECT_GT(small.g, 3 * none.g);
}

// Of a sun that is setting only the part above the horizon is there.
TEST(ClearSkyEnvironment, DiscEndsAtTheHorizon) {
  ClearSkyEnvironment sky = sky_at(0, 2);
  sky.sun_radius_rad = radians_from_degrees(5);
  const Image with = paint_environment(sky);
  sky.sun_disc = false;
  const Image without = paint_environment(sky);
  const auto at = [](const Image& image, double elevation) {
    const int row = int((90 - elevation) / 180 * image.extent.height);
    const double phi = kPi / 2 - radians_from_degrees(-20);
    const int column = int((phi / (2 * kPi) + 0.5) * image.extent.width);
    return double(texel(image, row, column)[0]);
  };
  EXPECT_GT(at(with, 4), 1.1 * at(without, 4));
  // The ground is brighter for it, but evenly.
  const double gain = at(with, -80) - at(without, -80);
  EXPECT_NEAR(at(with, -4) - at(without, -4), gain, 0.1 * gain);
}

}  // namespace
}  // namespace furnace
