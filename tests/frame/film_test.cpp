// Exposure and white balance against published numbers.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "renderer/frame/exposure.hpp"
#include "renderer/frame/white_balance.hpp"

namespace furnace {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

TEST(Exposure, EvIsThatOfThePhysicalCamera) {
  // ISO 12232: 78 / 65 = 1.2 cd/m2 saturate a sensor at EV100 0.
  EXPECT_NEAR(std::exp2(exposure_ev_of_ev100(0)), 65.0 / 78, 1e-12);
  EXPECT_NEAR(exposure_ev_of_ev100(15) - exposure_ev_of_ev100(14), -1, 1e-12);
}

Image picture_of(std::initializer_list<glm::vec4> pixels) {
  Image image = make_image({int(pixels.size()), 1}, 4, SampleType::kFloat32, ColorSpace::kLinear);
  std::size_t i = 0;
  for (const glm::vec4& pixel : pixels)
    for (int c = 0; c < 4; ++c) image.samples<float>()[i++] = pixel[c];
  return image;
}

TEST(Meter, TakesTheGeometricMean) {
  const glm::vec4 dark(0.01f, 0.01f, 0.01f, 1), bright(4, 4, 4, 1);
  EXPECT_NEAR(metered_ev(picture_of({dark, bright})), std::log2(0.18 / 0.2), 0.005);  // told in hundredths
  EXPECT_EQ(metered_ev(picture_of({{0.18f, 0.18f, 0.18f, 1}})), 0);
  EXPECT_EQ(metered_ev(picture_of({{0, 0.18f / 0.7152f / 4, 0, 1}})), 2);
}

TEST(Meter, WeighsByAlphaAndSeesStraightColours) {
  const glm::vec4 dark(0.01f, 0.01f, 0.01f, 1), veil(1, 1, 1, 0.25f);  // premultiplied: 4
  const double mean = std::exp2((std::log2(0.01) + 0.25 * std::log2(4.0)) / 1.25);
  EXPECT_NEAR(metered_ev(picture_of({dark, veil})), std::log2(0.18 / mean), 0.005);
  EXPECT_EQ(metered_ev(picture_of({dark, {0, 0, 0, 0}, {0, 0, 0, 1}, {0, 0, 0, 0.5f}})),
            metered_ev(picture_of({dark})));
}

TEST(Meter, IsFiniteWhateverItSees) {
  EXPECT_EQ(metered_ev(picture_of({{0, 0, 0, 0}, {0, 0, 0, 1}})), 0);
  EXPECT_TRUE(std::isfinite(metered_ev(picture_of({glm::vec4(kInfinity, 1, 1, 1)}))));
  EXPECT_EQ(metered_ev(picture_of({glm::vec4(std::nanf(""), 1, 1, 1)})), 0);
}

TEST(Meter, DrawsEverySizeOfAPictureAlike) {
  RenderSpec spec;
  spec.output.width = 4096;
  spec.output.height = 2048;
  spec.camera.metering = AutoExposure{};
  spec.camera.exposure_ev = 3;
  const FramePlan meter = plan_meter(spec, 1024);
  EXPECT_EQ(meter.picture, (Extent{256, 128}));
  EXPECT_EQ(meter.exposure, 1);
  EXPECT_EQ(meter.film_type, SampleType::kFloat32);
  spec.output.width = 512;
  spec.output.height = 256;
  EXPECT_EQ(plan_meter(spec, 1024).picture, meter.picture);
  spec.output.height = 1;
  EXPECT_EQ(plan_meter(spec, 1024).picture, (Extent{256, 1}));
}

TEST(FramePlan, ExposureIsTheCompensatedMeter) {
  RenderSpec spec;
  spec.camera.exposure_ev = 1;
  EXPECT_EQ(plan_frame(spec, 64, 5).exposure, 2);
  spec.camera.metering = AutoExposure{};
  EXPECT_EQ(plan_frame(spec, 64, 5).exposure, 64);
  spec.camera.metering = PhysicalExposure{3};
  EXPECT_NEAR(plan_frame(spec, 64, 5).exposure, 2 / (1.2 * 8), 1e-12);
}

TEST(FramePlan, AnIdentityGradeIsNone) {
  RenderSpec spec;
  EXPECT_FALSE(plan_frame(spec, 64).grade);
  spec.output.grade.saturation = 0.5;
  const FramePlan plan = plan_frame(spec, 64);
  ASSERT_TRUE(plan.grade);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) EXPECT_NEAR(plan.grade->white_balance[i][j], i == j, 1e-6);
}

