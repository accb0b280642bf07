// The lobes of layers and of older models against double-precision references.
#include <array>
#include <cmath>
#include <complex>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "renderer/scene/transform.hpp"
#include "tests/support/gl_fixture.hpp"
#include "tests/support/reference/lobe.hpp"
#include "tests/support/shader_harness.hpp"

namespace furnace {
namespace {

class LayersGlTest : public test::GlTest {
 protected:
  std::vector<glm::vec4> run(const std::string& include, const std::string& body,
                             const std::vector<glm::vec4>& inputs) {
    return test::evaluate_glsl(context_, {include}, body, inputs);
  }
};

// A midpoint rule over the hemisphere: weight and direction, by cos^2 and azimuth.
struct Node {
  double weight, x, y, z;
};
std::vector<Node> hemisphere(int side) {
  std::vector<Node> nodes;
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      const double z = (i + 0.5) / side, sine = std::sqrt(1 - z * z), phi = 2 * kPi * (j + 0.5) / side;
      nodes.push_back({2 * kPi / (double(side) * side), sine * std::cos(phi), sine * std::sin(phi), z});
    }
  }
  return nodes;
}

std::vector<glm::vec4> directions_of(const std::vector<Node>& nodes, float w = 0) {
  std::vector<glm::vec4> inputs;
  for (const Node& n : nodes) inputs.emplace_back(float(n.x), float(n.y), float(n.z), w);
  return inputs;
}

TEST_F(LayersGlTest, AnisotropicDistributionIsNormalisedAndRoundWhereBothWidthsAre) {
  const std::vector<Node> nodes = hemisphere(400);
  const auto results = run("lib/brdf_layers.glsl",
                           "result = vec4(D_GGX_anisotropic(x.z, x.x, x.y, 0.6, 0.2),"
                           "D_GGX_anisotropic(x.z, x.x, x.y, 0.3, 0.3), D_GGX(x.z, 0.3), 0.0);",
                           directions_of(nodes));
  double sum = 0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    sum += nodes[i].weight * nodes[i].z * double(results[i].x);
    // Near the peak D_GGX is written without the cancellation that single precision leaves here.
    ASSERT_NEAR(results[i].y, results[i].z, 2e-4 * double(results[i].z));
  }
  EXPECT_NEAR(sum, 1, 1e-3);
}

TEST_F(LayersGlTest, AnisotropicMaskingIsReciprocalAndRoundWhereBothWidthsAre) {
  std::vector<glm::vec4> inputs;
  for (double v = 0.1; v < 1; v += 0.2)
    for (double l = 0.1; l < 1; l += 0.2)
      for (double turn = 0; turn < 6; turn += 1.1) inputs.emplace_back(float(v), float(l), float(turn), 0);
  const auto results =
      run("lib/brdf_layers.glsl",
          "float sv = sqrt(1.0 - x.x * x.x), sl = sqrt(1.0 - x.y * x.y);"
          "vec2 v = sv * vec2(cos(x.z), sin(x.z)), l = sl * vec2(cos(2.0 * x.z), -sin(x.z + 1.0));"
          "l *= sl / length(l);"
          "result = vec4(V_SmithGGXAnisotropic(x.x, x.y, v.x, v.y, l.x, l.y, 0.7, 0.2),"
          "V_SmithGGXAnisotropic(x.y, x.x, l.x, l.y, v.x, v.y, 0.7, 0.2),"
          "V_SmithGGXAnisotropic(x.x, x.y, v.x, v.y, l.x, l.y, 0.4, 0.4),"
          "V_SmithGGXCorrelated(x.x, x.y, 0.4));",
          inputs);
  for (const glm::vec4& r : results) {
    EXPECT_NEAR(r.x, r.y, 1e-5f * r.x);
    EXPECT_NEAR(r.z, r.w, 1e-4f * r.w);
  }
}

