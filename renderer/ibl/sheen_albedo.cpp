#include "renderer/ibl/sheen_albedo.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "renderer/ibl/quadrature.hpp"

namespace furnace {
namespace {

constexpr double kPi = std::numbers::pi;

// Their Smith term's logarithm, fitted between roughness 0 and 1.
class Masking {
 public:
  explicit Masking(double alpha) {
    constexpr double kSmooth[5] = {25.3245, 3.32435, 0.16801, -1.27393, -4.85967};
    constexpr double kRough[5] = {21.5473, 3.82987, 0.19823, -1.97760, -4.32054};
    const double share = (1 - alpha) * (1 - alpha);
    for (int i = 0; i < 5; ++i) fit_[i] = share * kSmooth[i] + (1 - share) * kRough[i];
  }
  double operator()(double cosine) const {
    return std::exp(cosine < 0.5 ? fit(cosine) : 2 * fit(0.5) - fit(1 - cosine));
  }

 private:
  double fit(double x) const {
    return fit_[0] / (1 + fit_[1] * std::pow(x, fit_[2])) + fit_[3] * x + fit_[4];
  }
  double fit_[5];
};

}  // namespace

// With d omega_l = 4 (v.h) d omega_h the integrand is D (v.h) / ((n.v) (1 + lambda(v) + lambda(l))) d omega_h where n.l > 0:
// that bounds the azimuth of h from theta_h = (pi/2 - theta_v) / 2 on, and leaves nothing from (pi/2 + theta_v) / 2 on.
double sheen_albedo(double cos_v, double perceptual_roughness) {
  static const std::vector<QuadratureNode> nodes = [] {
    std::vector<QuadratureNode> unit = gauss_legendre(40, 0, 1);
    for (QuadratureNode& node : unit) {  // crowded at both ends
      node.weight *= 6 * node.x * (1 - node.x);
      node.x = node.x * node.x * (3 - 2 * node.x);
    }
    return unit;
  }();
  const double roughness = std::max(perceptual_roughness, kLeastSheenRoughness),
               alpha = roughness * roughness;
  const Masking lambda(alpha);
  const double lambda_v = lambda(cos_v), sin_v = std::sqrt(std::max(1 - cos_v * cos_v, 1e-12));
  const double theta_v = std::acos(cos_v);
  const double ends[3] = {0, (kPi / 2 - theta_v) / 2, (kPi / 2 + theta_v) / 2};
  double sum = 0;
  for (int part = 0; part < 2; ++part) {
    for (const QuadratureNode& polar : nodes) {
      const double theta_h = ends[part] + (ends[part + 1] - ends[part]) * polar.x;
      const double cos_h = std::cos(theta_h), sin_h = std::sin(theta_h);
      const double limit = cos_v * (0.5 / cos_h - cos_h) / (sin_v * sin_h);
      const double azimuth_end = limit <= -1 ? kPi : limit >= 1 ? 0 : std::acos(limit);
      const double D = (2 + 1 / alpha) * std::pow(sin_h, 1 / alpha) / (2 * kPi);
      double ring = 0;
      for (const QuadratureNode& azimuth : nodes) {
        const double VoH = sin_v * sin_h * std::cos(azimuth_end * azimuth.x) + cos_v * cos_h;
        const double NoL = 2 * VoH * cos_h - cos_v;
        if (NoL > 0) ring += azimuth.weight * VoH / (1 + lambda_v + lambda(NoL));
      }
      // Both halves of the azimuth.
      sum += polar.weight * (ends[part + 1] - ends[part]) * D * sin_h * 2 * azimuth_end * ring / cos_v;
    }
  }
  return std::min(sum, 1.0);
}

}  // namespace furnace