// CIE 15:2004, tables T.3 and 11.1: standard illuminants.
TEST(WhiteBalance, LocusGoesThroughTheStandardIlluminants) {
  struct {
    double kelvin, x, y;
  } const kIlluminants[] = {{2856, 0.44757, 0.40745},   // A
                            {5003, 0.34567, 0.35850},   // D50
                            {5503, 0.33242, 0.34743},   // D55
                            {6504, 0.31272, 0.32903},   // D65
                            {7504, 0.29902, 0.31485}};  // D75
  for (const auto& light : kIlluminants) {
    const glm::dvec2 xy = white_chromaticity(light.kelvin, 0);
    // Krystek's fit is good to about 1e-4 in u and v, which y shows three- to fourfold; D is by its nominal kelvin.
    EXPECT_NEAR(xy.x, light.x, 4e-4) << light.kelvin;
    EXPECT_NEAR(xy.y, light.y, 4e-4) << light.kelvin;
  }
}

TEST(WhiteBalance, LocusHasNoStep) {
  for (double kelvin = 1667; kelvin < 25000; kelvin *= 1.001) {
    const glm::dvec2 step = white_chromaticity(kelvin * 1.001, 0) - white_chromaticity(kelvin, 0);
    EXPECT_LT(glm::length(step), 4e-4) << kelvin;
    EXPECT_LT(step.x, 0) << kelvin;
  }
}

// Lindbloom 2017, "Chromatic Adaptation": Bradford from D65 to D50, of the ASTM's whites.
TEST(WhiteBalance, AdaptationIsBradfords) {
  constexpr double kRows[3][3] = {{1.0478112, 0.0228866, -0.0501270},
                                  {0.0295424, 0.9904844, -0.0170491},
                                  {-0.0092345, 0.0150436, 0.7521316}};
  const auto xy = [](double x, double y, double z) { return glm::dvec2(x, y) / (x + y + z); };
  const glm::dmat3 adapted = adaptation(xy(0.95047, 1, 1.08883), xy(0.96422, 1, 0.82521));
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) EXPECT_NEAR(adapted[column][row], kRows[row][column], 1e-6);
}

TEST(WhiteBalance, TheLightThatIsNamedBecomesWhite) {
  // Illuminant A of luminance 1 in linear Rec.709, by the standard's rounded matrix.
  const glm::dvec3 lamp(1.84517, 0.82623, 0.23332);
  const glm::dvec3 white = white_balance(2856, 0) * lamp;
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(white[c], 1, 5e-3);  // Krystek's 1e-4
  const glm::dvec3 neutral = white_balance(6504, 0) * glm::dvec3(1);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(neutral[c], 1, 1e-9);
}

// A tint may lead out of the colours that exist; gains stay those of a picture.
TEST(WhiteBalance, EveryLightOfTheRangeCanBeBalanced) {
  for (const double kelvin : {1667.0, 2000.0, 3000.0, 6504.0, 25000.0}) {
    for (const double tint : {-150.0, -30.0, 0.0, 30.0, 150.0}) {
      const glm::dmat3 balance = white_balance(kelvin, tint);
      for (int i = 0; i < 3; ++i) {
        EXPECT_GT(balance[i][i], 0) << kelvin << " " << tint;
        EXPECT_LT(balance[i][i], 30) << kelvin << " " << tint;
      }
      EXPECT_GT(glm::determinant(balance), 0) << kelvin << " " << tint;
    }
  }
}

TEST(WhiteBalance, HigherKelvinIsWarmerAndTintIsMagenta) {
  const glm::dvec3 warm = white_balance(9000, 0) * glm::dvec3(1);
  EXPECT_GT(warm.r, 1.05);
  EXPECT_LT(warm.b, 0.9);
  for (const double kelvin : {2000.0, 4500.0, 6504.0, 20000.0}) {
    const glm::dvec3 white = glm::inverse(white_balance(kelvin, 0)) * glm::dvec3(1);
    const glm::dvec3 magenta = white_balance(kelvin, 30) * white;
    EXPECT_LT(magenta.g, magenta.r) << kelvin;
    EXPECT_LT(magenta.g, magenta.b) << kelvin;
  }
}

}  // namespace
}  // namespace furnace
