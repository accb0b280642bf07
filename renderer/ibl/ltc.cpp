#include "renderer/ibl/ltc.hpp"

#include <Eigen/Core>
#include <unsupported/Eigen/NonLinearOptimization>
#include <unsupported/Eigen/NumericalDiff>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace furnace {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kPi = std::numbers::pi;
constexpr int kNodes = 24;           // half vectors a side
constexpr double kMinCosine = 0.01;  // nearer to grazing no cosine fits, and what is seen is a line

struct Node {
  Vector3d l;
  double density;  // of the lobe
  double weight;   // solid angle that the node stands for
};

struct Lobe {
  std::vector<Node> nodes;
  double mean_angle = 0;  // of its first moment, from the normal
};

// D V (n.l) over its integral, at half vectors even in the distribution of D (n.h). One half of it: the other is its mirror image.
Lobe make_lobe(double NoV, double alpha) {
  const double alpha2 = alpha * alpha, sine = std::sqrt(1 - NoV * NoV);
  Lobe lobe;
  double total = 0, across = 0, along = 0;
  for (int i = 0; i < kNodes; ++i) {
    for (int j = 0; j < kNodes; ++j) {
      const double u = (i + 0.5) / kNodes, phi = kPi * (j + 0.5) / kNodes;
      const double tan2 = alpha2 * u / (1 - u), NoH = 1 / std::sqrt(1 + tan2), sin_h = std::sqrt(tan2) * NoH;
      const Vector3d h(sin_h * std::cos(phi), sin_h * std::sin(phi), NoH);
      const double VoH = sine * h.x() + NoV * NoH;
      const Vector3d l = 2 * VoH * h - Vector3d(sine, 0, NoV);
      if (VoH <= 1e-6 || l.z() <= 1e-6) continue;
      const double q = NoH * NoH * (alpha2 - 1) + 1, D = alpha2 / (kPi * q * q), NoL = l.z();
      const double V = 0.5 / (NoL * std::sqrt(alpha2 + (1 - alpha2) * NoV * NoV) +
                              NoV * std::sqrt(alpha2 + (1 - alpha2) * NoL * NoL));
      const double weight = 4 * VoH / (D * NoH * kNodes * kNodes);
      lobe.nodes.push_back({l, D * V * NoL, weight});
      total += D * V * NoL * weight;
      across += D * V * NoL * weight * l.x();
      along += D * V * NoL * weight * l.z();
    }
  }
  for (Node& node : lobe.nodes) node.density /= total;
  lobe.mean_angle = std::atan2(across, along);
  return lobe;
}

// A cosine about an axis turned by `tilt` from the mean direction, stretched and sheared.
enum Parameter { kLogAlong, kLogAcross, kShear, kTilt, kParameters };

// As LtcTexel: the solver's differences are too fine for single precision.
struct Entries {
  double a, b, c, d;
};

Entries entries_of(const VectorXd& fit, double mean_angle, double alpha) {
  const double angle = mean_angle + fit[kTilt], sine = std::sin(angle), cosine = std::cos(angle);
  const double across = std::exp(fit[kLogAcross]), ratio = across / std::exp(fit[kLogAlong]);
  return {ratio * (cosine - fit[kShear] * sine), ratio * (-sine - fit[kShear] * cosine),
          across * sine / alpha, across * cosine / alpha};
}

double density(const Entries& e, double alpha, const Vector3d& l) {
  const double px = e.a * l.x() + e.b * l.z(), pz = alpha * (e.c * l.x() + e.d * l.z());
  if (pz <= 0) return 0;
  const double length2 = px * px + l.y() * l.y() + pz * pz;
  return pz * std::abs(alpha * (e.a * e.d - e.b * e.c)) / (kPi * length2 * length2);
}

