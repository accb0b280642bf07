// Judge of the DFG table: the GGX lobe sampled by its visible normals, on a fine regular grid of the unit square.
#pragma once

#include <cmath>
#include <numbers>

namespace furnace::reference {

struct LobeMoments {
  double scale = 0;  // of F0
  double bias = 0;
  double normal = 0;   // first moment for F = 1, along n
  double tangent = 0;  // and along the direction that the mirror direction leans to
};

// The integral of f (n.l) over l with visible normals (Heitz 2018, "Sampling the GGX Distribution of Visible Normals"): the
// weight of each is G2 / G1(v). `side` x `side` midpoints, crowded at the rim of the disk: few normals lie there, but
// theirs is the lobe's tail and the horizon.
inline LobeMoments integrate_lobe(double NoV, double alpha, int side) {
  const double sin_v = std::sqrt(1 - NoV * NoV), a2 = alpha * alpha;
  const double length = std::hypot(alpha * sin_v, NoV);
  const double stretched_x = alpha * sin_v / length, stretched_z = NoV / length;
  const auto lambda = [&](double cosine) {
    return 0.5 * (std::sqrt(1 + a2 * (1 / (cosine * cosine) - 1)) - 1);
  };
  const double lambda_v = lambda(NoV);
  LobeMoments sums;
  for (int a = 0; a < side; ++a) {
    for (int b = 0; b < side; ++b) {
      const double rim = (a + 0.5) / side, density = 3 * rim * rim;
      const double radius = std::sqrt(1 - rim * rim * rim), angle = 2 * std::numbers::pi * (b + 0.5) / side;
      const double t1 = radius * std::cos(angle), s = 0.5 * (1 + stretched_z);
      const double t2 = (1 - s) * std::sqrt(1 - t1 * t1) + s * radius * std::sin(angle);
      const double up = std::sqrt(std::max(0.0, 1 - t1 * t1 - t2 * t2));
      // Frame of the stretched view: (0, 1, 0), its cross product with the view, the view.
      const double nx = -t2 * stretched_z + up * stretched_x, ny = t1,
                   nz = t2 * stretched_x + up * stretched_z;
      const double hx = alpha * nx, hy = alpha * ny, hz = std::max(0.0, nz);
      const double norm = std::sqrt(hx * hx + hy * hy + hz * hz);
      const double VoH = (sin_v * hx + NoV * hz) / norm, NoL = 2 * VoH * hz / norm - NoV;
      if (NoL <= 0) continue;
      const double weight = density * (1 + lambda_v) / (1 + lambda_v + lambda(NoL)) / (double(side) * side);
      const double fresnel = std::pow(1 - VoH, 5);
      sums.scale += weight * (1 - fresnel);
      sums.bias += weight * fresnel;
      sums.normal += weight * NoL;
      sums.tangent -= weight * (2 * VoH * hx / norm - sin_v);
    }
  }
  return sums;
}

}  // namespace furnace::reference
