#include "renderer/ibl/dfg.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "renderer/ibl/quadrature.hpp"

namespace furnace {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kPolarNodes = 24;
constexpr int kAzimuthNodes = 16;

struct LobeSums {
  double scale = 0;
  double bias = 0;
  double normal = 0;   // first moment of f (n.l) for F = 1: along n,
  double tangent = 0;  // and along the tangent that the mirror direction leans to
};

struct View {
  double cos_v = 0;
  double sin_v = 0;
  double alpha2 = 0;  // alpha^2
};

// Adds the half vectors at the angle theta_h from n, of weight `ring` = D cos(theta_h) d omega_h / d phi.
// With d omega_l = 4 (v.h) d omega_h the integrand f (n.l) d omega_l is D V F (n.l) 4 (v.h) d omega_h, and
// V (n.l) (Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs", height-correlated)
// goes to 0 smoothly with n.l, at an azimuth known in closed form: n.l = 2 (v.h) cos(theta_h) - n.v > 0.
void add_ring(const View& view, double cos_h, double sin_h, double ring, const std::vector<QuadratureNode>& unit,
              LobeSums& sums) {
  const double slant = view.sin_v * sin_h;
  const double limit = view.cos_v * (0.5 / cos_h - cos_h);  // of slant cos(phi)
  if (limit >= slant) return;
  const double end = limit <= -slant ? kPi : std::acos(limit / slant);
  const double lambda_v_root = std::sqrt(view.alpha2 + (1 - view.alpha2) * view.cos_v * view.cos_v);
  for (const QuadratureNode& node : unit) {
    const double cos_phi = std::cos(end * node.x);
    const double VoH = slant * cos_phi + view.cos_v * cos_h;
    const double NoL = 2 * VoH * cos_h - view.cos_v;
    if (NoL <= 0) continue;
    const double v_times_NoL =
        0.5 * NoL / (NoL * lambda_v_root + view.cos_v * std::sqrt(view.alpha2 + (1 - view.alpha2) * NoL * NoL));
    // Both halves of the azimuth; D d omega_h = ring / cos_h.
    const double weight = 2 * end * node.weight * ring / cos_h * v_times_NoL * 4 * VoH;
    const double fresnel = std::pow(1 - VoH, 5);  // Schlick 1994, "An Inexpensive BRDF Model for Physically-based Rendering"
    sums.scale += weight * (1 - fresnel);
    sums.bias += weight * fresnel;
    sums.normal += weight * NoL;
    sums.tangent += weight * (view.sin_v - 2 * VoH * sin_h * cos_phi);  // -(l . tangent of v), l = 2 (v.h) h - v
  }
}

// D cos(theta_h) d omega_h = du d phi / (2 pi) with tan^2(theta_h) = alpha^2 u / (1 - u) (Walter 2007). The integral over
// theta_h is cut where the azimuth begins to be limited, (pi/2 - theta_v) / 2, and ends where nothing is left.
LobeSums integrate_lobe(const View& view, const std::vector<QuadratureNode>& polar, const std::vector<QuadratureNode>& azimuth) {
  LobeSums sums;
  const double theta_v = std::acos(view.cos_v);
  const auto u_of = [&](double theta) {
    const double tan2 = std::pow(std::tan(theta), 2);
    return tan2 / (view.alpha2 + tan2);
  };
  const double cuts[] = {0, (kPi / 2 - theta_v) / 2, (kPi / 2 + theta_v) / 2};
  for (int part = 0; part < 2; ++part) {
    const double begin = u_of(cuts[part]), length = u_of(cuts[part + 1]) - begin;
    for (const QuadratureNode& node : polar) {
      // Nodes crowd at both ends of the part, where the azimuth's limit has a root.
      const double s = node.x * node.x * (3 - 2 * node.x);
      const double u = begin + length * s;
      const double ring = node.weight * 6 * node.x * (1 - node.x) * length / (2 * kPi);
      const double tan2 = view.alpha2 * u / (1 - u);
      const double cos_h = 1 / std::sqrt(1 + tan2);
      add_ring(view, cos_h, std::sqrt(tan2) * cos_h, ring, azimuth, sums);
    }
  }
  return sums;
}

}  // namespace

DfgTable compute_dfg_table(int size) {
  const std::vector<QuadratureNode> polar = gauss_legendre(kPolarNodes, 0, 1);
  const std::vector<QuadratureNode> azimuth = gauss_legendre(kAzimuthNodes, 0, 1);
  DfgTable table{size, std::vector<DfgTexel>(std::size_t(size) * size)};
  for (int row = 0; row < size; ++row) {
    const double roughness = (row + 0.5) / size;
    for (int column = 0; column < size; ++column) {
      const double cos_v = (column + 0.5) / size;
      const View view{cos_v, std::sqrt(1 - cos_v * cos_v), std::pow(roughness, 4)};
      const LobeSums sums = integrate_lobe(view, polar, azimuth);
      DfgTexel& texel = table.texels[std::size_t(row) * size + column];
      texel.scale = static_cast<float>(sums.scale);
      texel.bias = static_cast<float>(sums.bias);
      texel.lean_rad = static_cast<float>(std::acos(cos_v) - std::atan2(sums.tangent, sums.normal));
      texel.spread = static_cast<float>(std::hypot(sums.normal, sums.tangent) / (sums.scale + sums.bias));
    }
  }
  return table;
}

}  // namespace furnace
