// Kernels that depend on the angle to the map's direction alone, and how much of each spherical degree they let through.
#pragma once

#include <functional>
#include <vector>

namespace furnace {

// The prefilter of a GGX level under n = v = r: D_GGX(half angle) * mu for mu = cos(angle) > 0, with integral 1 over the
// sphere (Walter 2007, "Microfacet Models for Refraction through Rough Surfaces"; Karis 2013, "Real Shading in Unreal
// Engine 4"). With t = (1 - mu) / 2 = sin^2(half angle),
//   D = alpha^2 / (pi (cos^2 (alpha^2 - 1) + 1)^2) = alpha^2 / (pi (1 - alpha^2)^2 (t + beta)^2),
//   beta = alpha^2 / (1 - alpha^2);
// at alpha = 1 it is Lambert's mu / pi.
// Threads: a value.
class GgxKernel {
 public:
  explicit GgxKernel(double alpha);  // 0 < alpha <= 1

  double operator()(double t) const;  // per steradian; 0 for t >= 1/2

  double alpha() const { return alpha_; }
  // Below alpha = 1: kernel = scale * mu / (t + beta)^2.
  double beta() const { return beta_; }
  double scale() const { return scale_; }

 private:
  double alpha_ = 1;
  double beta_ = 0;
  double scale_ = 1;
};

// The prefilter of a sheen level: D_Charlie(half angle) * mu for mu > 0, with integral 1 over the sphere (Estevez and Kulla 2017,
// "Production Friendly Microfacet Sheen BRDF"): D = (2 + 1/alpha) sin(half angle)^(1/alpha) / (2 pi), so with
// t = (1 - mu) / 2 and p = 1 / (2 alpha)
//   kernel = scale * (2 t)^p * (1 - 2 t),  scale = (p + 1) (p + 2) / (2 pi).
// Threads: a value.
class CharlieKernel {
 public:
  explicit CharlieKernel(double alpha);  // 0 < alpha <= 1

  double operator()(double t) const;  // per steradian; 0 for t >= 1/2

 private:
  double power_ = 0.5;
  double scale_ = 1;
};

// k_l = 2 pi * integral of kernel P_l over mu, for l < bands; k_0 = 1 for a kernel of integral 1. `kernel` takes
// t = (1 - mu) / 2 in [0, 1/2]; `width` is the angle (rad) over which it varies near its peak.
std::vector<double> zonal_coefficients(const std::function<double(double t)>& kernel, double width,
                                       int bands);

// The smallest number of degrees after which what is cut off, for all of the light in one direction, is below `rms` of
// the mean in root mean square over the sphere: sqrt(sum of (2 l + 1) k_l^2).
int sufficient_bands(const std::vector<double>& coefficients, double rms);

}  // namespace furnace
