// Tone curves and grading against double-precision references and what is known of them.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "renderer/image/color.hpp"
#include "tests/support/gl_fixture.hpp"
#include "tests/support/shader_harness.hpp"

namespace furnace {
namespace {

using Rows = double[3][3];

glm::dvec3 times(const Rows& rows, const glm::dvec3& c) {
  const auto row = [&](int i) { return rows[i][0] * c.x + rows[i][1] * c.y + rows[i][2] * c.z; };
  return {row(0), row(1), row(2)};
}

template <class Function>
glm::dvec3 each(const glm::dvec3& c, Function&& function) {
  return {function(c.x), function(c.y), function(c.z)};
}

glm::dvec3 aces_reference(const glm::dvec3& c) {
  constexpr Rows kIn = {
      {0.59719, 0.35458, 0.04823}, {0.07600, 0.90834, 0.01566}, {0.02840, 0.13383, 0.83777}};
  constexpr Rows kOut = {
      {1.60475, -0.53108, -0.07367}, {-0.10208, 1.10813, -0.00605}, {-0.00327, -0.07276, 1.07602}};
  return times(kOut, each(times(kIn, c / 0.6), [](double v) {
                 return (v * v + 0.0245786 * v - 0.000090537) / (0.983729 * v * v + 0.4329510 * v + 0.238081);
               }));
}

glm::dvec3 agx_reference(const glm::dvec3& c) {
  constexpr Rows kWide = {{0.6274, 0.3293, 0.0433}, {0.0691, 0.9195, 0.0113}, {0.0164, 0.0880, 0.8956}};
  constexpr Rows kNarrow = {
      {1.6605, -0.5876, -0.0728}, {-0.1246, 1.1329, -0.0083}, {-0.0182, -0.1006, 1.1187}};
  constexpr Rows kInset = {{0.856627153315983, 0.0951212405381588, 0.0482516061458583},
                           {0.137318972929847, 0.761241990602591, 0.101439036467562},
                           {0.11189821299995, 0.0767994186031903, 0.811302368396859}};
  constexpr Rows kOutset = {{1.1271005818144368, -0.11060664309660323, -0.016493938717834573},
                            {-0.1413297634984383, 1.157823702216272, -0.016493938717834257},
                            {-0.14132976349843826, -0.11060664309660294, 1.2519364065950405}};
  const auto sigmoid = [](double v) {
    const double x = std::clamp((std::log2(std::max(v, 1e-10)) + 12.47393) / (4.026069 + 12.47393), 0.0, 1.0);
    return 15.5 * std::pow(x, 6) - 40.14 * std::pow(x, 5) + 31.96 * std::pow(x, 4) - 6.868 * x * x * x +
           0.4298 * x * x + 0.1191 * x - 0.00232;
  };
  const glm::dvec3 display = times(kOutset, each(times(kInset, times(kWide, c)), sigmoid));
  return times(kNarrow, each(display, [](double v) { return std::pow(std::max(v, 0.0), 2.2); }));
}

glm::dvec3 reinhard_reference(const glm::dvec3& c) {
  return c / (1 + luminance_rec709(c.x, c.y, c.z));
}

class ToneGlTest : public test::GlTest {
 protected:
  std::vector<glm::vec4> run(const std::string& include, const std::string& body,
                             const std::vector<glm::vec4>& inputs) {
    return test::evaluate_glsl(context_, {include}, body, inputs);
  }

  // Greys over thirty stops, and colours.
  static std::vector<glm::vec4> radiances() {
    std::vector<glm::vec4> inputs = {{0, 0, 0, 0}};
    for (int half_stops = -30; half_stops <= 30; ++half_stops) {
      const float grey = std::exp2(0.5f * float(half_stops));
      inputs.emplace_back(grey, grey, grey, 0);
      inputs.emplace_back(grey, 0.1f * grey, 0.f, 0);
      inputs.emplace_back(0.f, 0.3f * grey, grey, 0);
    }
    return inputs;
  }

