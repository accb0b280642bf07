#include "renderer/ibl/dfg.hpp"

#include <cmath>
#include <numbers>
#include <span>

#include "renderer/ibl/lanes.hpp"
#include "renderer/ibl/quadrature.hpp"
#include "renderer/ibl/sheen_albedo.hpp"

namespace furnace {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kPolarNodes = 32;    // for each part of the polar angle
constexpr int kAzimuthBlocks = 3;  // of eight nodes

struct View {
  double cos_v = 0;
  double sin_v = 0;
  double alpha2 = 0;  // alpha^2
  double root_v = 0;  // sqrt(alpha^2 + (1 - alpha^2) (n.v)^2), of Smith's term for v
};

// Half vectors at one angle theta_h from n; `weight` = D cos(theta_h) d omega_h / d phi.
struct Ring {
  double cos_h = 0;
  double sin_h = 0;
  double weight = 0;
  double end = 0;  // the azimuth from v at which n.l becomes 0, or pi
};

// Sums over half vectors, by lanes: integrand, integrand times Fresnel's (1 - v.h)^5, and the first moment of the
// integrand along n and along the tangent that the mirror direction leans to.
struct LobeSums {
  Lanes total = {};
  Lanes fresnel = {};
  Lanes normal = {};
  Lanes tangent = {};
};

struct AzimuthNodes {
  Lanes x[kAzimuthBlocks];  // on [0, 1]
  Lanes weight[kAzimuthBlocks];
};

[[gnu::always_inline]] inline Lanes square_root(Lanes a) {
  for (int i = 0; i < 8; ++i) a.v[i] = std::sqrt(a.v[i]);
  return a;
}

// For 0 <= x <= pi: 1 - 2 sin^2(x / 2) by Taylor's series, to 1e-12.
[[gnu::always_inline]] inline Lanes cosine(const Lanes& x) {
  const Lanes half = 0.5 * x, z = half * half;
  Lanes series = Lanes::all(1.0 / 1307674368000);  // 1 / 15!
  for (double factorial : {6227020800.0, 39916800.0, 362880.0, 5040.0, 120.0, 6.0, 1.0})
    series = Lanes::all(1 / factorial) - z * series;
  const Lanes sine = half * series;
  return Lanes::all(1) - 2 * (sine * sine);
}

// With d omega_l = 4 (v.h) d omega_h the integrand f (n.l) d omega_l is D V F (n.l) 4 (v.h) d omega_h, and V (n.l)
// (Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs", height-correlated)
//   = 0.5 (n.l) / ((n.l) sqrt(a2 + (1 - a2) (n.v)^2) + (n.v) sqrt(a2 + (1 - a2) (n.l)^2))
// goes to 0 with n.l = 2 (v.h) cos(theta_h) - n.v. F is Schlick's (1994, "An Inexpensive BRDF Model for
// Physically-based Rendering").
[[gnu::always_inline]] inline void add_rings(const View& view, std::span<const Ring> rings,
                                             const AzimuthNodes& azimuth, LobeSums& sums) {
  const Lanes cos_v = Lanes::all(view.cos_v), alpha2 = Lanes::all(view.alpha2);
  for (const Ring& ring : rings) {
    for (int k = 0; k < kAzimuthBlocks; ++k) {
      const Lanes slant = (view.sin_v * ring.sin_h) * cosine(ring.end * azimuth.x[k]);  // of v.h
      const Lanes VoH = slant + Lanes::all(view.cos_v * ring.cos_h);
      const Lanes NoL = 2 * ring.cos_h * VoH - cos_v;
      const Lanes root_l = square_root(alpha2 + (1 - view.alpha2) * (NoL * NoL));
      const Lanes smith = {0.5 * NoL.v / (view.root_v * NoL + view.cos_v * root_l).v};
      // Both halves of the azimuth; D d omega_h = weight / cos(theta_h).
      const double factor = 2 * ring.end * ring.weight / ring.cos_h * 4;
      const Lanes value = factor * azimuth.weight[k] * smith * VoH;
      const Lanes miss = Lanes::all(1) - VoH, miss2 = miss * miss;
      sums.total += value;
      sums.fresnel += value * (miss2 * miss2 * miss);
      sums.normal += value * NoL;
      // l = 2 (v.h) h - v along -(tangent of v)
      const double to_tangent = view.sin_v > 0 ? 1 / view.sin_v : 0;
      sums.tangent += value * (Lanes::all(view.sin_v) - (2 * to_tangent) * (VoH * slant));
    }
  }
}

double sum_of(const Lanes& lanes) {
  double sum = 0;
  for (int i = 0; i < 8; ++i) sum += lanes[i];
  return sum;
}

// Nodes on [0, 1] that crowd at both ends like s = x^2 (3 - 2 x).
std::vector<QuadratureNode> crowded_nodes(int count) {
  std::vector<QuadratureNode> nodes = gauss_legendre(count, 0, 1);
  for (QuadratureNode& node : nodes) {
    node.weight *= 6 * node.x * (1 - node.x);
    node.x = node.x * node.x * (3 - 2 * node.x);
  }
  return nodes;
}

// D cos(theta_h) d omega_h = du d phi / (2 pi) with u = tan^2 / (alpha^2 + tan^2) of theta_h (Walter 2007, "Microfacet
// Models for Refraction through Rough Surfaces"). From theta_h = (pi/2 - theta_v) / 2 on n.l > 0 limits the azimuth, at
// (pi/2 + theta_v) / 2 it leaves nothing. Up to the first angle the nodes are even in u; from there to the second in the
// logarithm of theta_h, since towards grazing views the first is small and all changes within a few times it.
std::vector<Ring> rings_of(const View& view, const std::vector<QuadratureNode>& polar) {
  const double theta_v = std::acos(view.cos_v);
  const double first = (kPi / 2 - theta_v) / 2, second = (kPi / 2 + theta_v) / 2;
  std::vector<Ring> rings;
  const auto add = [&](double tan2, double du) {
    Ring ring;
    ring.cos_h = 1 / std::sqrt(1 + tan2);
    ring.sin_h = std::sqrt(tan2) * ring.cos_h;
    ring.weight = du / (2 * kPi);
    const double limit =
        view.cos_v * (0.5 / ring.cos_h - ring.cos_h) / (view.sin_v * ring.sin_h);  // of cos(phi)
    ring.end = limit <= -1 ? kPi : limit >= 1 ? 0 : std::acos(limit);
    rings.push_back(ring);
  };
  const double tan2_first = std::pow(std::tan(first), 2), u_first = tan2_first / (view.alpha2 + tan2_first);
  for (const QuadratureNode& node : polar) {
    const double u = u_first * node.x;
    add(view.alpha2 * u / (1 - u), u_first * node.weight);
  }
  for (const QuadratureNode& node : polar) {
    const double theta = first * std::pow(second / first, node.x), tangent = std::tan(theta),
                 tan2 = tangent * tangent;
    const double du_dtheta = 2 * tangent * (1 + tan2) * view.alpha2 / std::pow(view.alpha2 + tan2, 2);
    add(tan2, node.weight * std::log(second / first) * theta * du_dtheta);
  }
  return rings;
}

DfgTexel integrate_lobe(double cos_v, double roughness, const std::vector<QuadratureNode>& polar,
                        const AzimuthNodes& azimuth) {
  View view{cos_v, std::sqrt(1 - cos_v * cos_v), std::pow(roughness, 4), 0};
  view.root_v = std::sqrt(view.alpha2 + (1 - view.alpha2) * cos_v * cos_v);
  const std::vector<Ring> rings = rings_of(view, polar);
  LobeSums sums;
  in_widest_registers([&]() __attribute__((always_inline)) { add_rings(view, rings, azimuth, sums); });
  const double total = sum_of(sums.total), fresnel = sum_of(sums.fresnel);
  const double normal = sum_of(sums.normal), tangent = sum_of(sums.tangent);
  return {static_cast<float>(total - fresnel), static_cast<float>(fresnel),
          static_cast<float>(std::acos(cos_v) - std::atan2(tangent, normal)),
          static_cast<float>(sheen_albedo(cos_v, roughness))};
}

}  // namespace

DfgTable compute_dfg_table(int size) {
  const std::vector<QuadratureNode> polar = crowded_nodes(kPolarNodes);
  const std::vector<QuadratureNode> unit = gauss_legendre(8 * kAzimuthBlocks, 0, 1);
  AzimuthNodes azimuth;
  for (int k = 0; k < 8 * kAzimuthBlocks; ++k) {
    // Crowded at the end, where n.l goes to 0 and, seen at grazing angles, the masking changes within n.l ~ n.v.
    const double rest = 1 - unit[k].x;
    azimuth.x[k / 8].set(k % 8, 1 - rest * rest * rest);
    azimuth.weight[k / 8].set(k % 8, 3 * rest * rest * unit[k].weight);
  }
  DfgTable table{size, std::vector<DfgTexel>(std::size_t(size) * size)};
  for (int row = 0; row < size; ++row)
    for (int column = 0; column < size; ++column)
      table.texels[std::size_t(row) * size + column] =
          integrate_lobe((column + 0.5) / size, (row + 0.5) / size, polar, azimuth);
  return table;
}

}  // namespace furnace
