#include "renderer/ibl/riemann.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string>

#include <gtest/gtest.h>

#include "renderer/base/error.hpp"
#include "renderer/base/file.hpp"
#include "renderer/base/worker_pool.hpp"
#include "renderer/ibl/sphere_transform.hpp"
#include "renderer/ibl/zonal_kernel.hpp"
#include "renderer/image/decode.hpp"
#include "tests/support/reference/convolution.hpp"

namespace furnace {
namespace {

using reference::Rgb;

constexpr double kPi = std::numbers::pi;
constexpr Extent kQuads = {256, 128};
// The design's bar for this cut.
constexpr double kBar = 2e-3;
// What the sum of area cos / pi may differ from 1: the midpoint rule's h^2 / 8 for the polar step h = 90 / 128 degrees.
// That great circles are not parallels takes about as much away again: -6.3e-6 remain.
constexpr double kCutError = 2e-5;

Image constant_map(Extent extent, const Rgb& value) {
  Image map = make_image(extent, 3, SampleType::kFloat32, ColorSpace::kLinear);
  for (std::size_t k = 0; k < map.samples<float>().size(); ++k)
    map.samples<float>()[k] = static_cast<float>(value[k % 3]);
  return map;
}

Image riemann(const Image& map, int rows, int threads = 2) {
  WorkerPool pool(threads);
  return riemann_irradiance(map, kQuads, rows, pool, {});
}

// By spherical harmonics, at the centres of the same texels: no reading between texels blurs the comparison.
Image spectral(const Image& map, int rows) {
  WorkerPool pool(2);
  BakeWork work(pool);
  const int bands = std::min(512, map.extent.height);
  const LegendreTable table(bands);
  const HarmonicCoefficients coefficients = analyse(spectrum_of_equirect(map, work), table, work);
  const std::vector<double> kernel = zonal_coefficients(GgxKernel(1), 1, bands);
  return equirect_of_spectrum(synthesise(coefficients, table, kernel, rows, work), 2 * rows, work);
}

double error_of(const Image& computed, const Image& expected) {
  std::vector<Rgb> a, b;
  for (int j = 0; j < computed.extent.height; ++j) {
    for (int i = 0; i < computed.extent.width; ++i) {
      a.push_back(reference::texel_value(computed, i, j));
      b.push_back(reference::texel_value(expected, i, j));
    }
  }
  return reference::relative_rmse(a, b);
}

TEST(SphericalTriangle, ClosedForms) {
  EXPECT_NEAR(spherical_triangle_area({1, 0, 0}, {0, 1, 0}, {0, 0, 1}), kPi / 2, 1e-15);
  EXPECT_NEAR(spherical_triangle_area({0, 0, 1}, {0, 1, 0}, {1, 0, 0}), kPi / 2, 1e-15);
  // A tetrahedron's face: angles of 2 pi / 3, a quarter of the sphere.
  const double a = 1 / std::sqrt(3);
  EXPECT_NEAR(spherical_triangle_area({a, a, a}, {a, -a, -a}, {-a, a, -a}), kPi, 1e-14);
  EXPECT_EQ(spherical_triangle_area({1, 0, 0}, {1, 0, 0}, {0, 1, 0}), 0);
  // Tiny ones are flat; by their angles this one would be lost in rounding.
  const double leg = 1e-7, cosine = std::sqrt(1 - leg * leg);
  const double area = spherical_triangle_area({0, 1, 0}, {leg, cosine, 0}, {0, cosine, leg});
  EXPECT_NEAR(area / (leg * leg / 2), 1, 1e-8);
}

TEST(HemisphereQuads, CoverTheHemisphereAndWeighPi) {
  for (const Extent quads : {Extent{3, 1}, Extent{16, 5}, kQuads}) {
    const std::vector<double> areas = hemisphere_quad_areas(quads);
    ASSERT_EQ(areas.size(), std::size_t(quads.height));
    const double area = quads.width * std::accumulate(areas.begin(), areas.end(), 0.0);
    EXPECT_NEAR(area / (2 * kPi), 1, 1e-12) << quads.width;
  }
  const std::vector<double> areas = hemisphere_quad_areas(kQuads);
  double weighed = 0;
  for (int ring = 0; ring < kQuads.height; ++ring)
    weighed += kQuads.width * areas[ring] * std::cos(kPi / 2 * (ring + 0.5) / kQuads.height);
  EXPECT_NEAR(weighed / kPi, 1, kCutError);
}

TEST(Riemann, ConstantMapStaysConstantThoughNothingIsNormalised) {
  const Image result = riemann(constant_map({64, 32}, {1, 0.25, 3}), 6);
  EXPECT_EQ(result.extent, (Extent{12, 6}));
  const Rgb expected = {1, 0.25, 3};
  for (int j = 0; j < 6; ++j)
    for (int i = 0; i < 12; ++i)
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(reference::texel_value(result, i, j)[c] / expected[c], 1, kCutError);
}

TEST(Riemann, LinearMapInClosedFormEachWayUp) {
  // L = 1 + a.d gives irradiance / pi = 1 + 2/3 a.n (Ramamoorthi and Hanrahan 2001).
  const Rgb a = {0.5, 0.3, -0.4};
  Image map = constant_map({256, 128}, {});
  for (int j = 0; j < 128; ++j) {
    for (int i = 0; i < 256; ++i) {
      const auto d = reference::texel_direction(map.extent, i, j).unit();
      for (int c = 0; c < 3; ++c) map.samples<float>()[(j * 256 + i) * 3 + c] = float(1 + a[c] * d[c]);
    }
  }
  for (const int rows : {5, 8}) {
    const Image result = riemann(map, rows);
    for (int j = 0; j < rows; ++j) {
      for (int i = 0; i < 2 * rows; ++i) {
        const auto n = reference::texel_direction(result.extent, i, j).unit();
        // Averages over 1.4 degrees and the cut itself: below 1e-4 each.
        for (int c = 0; c < 3; ++c)
          EXPECT_NEAR(reference::texel_value(result, i, j)[c], 1 + 2.0 / 3 * a[c] * n[c], 2e-4);
      }
    }
  }
}

TEST(Riemann, OneTexelOfSunIsACosine) {
  // 1k maps have a sun of a texel or two; at the seam, beside it, and in the zenith.
  constexpr double kSun = 1e5, kSky = 0.01;
  const Extent extent = {1024, 512};
  for (const auto& [column, row] : {std::pair{0, 200}, std::pair{700, 310}, std::pair{40, 0}}) {
    Image map = constant_map(extent, {kSky, kSky, kSky});
    map.samples<float>()[(row * extent.width + column) * 3] = kSun;
    const auto sun = reference::texel_direction(extent, column, row);
    const double area = 4 * kPi / extent.width * std::sin(kPi / (2 * extent.height)) * std::sin(sun.theta);
    const Image result = riemann(map, 6);
    for (int j = 0; j < 6; ++j) {
      for (int i = 0; i < 12; ++i) {
        const auto n = reference::texel_direction(result.extent, i, j).unit(), d = sun.unit();
        const double cosine = n[0] * d[0] + n[1] * d[1] + n[2] * d[2];
        if (std::abs(cosine) < 0.005) continue;  // the texel sets
        const double expected = kSky + std::max(0.0, cosine) * kSun * area / kPi;
        // The texel is a point here; in the zenith it is a triangle, and its centre not its centroid.
        EXPECT_NEAR(reference::texel_value(result, i, j)[0] / expected, 1, 5e-4) << i << " " << j;
      }
    }
  }
}

TEST(Riemann, AgreesWithTheSpectralMethodOnASmoothMap) {
  Image map = constant_map({256, 128}, {});
  for (int j = 0; j < 128; ++j) {
    for (int i = 0; i < 256; ++i) {
      const auto [x, y, z] = reference::texel_direction(map.extent, i, j).unit();
      float* out = map.samples<float>().data() + (j * 256 + i) * 3;
      out[0] = static_cast<float>(std::exp(3 * x - 2 * y * z));
      out[1] = static_cast<float>(2 + x * y + z);
      out[2] = static_cast<float>(1 + y + 0.5 * std::sin(5 * x));
    }
  }
  EXPECT_LE(error_of(riemann(map, 8), spectral(map, 8)), 0.1 * kBar);
}

class RiemannEnvironment : public testing::TestWithParam<const char*> {};

TEST_P(RiemannEnvironment, AgreesWithTheSpectralMethod) {
  const std::string path = std::string(FURNACE_SOURCE_DIR) + "/../shared/data/environments/" + GetParam();
  if (!file_identity(path)) GTEST_SKIP() << "there is no " << path;
  const Image map = decode_environment(Blob(read_file(path, 1 << 24)), {}).equirect;
  EXPECT_LE(error_of(riemann(map, 8), spectral(map, 8)), kBar);
}

// The brightest suns, a low one, lamps, a night without any, and maps of 256 and 512 columns.
INSTANTIATE_TEST_SUITE_P(Files, RiemannEnvironment,
                         testing::Values("narrow_moonlit_road_1k.hdr", "pedestrian_overpass_1k.hdr",
                                         "studio_small_03_1k.hdr", "dikhololo_night_1k.hdr",
                                         "royal_esplanade_256.hdr", "pmndrs_sunrise_512.exr"));

TEST(Riemann, DoesNotDependOnTheNumberOfThreads) {
  Image map = constant_map({64, 32}, {1, 2, 3});
  map.samples<float>()[(10 * 64 + 20) * 3] = 1e5f;
  EXPECT_EQ(riemann(map, 5, 1).pixels, riemann(map, 5, 4).pixels);
}

TEST(Riemann, StopsAtTheDeadline) {
  WorkerPool pool(1);
  try {
    riemann_irradiance(constant_map({64, 32}, {1, 1, 1}), kQuads, 4, pool,
                       Deadline(std::chrono::milliseconds(0)));
    FAIL() << "summed after its time";
  } catch (const Error& error) {
    EXPECT_EQ(error.code, ErrorCode::kDeadlineExceeded);
  }
}

}  // namespace
}  // namespace furnace
