// Judges of the DFG table: the GGX lobe sampled by its visible normals, on a fine regular grid of the unit square, and the lobe
// of fibres summed over directions of light.
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

// The integral of D V (n.l) over l, Estevez and Kulla 2017, "Production Friendly Microfacet Sheen BRDF": `side` x `side`
// midpoints over the hemisphere, crowded at the horizon. Roughness below 0.1 counts as 0.1.
inline double integrate_sheen(double NoV, double perceptual_roughness, int side) {
  const double roughness = std::max(perceptual_roughness, 0.1), alpha = roughness * roughness;
  const double t = (1 - alpha) * (1 - alpha);
  const auto mix = [&](double rough, double smooth) { return rough + t * (smooth - rough); };
  const auto fit = [&](double x) {
    return mix(21.5473, 25.3245) / (1 + mix(3.82987, 3.32435) * std::pow(x, mix(0.19823, 0.16801))) +
           mix(-1.97760, -1.27393) * x + mix(-4.32054, -4.85967);
  };
  const auto lambda = [&](double c) { return std::exp(c < 0.5 ? fit(c) : 2 * fit(0.5) - fit(1 - c)); };
  const double sin_v = std::sqrt(1 - NoV * NoV), lambda_v = lambda(NoV);
  double sum = 0;
  for (int a = 0; a < side; ++a) {
    const double x = (a + 0.5) / side, NoL = x * x, sin_l = std::sqrt(1 - NoL * NoL);
    for (int b = 0; b < side; ++b) {
      // Crowded where l is on v's side, and across from it.
      const double u = (b + 0.5) / side;
      const double phi = std::numbers::pi * (u - std::sin(2 * std::numbers::pi * u) / (2 * std::numbers::pi));
      const double density = std::numbers::pi * (1 - std::cos(2 * std::numbers::pi * u));
      const double hx = sin_v + sin_l * std::cos(phi), hy = sin_l * std::sin(phi), hz = NoV + NoL;
      const double sine2 = (hx * hx + hy * hy) / (hx * hx + hy * hy + hz * hz);
      const double D = (2 + 1 / alpha) * std::pow(sine2, 0.5 / alpha) / (2 * std::numbers::pi);
      sum += D / (4 * NoV * (1 + lambda_v + lambda(NoL))) * 2 * x * 2 * density;
    }
  }
  return std::min(sum / (double(side) * side), 1.0);
}

}  // namespace furnace::reference