TEST_F(LayersGlTest, CharlieIsNormalisedAndReflectsItsAlbedo) {
  const std::vector<Node> nodes = hemisphere(500);
  for (const double roughness : {0.3, 0.6, 1.0}) {
    const double alpha = roughness * roughness, NoV = 0.4;
    const std::vector<glm::vec4> inputs = directions_of(nodes, float(alpha));
    const auto results =
        run("lib/brdf_layers.glsl",
            "vec3 v = vec3(sqrt(1.0 - 0.16), 0.0, 0.4);"
            "vec3 h = normalize(v + x.xyz);"
            "result = vec4(D_Charlie(x.z, x.w), D_Charlie(h.z, x.w) * V_Charlie(0.4, x.z, x.w), "
            "V_Charlie(x.z, 0.4, x.w), V_Charlie(0.4, x.z, x.w));",
            inputs);
    double normal = 0, albedo = 0;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      normal += nodes[i].weight * nodes[i].z * double(results[i].x);
      albedo += nodes[i].weight * nodes[i].z * double(results[i].y);
      ASSERT_NEAR(results[i].z, results[i].w, 1e-5f * results[i].w);
    }
    EXPECT_NEAR(normal, 1, 2e-3) << roughness;
    EXPECT_NEAR(albedo, reference::integrate_sheen(NoV, roughness, 500), 2e-3) << roughness;
  }
}

// The direction of the first moment of the lobe times n.l, which the fit leaves by at most 17 degrees.
TEST_F(LayersGlTest, CharlieLeansToTheViewer) {
  const std::vector<Node> nodes = hemisphere(300);
  for (const double roughness : {0.2, 0.4, 0.6, 0.8, 1.0}) {
    const std::vector<glm::vec4> inputs = directions_of(nodes, float(roughness));
    for (const double NoV : {0.2, 0.5, 0.8}) {
      const auto results =
          run("lib/brdf_layers.glsl",
              fmt::format("float NoV = {};"
                          "vec3 h = normalize(vec3(sqrt(1.0 - NoV * NoV), 0.0, NoV) + x.xyz);"
                          "float alpha = x.w * x.w;"
                          "result.x = D_Charlie(h.z, alpha) * V_Charlie(NoV, x.z, alpha);"
                          "result.y = charlie_lean(x.w);",
                          NoV),
              inputs);
      double across = 0, along = 0;
      for (std::size_t i = 0; i < nodes.size(); ++i) {
        const double weight = nodes[i].weight * nodes[i].z * double(results[i].x);
        across += weight * nodes[i].x;
        along += weight * nodes[i].z;
      }
      EXPECT_NEAR(double(results[0].y) * 180 / kPi, std::atan2(across, along) * 180 / kPi, 17)
          << roughness << " " << NoV;
    }
  }
}

// What a plane sends back of a light seen in the mirror direction of a view at right angles is at most what arrives.
TEST_F(LayersGlTest, OlderLobesKeepTheirEnergy) {
  const std::vector<Node> nodes = hemisphere(500);
  for (const float alpha : {0.3f, 0.6f, 1.f}) {
    const std::vector<glm::vec4> inputs = directions_of(nodes, alpha);
    const auto results =
        run("lib/brdf_layers.glsl",
            "vec3 h = normalize(vec3(0.0, 0.0, 1.0) + x.xyz);"
            "result = vec4(phong_lobe(x.z, x.w), blinn_phong_lobe(h.z, x.w), blinn_exponent(x.w), 0.0);",
            inputs);
    double phong = 0, blinn = 0;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      phong += nodes[i].weight * nodes[i].z * double(results[i].x);
      blinn += nodes[i].weight * nodes[i].z * double(results[i].y);
    }
    EXPECT_NEAR(results[0].z, 2 / (alpha * alpha) - 2, 1e-3);
    EXPECT_NEAR(phong, 1, 5e-3) << alpha;  // (s + 2) / (2 pi) times the integral of cos^(s + 1)
    EXPECT_NEAR(blinn, 1, 0.07) << alpha;  // theirs is a fit
  }
}

