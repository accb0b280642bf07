#include <cmath>
#include <complex>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "renderer/base/worker_pool.hpp"
#include "renderer/ibl/core_series.hpp"
#include "renderer/ibl/sphere_transform.hpp"
#include "renderer/ibl/zonal_kernel.hpp"

namespace furnace {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(LaneFft, IsTheFourierSum) {
  std::mt19937 random(3);
  for (int n : {1, 2, 8, 12, 30, 49, 64, 94}) {
    std::vector<ComplexLanes> values(n), work(n);
    for (ComplexLanes& value : values)
      for (int lane = 0; lane < 8; ++lane)
        value.re.set(lane, random() * 1e-9), value.im.set(lane, random() * 1e-9);
    const std::vector<ComplexLanes> in = values;
    LaneFft(n).transform(values.data(), work.data());
    for (int k = 0; k < n; ++k) {
      for (int lane : {0, 5}) {
        std::complex<double> sum = 0;
        for (int i = 0; i < n; ++i)
          sum += std::complex(in[i].re[lane], in[i].im[lane]) *
                 std::polar(1.0, -2 * kPi * double(k * i % n) / n);
        EXPECT_NEAR(values[k].re[lane], sum.real(), 1e-11) << n;
        EXPECT_NEAR(values[k].im[lane], sum.imag(), 1e-11) << n;
      }
    }
  }
}

TEST(Lanes, TransposeSwapsLanesAndElements) {
  Lanes block[8];
  for (int k = 0; k < 8; ++k)
    for (int i = 0; i < 8; ++i) block[k].set(i, 10 * k + i);
  transpose(block);
  for (int k = 0; k < 8; ++k)
    for (int i = 0; i < 8; ++i) EXPECT_EQ(block[k][i], 10 * i + k);
}

TEST(ZonalKernel, IntegralIsOne) {
  for (double alpha : {0.0025, 0.0156, 0.1, 0.5, 0.9, 0.9999, 1.0}) {
    const std::vector<double> k = zonal_coefficients(GgxKernel(alpha), alpha, 8);
    EXPECT_NEAR(k[0], 1, 1e-10) << alpha;
  }
}

TEST(ZonalKernel, LambertInClosedForm) {
  // Ramamoorthi and Hanrahan 2001, "On the relationship between radiance and irradiance", over pi.
  const std::vector<double> k = zonal_coefficients(GgxKernel(1), 1, 7);
  const double expected[] = {1, 2.0 / 3, 1.0 / 4, 0, -1.0 / 24, 0, 1.0 / 64};
  for (int l = 0; l < 7; ++l) EXPECT_NEAR(k[l], expected[l], 1e-12) << l;
}

TEST(ZonalKernel, NearThePeakItIsABesselFunction) {
  // On a plane the transform of (1 + r^2)^-2 is x K_1(x); the sphere and mu add corrections of order alpha^2 log(alpha).
  const double alpha = 0.01;
  const std::vector<double> k = zonal_coefficients(GgxKernel(alpha), alpha, 600);
  for (int l = 20; l < 600; l += 20) {
    const double x = 2 * alpha * (l + 0.5);
    EXPECT_NEAR(k[l], x * std::cyl_bessel_k(1.0, x), 2e-3) << l;
  }
}

TEST(ZonalKernel, SufficientBandsLeaveTheAskedTail) {
  const std::vector<double> k = zonal_coefficients(GgxKernel(0.1), 0.1, 400);
  const int bands = sufficient_bands(k, 1e-3);
  const auto tail = [&](int from) {
    double sum = 0;
    for (int l = from; l < 400; ++l) sum += (2 * l + 1) * k[l] * k[l];
    return std::sqrt(sum);
  };
  EXPECT_LE(tail(bands), 1e-3);
  EXPECT_GT(tail(bands - 1), 1e-3);
}

TEST(CoreSeries, SumsToTheKernel) {
  const double beta = 1e-3, theta = 0.9, source = 0.95;
  const CoreSeries series = core_series(beta, RowDistance(theta, source), 2);
  for (double phi : {0.0, 0.02, 0.3, 2.0}) {
    double sum = 0;
    for (int m = 0; m < 2000; ++m)
      sum +=
          (m == 0 ? 1 : 2) * std::pow(series.q, m) * (series.constant + series.slope * m) * std::cos(m * phi);
    const double mu = std::cos(theta) * std::cos(source) + std::sin(theta) * std::sin(source) * std::cos(phi);
    const double t = (1 - mu) / 2;
    EXPECT_NEAR(sum, 2 * mu / std::pow(t + beta, 2), 1e-7 * 2 / (beta * beta)) << phi;
  }
}

TEST(CoreSeries, VectorsHoldTheOrders) {
  const CoreSeries series = core_series(2e-3, RowDistance(0.5, 0.6), 1);
  std::vector<Orders> out(4);
  add_series(series, 4, out.data());
  for (int m = 0; m < 64; ++m)  // in single precision
    EXPECT_NEAR(out[m / 16].v[m % 16], std::pow(series.q, m) * (series.constant + series.slope * m),
                1e-6 * series.constant);
}

// p_lm of a few low degrees in closed form.
double mode(int l, int m, double theta) {
  const double x = std::cos(theta), s = std::sin(theta);
  if (l == 0) return 0.5 / std::sqrt(kPi);
  if (l == 1 && m == 0) return std::sqrt(3 / (4 * kPi)) * x;
  if (l == 2 && m == 1) return std::sqrt(15 / (8 * kPi)) * s * x;
  if (l == 2 && m == 2) return std::sqrt(15 / (32 * kPi)) * s * s;
  return std::sqrt(35 / (64 * kPi)) * s * s * s;  // l = m = 3
}

TEST(SphereTransform, FindsSingleModesAndScalesThem) {
  WorkerPool pool(1);
  BakeWork work(pool);
  const LegendreTable table(16);
  constexpr int kModes[][2] = {{0, 0}, {1, 0}, {2, 1}, {2, 2}, {3, 3}};
  for (const auto& [l, m] : kModes) {
    Image map = make_image({128, 64}, 3, SampleType::kFloat32, ColorSpace::kLinear);
    float* texel = map.samples<float>().data();
    for (int j = 0; j < 64; ++j) {
      for (int i = 0; i < 128; ++i, texel += 3) {
        const double theta = kPi * (j + 0.5) / 64, phi = 2 * kPi * (i + 0.5) / 128;
        texel[0] = static_cast<float>(2 + mode(l, m, theta) * std::cos(m * phi));
        texel[1] = static_cast<float>(2 + mode(l, m, theta) * std::sin(m * phi));
      }
    }
    const RowSpectrum spectrum = spectrum_of_equirect(map, work);
    const HarmonicCoefficients a = analyse(spectrum, table, work);
    const double half = m == 0 ? 1 : 0.5;  // cos = (e^+ + e^-) / 2
    // Texels are constant over their area: a mode shrinks by about l (l + 1) h^2 / 24 < 1.3e-3, and others appear as little.
    for (int order = 0; order < 4; ++order) {
      for (int degree = order; degree < 16; ++degree) {
        const Lanes found = a.order(order)[degree - order];
        const double own = degree == l && order == m ? half : 0,
                     constant = degree == 0 ? 2 * std::sqrt(4 * kPi) : 0;
        EXPECT_NEAR(found[0], own + constant, 1.5e-3) << l << m << " at " << degree << order;
        EXPECT_NEAR(found[1], 0, 1e-6);
        EXPECT_NEAR(found[3], m == 0 ? 0 : -own, 1.5e-3);
      }
    }
    std::vector<double> kernel(16, 0.0);
    kernel[l] = 0.25;
    const Image scaled = equirect_of_spectrum(synthesise(a, table, kernel, 20, work), 40, work);
    for (int j = 0; j < 20; ++j) {
      for (int i = 0; i < 40; ++i) {
        const double theta = kPi * (j + 0.5) / 20, phi = 2 * kPi * (i + 0.5) / 40;
        const double expected = 0.25 * (mode(l, m, theta) * std::cos(m * phi) + (l == 0 ? 2 : 0));
        EXPECT_NEAR(scaled.samples<float>()[(j * 40 + i) * 3], std::max(0.0, expected), 1e-3);
      }
    }
  }
}

TEST(SphereTransform, ATexelIsItsAreaNotItsCentre) {
  // One texel of value 1: a_lm is the integral of the conjugate mode over it, by a fine sum here.
  WorkerPool pool(1);
  BakeWork work(pool);
  const LegendreTable table(24);
  for (int row : {0, 1, 2, 9, 31}) {
    Image map = make_image({64, 32}, 3, SampleType::kFloat32, ColorSpace::kLinear);
    map.samples<float>()[(row * 64 + 5) * 3] = 1;
    const HarmonicCoefficients a = analyse(spectrum_of_equirect(map, work), table, work);
    for (const auto& [l, m] : {std::pair{1, 0}, {2, 1}, {2, 2}, {3, 3}}) {
      std::complex<double> sum = 0;
      constexpr int kParts = 200;
      for (int p = 0; p < kParts; ++p) {
        const double theta = kPi * (row + (p + 0.5) / kParts) / 32,
                     band = kPi / 32 / kParts * std::sin(theta);
        for (int q = 0; q < kParts; ++q) {
          const double phi = 2 * kPi * (5 + (q + 0.5) / kParts) / 64;
          sum += band * (2 * kPi / 64 / kParts) * mode(l, m, theta) * std::polar(1.0, -m * phi);
        }
      }
      const Lanes found = a.order(m)[l - m];
      EXPECT_NEAR(found[0], sum.real(), 1e-8) << row << " " << l << m;
      EXPECT_NEAR(found[1], sum.imag(), 1e-8) << row << " " << l << m;
    }
  }
}

TEST(SphereTransform, OddNumbersOfRows) {
  WorkerPool pool(1);
  BakeWork work(pool);
  const LegendreTable table(12);
  Image map = make_image({54, 27}, 3, SampleType::kFloat32, ColorSpace::kLinear);
  for (float& sample : map.samples<float>()) sample = 3;
  const HarmonicCoefficients a = analyse(spectrum_of_equirect(map, work), table, work);
  const Image back =
      equirect_of_spectrum(synthesise(a, table, std::vector<double>(12, 1.0), 9, work), 18, work);
  // The midpoints of 27 rows do not integrate the higher Legendre polynomials of a constant to exactly 0: 1.5e-4 is left.
  for (float sample : back.samples<float>()) EXPECT_NEAR(sample, 3, 5e-4);
}

}  // namespace
}  // namespace furnace
