#include "renderer/ibl/zonal_kernel.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "renderer/base/check.hpp"
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

// Panels in theta that double from the peak outwards; in each as many nodes as the fastest Legendre function has half
// waves, and some for the kernel itself.
std::vector<double> zonal_coefficients(const std::function<double(double t)>& kernel, double width,
                                       int bands) {
  std::vector<double> x, weight, p1, p2;
  for (double begin = 0, step = 0.5 * width; begin < kPi / 2; begin += step, step = begin) {
    const double end = begin + step > 0.45 * kPi ? kPi / 2 : begin + step;
    const int count = static_cast<int>(std::ceil(0.6 * bands * (end - begin))) + 16;
    for (const QuadratureNode& node : gauss_legendre(count, begin, end)) {
      const double half = std::sin(node.x / 2);
      x.push_back(std::cos(node.x));
      weight.push_back(2 * kPi * node.weight * std::sin(node.x) * kernel(half * half));
    }
    if (end == kPi / 2) break;
  }
  p1.assign(x.size(), 1);
  p2.assign(x.size(), 0);
  std::vector<double> coefficients(bands);
  for (int l = 0; l < bands; ++l) {
    double sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i) sum += weight[i] * p1[i];
    coefficients[l] = sum;
    const double a = (2.0 * l + 1) / (l + 1), b = double(l) / (l + 1);
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double next = a * x[i] * p1[i] - b * p2[i];
      p2[i] = p1[i];
      p1[i] = next;
    }
  }
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