  template <class Reference>
  void expect_curve(const char* name, Reference&& reference, double tolerance) {
    const auto inputs = radiances();
    const auto results = run("lib/tone.glsl", "result.rgb = " + std::string(name) + "(x.rgb);", inputs);
    double brightest_before = -1;
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      SCOPED_TRACE(testing::Message()
                   << name << " " << inputs[i].r << " " << inputs[i].g << " " << inputs[i].b);
      const glm::dvec3 expected = reference(glm::dvec3(inputs[i]));
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(results[i][c], expected[c], tolerance);
      if (inputs[i].r != inputs[i].b) continue;
      // A grey stays one, and rises.
      EXPECT_NEAR(results[i].r, results[i].g, 2e-3);
      EXPECT_NEAR(results[i].b, results[i].g, 2e-3);
      EXPECT_GE(results[i].g, brightest_before - 1e-6);
      brightest_before = results[i].g;
    }
  }
};

// Single precision through two matrices and a pow: a fortieth of an 8-bit step.
constexpr double kSinglePrecision = 1e-4;

TEST_F(ToneGlTest, AcesIsItsFit) {
  expect_curve("tone_aces", aces_reference, kSinglePrecision);
}

TEST_F(ToneGlTest, AgxIsItsPolynomial) {
  expect_curve("tone_agx", agx_reference, kSinglePrecision);
}

TEST_F(ToneGlTest, ReinhardIsThatOfLuminance) {
  expect_curve("tone_reinhard", reinhard_reference, kSinglePrecision);
}

// Where the curves put mid grey, by their authors' pictures: none far from 0.18, AgX at half of a display's signal.
TEST_F(ToneGlTest, MidGreyStaysMidGrey) {
  const auto of = [&](const char* name) {
    return run("lib/tone.glsl", "result.rgb = " + std::string(name) + "(x.rgb);",
               {{0.18f, 0.18f, 0.18f, 0}})[0]
        .g;
  };
  EXPECT_NEAR(std::pow(of("tone_agx"), 1 / 2.2), 0.5, 0.01);
  EXPECT_NEAR(of("tone_aces"), 0.18, 0.04);
  EXPECT_NEAR(of("tone_reinhard"), 0.18 / 1.18, 1e-6);
}

// The sun through each curve is finite.
TEST_F(ToneGlTest, HugeRadianceIsWhite) {
  for (const char* name : {"tone_aces", "tone_agx", "tone_reinhard", "tone_pbr_neutral"}) {
    const glm::vec4 white =
        run("lib/tone.glsl", "result.rgb = " + std::string(name) + "(x.rgb);", {{1e15f, 1e15f, 1e15f, 0}})[0];
    for (int c = 0; c < 3; ++c) {
      EXPECT_GT(white[c], 0.95) << name;
      EXPECT_LT(white[c], 1.05) << name;
    }
  }
}

TEST_F(ToneGlTest, NeutralCurveKeepsBaseColours) {
  const auto results =
      run("lib/tone.glsl", "result.rgb = tone_pbr_neutral(x.rgb);",
          {{0.5f, 0.3f, 0.2f, 0}, {0.04f, 0.04f, 0.04f, 0}, {100, 100, 100, 0}, {50, 1, 1, 0}, {0, 0, 0, 0}});
  // Below the shoulder: less the Fresnel offset of 0.04.
  EXPECT_NEAR(results[0].r, 0.46, 1e-6);
  EXPECT_NEAR(results[0].b, 0.16, 1e-6);
  // In the toe: x - (x - 6.25 x^2) = 6.25 x^2.
  EXPECT_NEAR(results[1].r, 6.25 * 0.04 * 0.04, 1e-6);
  EXPECT_GT(results[2].r, 0.99);
  EXPECT_LT(results[2].r, 1.0);
  EXPECT_LT(results[3].r, 1.0);
  EXPECT_GT(results[3].g, 0.1);  // a bright red desaturates
  EXPECT_EQ(results[4].r, 0);
}

TEST_F(ToneGlTest, ContrastTurnsAboutMidGreyAndSaturationAboutLuminance) {
  const auto graded = [&](const char* contrast_and_saturation, const glm::vec4& color) {
    return run("lib/grade.glsl",
               "result.rgb = graded(x.rgb, mat3(1.0), " + std::string(contrast_and_saturation) + ");",
               {color})[0];
  };
  const glm::vec4 contrasted = graded("2.0, 1.0", {0.18f, 0.36f, 0.09f, 0});
  EXPECT_NEAR(contrasted.r, 0.18, 1e-6);
  EXPECT_NEAR(contrasted.g, 0.72, 1e-5);
  EXPECT_NEAR(contrasted.b, 0.045, 1e-6);
  const glm::vec4 color(0.6f, 0.2f, 0.1f, 0);
  const double luminance = luminance_rec709(0.6, 0.2, 0.1);
  const glm::vec4 grey = graded("1.0, 0.0", color), vivid = graded("1.0, 1.5", color);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(grey[c], luminance, 1e-6);
    EXPECT_NEAR(vivid[c], std::max(luminance + 1.5 * (double(color[c]) - luminance), 0.0), 1e-6);
  }
  // What no display shows does not become what no curve can take.
  EXPECT_TRUE(std::isfinite(graded("4.0, 4.0", {1e30f, 0, 0, 0}).r));
}

}  // namespace
}  // namespace furnace
