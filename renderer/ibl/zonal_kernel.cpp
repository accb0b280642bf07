#include "renderer/ibl/zonal_kernel.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "renderer/base/check.hpp"
#include "renderer/ibl/lanes.hpp"
#include "renderer/ibl/quadrature.hpp"

namespace furnace {

namespace {

constexpr double kPi = std::numbers::pi;

}  // namespace

// The integral of mu / (t + beta)^2 over the hemisphere is, with mu = 1 - 2 t and z = 1 / (2 beta),
//   4 pi * integral over [0, 1/2] of (1 - 2 t) / (t + beta)^2 dt = 8 pi (z - ln(1 + z)).
GgxKernel::GgxKernel(double alpha) : alpha_(alpha) {
  FURNACE_CHECK(alpha > 0 && alpha <= 1, "alpha {}", alpha);
  if (alpha == 1) {
    scale_ = 1 / kPi;
    return;
  }
  beta_ = alpha * alpha / (1 - alpha * alpha);
  const double z = 0.5 / beta_;
  const double series = z * z * (1.0 / 2 - z * (1.0 / 3 - z * (1.0 / 4 - z / 5)));
  scale_ = 1 / (8 * kPi * (z < 1e-3 ? series : z - std::log1p(z)));
}

double GgxKernel::operator()(double t) const {
  if (t >= 0.5) return 0;
  const double mu = 1 - 2 * t;
  if (alpha_ == 1) return scale_ * mu;
  const double u = t + beta_;
  return scale_ * mu / (u * u);
}

CharlieKernel::CharlieKernel(double alpha)
    : power_(0.5 / alpha), scale_((power_ + 1) * (power_ + 2) / (2 * kPi)) {
  FURNACE_CHECK(alpha > 0 && alpha <= 1, "alpha {}", alpha);
}

double CharlieKernel::operator()(double t) const {
  if (t >= 0.5) return 0;
  return scale_ * std::pow(2 * t, power_) * (1 - 2 * t);
}

// Panels in theta that double from the peak outwards, each cut so that 32 nodes follow both the kernel and the half waves
// of the fastest Legendre function.
std::vector<double> zonal_coefficients(const std::function<double(double t)>& kernel, double width,
                                       int bands) {
  constexpr int kNodes = 32;
  constexpr double kHalfWaves = 16;  // in a panel
  static const std::vector<QuadratureNode> unit = gauss_legendre(kNodes, 0, 1);
  std::vector<Lanes> x, weight, p1, p2;
  const auto add_panel = [&](double begin, double end) {
    for (int i = 0; i < kNodes; i += 8) {
      Lanes cosine, product;
      for (int k = 0; k < 8; ++k) {
        const double theta = begin + (end - begin) * unit[i + k].x, half = std::sin(theta / 2);
        cosine.set(k, std::cos(theta));
        product.set(k, 2 * kPi * (end - begin) * unit[i + k].weight * std::sin(theta) * kernel(half * half));
      }
      x.push_back(cosine);
      weight.push_back(product);
    }
  };
  for (double begin = 0, length = 0.5 * width; begin < kPi / 2; begin += length, length = begin) {
    length = std::min(length, kPi / 2 - begin);
    const int panels = static_cast<int>(std::ceil(bands * length / (kPi * kHalfWaves)));
    for (int k = 0; k < panels; ++k)
      add_panel(begin + length * k / panels, begin + length * (k + 1) / panels);
  }
  p1.assign(x.size(), Lanes::all(1));
  p2.assign(x.size(), Lanes{});
  std::vector<double> coefficients(bands);
  in_widest_registers([&]() __attribute__((always_inline)) {
    for (int l = 0; l < bands; ++l) {
      const double a = (2.0 * l + 1) / (l + 1), b = double(l) / (l + 1);
      Lanes sum = {};
      for (std::size_t i = 0; i < x.size(); ++i) {
        sum += weight[i] * p1[i];
        const Lanes next = a * (x[i] * p1[i]) - b * p2[i];
        p2[i] = p1[i];
        p1[i] = next;
      }
      for (int k = 0; k < 8; ++k) coefficients[l] += sum[k];
    }
  });
  return coefficients;
}

int sufficient_bands(const std::vector<double>& coefficients, double rms) {
  double tail = 0;
  int bands = static_cast<int>(coefficients.size());
  while (bands > 1) {
    const double k = coefficients[bands - 1];
    tail += (2 * bands - 1) * k * k;
    if (std::sqrt(tail) > rms) break;
    --bands;
  }
  return bands;
}

}  // namespace furnace