TEST_F(LayersGlTest, SchlickBeckmannIsItsFormula) {
  const auto results = run("lib/brdf_layers.glsl", "result.x = V_SchlickBeckmann(x.x, x.y, x.z);",
                           {{0.3f, 0.8f, 0.5f, 0}, {1, 1, 0, 0}});
  const double k = 1.5 * 1.5 / 8, g = 0.3 / (0.3 * (1 - k) + k) * 0.8 / (0.8 * (1 - k) + k);
  EXPECT_NEAR(results[0].x, g / (4 * 0.3 * 0.8), 1e-5);
  EXPECT_NEAR(results[1].x, 0.25, 1e-6);
}

// Airy's sum for one wavelength, both polarisations: light that has no phase to lose.
double airy_reflectance(double cosine, double film_ior, double base_ior, double thickness_nm,
                        double wavelength_nm) {
  const double inner = std::sqrt(1 - (1 - cosine * cosine) / (film_ior * film_ior));
  const double base = std::sqrt(1 - (1 - cosine * cosine) / (base_ior * base_ior));
  const std::complex<double> turn =
      std::polar(1.0, 4 * kPi * film_ior * thickness_nm * inner / wavelength_nm);
  const auto sum = [&](double r12, double r23) {
    return std::norm((r12 + r23 * turn) / (1.0 + r12 * r23 * turn));
  };
  const double s = sum((cosine - film_ior * inner) / (cosine + film_ior * inner),
                       (film_ior * inner - base_ior * base) / (film_ior * inner + base_ior * base));
  const double p = sum((film_ior * cosine - inner) / (film_ior * cosine + inner),
                       (base_ior * inner - film_ior * base) / (base_ior * inner + film_ior * base));
  return 0.5 * (s + p);
}

// Under right angles Schlick's approximation is exact, so the fit can be judged by Airy's: the mean over the wavelengths that
// a channel sees. Gaussians of 30 nm round 610, 545 and 450 nm stand for Rec. 709's, whose red takes some violet and some green
// with a minus sign: a third of the fringes' height, 0.06, is left for that.
TEST_F(LayersGlTest, ThinFilmHasTheColoursOfAirysSum) {
  std::vector<glm::vec4> inputs;
  for (float thickness = 100; thickness <= 500; thickness += 25)
    inputs.emplace_back(1.f, 1.33f, thickness, 0.04f);
  const auto results =
      run("lib/thin_film.glsl", "result.rgb = thin_film_reflectance(x.x, x.y, x.z, vec3(x.w));", inputs);
  const double kCentre[3] = {610, 545, 450};
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      double mean = 0, weights = 0;
      for (double nm = kCentre[c] - 90; nm <= kCentre[c] + 90; nm += 3) {
        const double weight = std::exp(-0.5 * std::pow((nm - kCentre[c]) / 30, 2));
        mean += weight * airy_reflectance(1, double(inputs[i].y), 1.5, double(inputs[i].z), nm);
        weights += weight;
      }
      EXPECT_NEAR(results[i][c], mean / weights, 0.02) << "nm " << inputs[i].z << " channel " << c;
    }
  }
}

TEST_F(LayersGlTest, AFilmWithoutThicknessIsNone) {
  const auto results =
      run("lib/thin_film.glsl", "result.rgb = thin_film_reflectance(x.x, x.y, 0.0, vec3(x.w));",
          {{1, 1.5f, 0, 0.04f}, {1, 1.5f, 0, 0.5f}});
  EXPECT_NEAR(results[0].r, 0.04, 1e-5);
  EXPECT_NEAR(results[1].g, 0.5, 1e-5);
}

TEST_F(LayersGlTest, F0OfAReflectanceGivesItBack) {
  const auto results = run("lib/thin_film.glsl",
                           "vec3 f0 = f0_of_reflectance(vec3(x.x), x.y);"
                           "result.rgb = F_Schlick(x.y, f0, vec3(1.0));",
                           {{0.3f, 0.9f, 0, 0}, {0.5f, 0.4f, 0, 0}});
  EXPECT_NEAR(results[0].r, 0.3, 1e-5);
  EXPECT_NEAR(results[1].r, 0.5, 1e-5);
}

}  // namespace
}  // namespace furnace
