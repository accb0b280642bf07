// GLSL functions against double-precision references.
#include <cmath>

#include <gtest/gtest.h>

#include "renderer/ibl/octahedral_atlas.hpp"
#include "renderer/image/color.hpp"
#include "renderer/scene/transform.hpp"
#include "tests/support/gl_fixture.hpp"
#include "tests/support/shader_harness.hpp"

namespace furnace {
namespace {

class ShadersGlTest : public test::GlTest {
 protected:
  std::vector<glm::vec4> run(const std::string& include, const std::string& body,
                             const std::vector<glm::vec4>& inputs) {
    return test::evaluate_glsl(context_, {include}, body, inputs);
  }
};

const double kAlphas[] = {0.0025, 0.01, 0.04, 0.09, 0.25, 0.49, 1.0};

double ggx_reference(double noh, double alpha) {
  const double d = noh * noh * (alpha * alpha - 1) + 1;
  return alpha * alpha / (kPi * d * d);
}

TEST_F(ShadersGlTest, ConstantsAreTheConstants) {
  const glm::vec4 c =
      run("lib/constants.glsl", "result = vec4(PI, TWO_PI, INV_PI, MIN_COSINE);", {glm::vec4(0)})[0];
  EXPECT_EQ(c.x, float(kPi));
  EXPECT_EQ(c.y, float(2 * kPi));
  EXPECT_EQ(c.z, float(1 / kPi));
}

TEST_F(ShadersGlTest, LevelCoordinateIsTheBakers) {
  std::vector<glm::vec4> inputs;
  for (int i = 0; i <= 100; ++i) inputs.emplace_back(float(i) / 100, 0, 0, 0);
  const auto results = run("lib/sphere.glsl", "result.x = level_coordinate(x.x);", inputs);
  for (std::size_t i = 0; i < inputs.size(); ++i)
    EXPECT_NEAR(results[i].x, level_coordinate(double(inputs[i].x)), 1e-6);
}

TEST_F(ShadersGlTest, SrgbTransferMatchesTheStandard) {
  std::vector<glm::vec4> inputs;
  for (int i = 0; i <= 255; ++i) inputs.emplace_back(float(i) / 255, 0.0031308f, 0.0031309f, 0);
  const auto results = run("lib/color.glsl", "result.rgb = srgb_from_linear(x.rgb);", inputs);
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    // A quarter of an 8-bit step: single-precision pow.
    EXPECT_NEAR(results[i].x, srgb_from_linear(double(inputs[i].x)), 0.25 / 255);
  }
}

TEST_F(ShadersGlTest, GgxMatchesItsReferenceAndIsNormalised) {
  for (const double alpha : kAlphas) {
    // Integral of D cos over the hemisphere = 1; theta by a substitution that crowds the peak: tan(theta) = alpha t.
    std::vector<glm::vec4> inputs;
    std::vector<double> weights;
    constexpr int kSteps = 2000;
    for (int i = 0; i < kSteps; ++i) {
      const double s = (i + 0.5) / kSteps;
      const double t = s / (1 - s);
      const double theta = std::atan(alpha * t);
      const double dtheta = alpha / (1 + alpha * alpha * t * t) / ((1 - s) * (1 - s)) / kSteps;
      inputs.emplace_back(float(std::cos(theta)), float(alpha), 0, 0);
      weights.push_back(2 * kPi * std::sin(theta) * std::cos(theta) * dtheta);
    }
    const auto results = run("lib/brdf.glsl", "result.x = D_GGX(x.x, x.y);", inputs);
    double sum = 0;
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      // cos is a float here: near the peak of a sharp lobe one ulp of it moves D; the reference takes the same float.
      const double reference = ggx_reference(double(inputs[i].x), double(inputs[i].y));
      EXPECT_NEAR(results[i].x, reference, 1e-3 * reference) << alpha << " " << inputs[i].x;
      sum +=
          ggx_reference(double(inputs[i].x), double(inputs[i].y)) > 0 ? weights[i] * double(results[i].x) : 0;
    }
    // For the sharpest lobes the float cosine itself quantises theta.
    EXPECT_NEAR(sum, 1, alpha < 0.02 ? 2e-2 : 1e-3) << alpha;
  }
}

TEST_F(ShadersGlTest, VisibilityIsReciprocalAndCorrelated) {
  std::vector<glm::vec4> inputs;
  for (const double alpha : kAlphas) {
    for (double v = 0.05; v <= 1; v += 0.19) {
      for (double l = 0.05; l <= 1; l += 0.19) inputs.emplace_back(float(v), float(l), float(alpha), 0);
    }
  }
  const auto results = run("lib/brdf.glsl",
                           "result.x = V_SmithGGXCorrelated(x.x, x.y, x.z);"
                           "result.y = V_SmithGGXCorrelated(x.y, x.x, x.z);",
                           inputs);
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const double v = double(inputs[i].x), l = double(inputs[i].y), a = double(inputs[i].z);
    // G2 / (4 l v) with G2 = 1 / (1 + lambda(v) + lambda(l)), Heitz 2014 eq. 99.
    const auto lambda = [&](double c) { return (std::sqrt(1 + a * a * (1 - c * c) / (c * c)) - 1) / 2; };
    const double reference = 1 / (1 + lambda(v) + lambda(l)) / (4 * v * l);
    EXPECT_NEAR(results[i].x, reference, 1e-4 * reference);
    EXPECT_NEAR(results[i].x, results[i].y, 1e-5 * reference);
  }
}