// What Eigen's solver makes the sum of squares of least.
struct Misfit {
  using Scalar = double;
  using InputType = VectorXd;
  using ValueType = VectorXd;
  using JacobianType = Eigen::MatrixXd;
  enum { InputsAtCompileTime = Eigen::Dynamic, ValuesAtCompileTime = Eigen::Dynamic };

  const Lobe& lobe;
  double alpha;
  bool round;  // seen from above: one width, nothing else

  VectorXd parameters(const VectorXd& free) const {
    if (!round) return free;
    VectorXd all = VectorXd::Zero(kParameters);
    all[kLogAlong] = all[kLogAcross] = free[0];
    return all;
  }
  int inputs() const { return round ? 1 : int(kParameters); }
  int values() const { return int(lobe.nodes.size()); }
  int operator()(const VectorXd& free, VectorXd& out) const {
    const Entries entries = entries_of(parameters(free), lobe.mean_angle, alpha);
    for (std::size_t i = 0; i < lobe.nodes.size(); ++i) {
      const Node& node = lobe.nodes[i];
      const double fitted = density(entries, alpha, node.l);
      // Relative to both, so that the flanks count beside the peak.
      out[Eigen::Index(i)] =
          (node.density - fitted) * std::sqrt(node.weight / (node.density + fitted + 1e-3));
    }
    return 0;
  }
};

// Places even in the table's own coordinates, (fits + 1)^2; each fit begins at its neighbour's.
std::vector<LtcTexel> fit_all(int fits) {
  std::vector<LtcTexel> texels;
  for (int row = 0; row <= fits; ++row) {
    const double roughness = double(row) / fits, alpha = std::max(roughness * roughness, kLtcMinAlpha);
    VectorXd fit = VectorXd::Zero(kParameters);
    fit[kLogAlong] = fit[kLogAcross] = std::log(2 * alpha);  // that of a narrow lobe
    for (int column = 0; column <= fits; ++column) {
      const double s = double(column) / fits;
      const Lobe lobe = make_lobe(std::max(1 - s * s, kMinCosine), alpha);
      const Misfit misfit{lobe, alpha, column == 0};
      Eigen::NumericalDiff<Misfit> differences(misfit);
      Eigen::LevenbergMarquardt<Eigen::NumericalDiff<Misfit>> solver(differences);
      VectorXd free = misfit.round ? VectorXd(fit.head(1)) : fit;
      solver.minimize(free);
      fit = misfit.parameters(free);
      const Entries e = entries_of(fit, lobe.mean_angle, alpha);
      texels.push_back({float(e.a), float(e.b), float(e.c), float(e.d)});
    }
  }
  return texels;
}

LtcTexel mix(const LtcTexel& p, const LtcTexel& q, float t) {
  return {std::lerp(p.a, q.a, t), std::lerp(p.b, q.b, t), std::lerp(p.c, q.c, t), std::lerp(p.d, q.d, t)};
}

}  // namespace

double ltc_density(const LtcTexel& texel, double alpha, double x, double y, double z) {
  return density({double(texel.a), double(texel.b), double(texel.c), double(texel.d)}, alpha, {x, y, z});
}

std::vector<LtcTexel> compute_ltc_table(int size, int fits) {
  const std::vector<LtcTexel> fitted = fit_all(fits);
  std::vector<LtcTexel> texels;
  const auto place = [&](int i) { return float((i + 0.5) / size * fits); };
  for (int row = 0; row < size; ++row) {
    const float y = place(row);
    for (int column = 0; column < size; ++column) {
      const float x = place(column);
      const auto at = [&](int down, int right) {
        return fitted[std::size_t(int(y) + down) * std::size_t(fits + 1) + std::size_t(int(x) + right)];
      };
      const float tx = x - std::floor(x), ty = y - std::floor(y);
      texels.push_back(mix(mix(at(0, 0), at(0, 1), tx), mix(at(1, 0), at(1, 1), tx), ty));
    }
  }
  return texels;
}

}  // namespace furnace