TEST_F(ShadersGlTest, FresnelRunsFromF0ToOne) {
  const auto results = run("lib/brdf.glsl", "result.rgb = F_Schlick(x.x, vec3(x.y), vec3(1.0));",
                           {{1, 0.04f, 0, 0}, {0, 0.04f, 0, 0}, {0.5f, 0.04f, 0, 0}});
  EXPECT_NEAR(results[0].r, 0.04, 1e-7);
  EXPECT_NEAR(results[1].r, 1, 1e-6);
  EXPECT_NEAR(results[2].r, 0.04 + 0.96 / 32, 1e-6);
}

TEST_F(ShadersGlTest, CompensatedSpecularOfAWhiteMetalIsOne) {
  std::vector<glm::vec4> inputs;
  for (float scale = 0.2f; scale < 0.9f; scale += 0.1f) inputs.emplace_back(scale, 0.05f, 0, 0);
  const auto results =
      run("lib/brdf.glsl", "result.rgb = specular_albedo(vec3(1.0), vec3(1.0), x.xy);", inputs);
  for (const glm::vec4& result : results) EXPECT_NEAR(result.r, 1, 1e-6);
}

std::vector<glm::vec4> sphere_directions() {
  std::vector<glm::vec4> directions;
  constexpr double kGoldenAngle = 2.39996322972865332;
  for (int i = 0; i < 500; ++i) {
    const double y = 1 - 2 * (i + 0.5) / 500, r = std::sqrt(1 - y * y);
    directions.emplace_back(float(r * std::cos(kGoldenAngle * i)), float(y),
                            float(r * std::sin(kGoldenAngle * i)), 0);
  }
  return directions;
}

TEST_F(ShadersGlTest, OctahedralMapIsThatOfTheBaker) {
  const auto directions = sphere_directions();
  const auto results = run("lib/sphere.glsl", "result.xy = octahedral_from_direction(x.xyz);", directions);
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const OctahedralUv uv = octahedral_from_direction(directions[i].x, directions[i].y, directions[i].z);
    EXPECT_NEAR(results[i].x, uv.u, 1e-5);
    EXPECT_NEAR(results[i].y, uv.v, 1e-5);
  }
}

TEST_F(ShadersGlTest, EquirectConventionIsThatOfTheContract) {
  // Row 0 up; the centre column looks to +X, u = 0.75 to +Z, u = 0.25 to -Z.
  const auto results = run("lib/sphere.glsl", "result.xy = equirect_from_direction(x.xyz);",
                           {{1, 0, 0, 0}, {0, 0, 1, 0}, {0, 0, -1, 0}, {0, 1, 0, 0}, {0, -1, 0, 0}});
  EXPECT_NEAR(results[0].x, 0.5, 1e-5);
  EXPECT_NEAR(results[0].y, 0.5, 1e-5);
  EXPECT_NEAR(results[1].x, 0.75, 1e-5);
  EXPECT_NEAR(results[2].x, 0.25, 1e-5);
  EXPECT_NEAR(results[3].y, 0, 1e-5);
  EXPECT_NEAR(results[4].y, 1, 1e-5);
  const auto directions = sphere_directions();
  const auto mapped = run("lib/sphere.glsl", "result.xy = equirect_from_direction(x.xyz);", directions);
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const glm::dvec3 d(directions[i]);
    // A tenth of a texel of an 8k map.
    EXPECT_NEAR(mapped[i].x, std::atan2(d.z, d.x) / (2 * kPi) + 0.5, 0.1 / 8192);
    EXPECT_NEAR(mapped[i].y, std::acos(d.y) / kPi, 0.1 / 4096);
  }
}

TEST_F(ShadersGlTest, WideningAlphaNeverSharpens) {
  const auto results =
      run("lib/brdf.glsl", "result.x = antialiased_alpha(2.0 * x.x * x.x, x.y, x.z);",
          {{0, 0.25f, 1, 0}, {0.1f, 0.25f, 1, 0}, {10, 0.25f, 1, 0}, {0.1f, 0.25f, 0.1f, 0}});
  EXPECT_NEAR(results[0].x, 0.25, 1e-6);
  EXPECT_GT(results[1].x, 0.25);
  EXPECT_NEAR(results[2].x, std::sqrt(0.25 * 0.25 + 0.18), 1e-5);  // kappa bounds it
  EXPECT_LT(results[3].x, results[1].x);                           // more samples, less widening
}

}  // namespace
}  // namespace furnace
