// The fitted cosines against the lobe they stand for.
#include <cmath>

#include <gtest/gtest.h>

#include "renderer/ibl/dfg.hpp"
#include "renderer/ibl/ltc.hpp"
#include "tests/support/reference/lobe.hpp"

namespace furnace {
namespace {

LtcTexel texel_at(double NoV, double roughness) {
  const auto place = [](double x) { return std::min(int(x * kDfgTableSize), kDfgTableSize - 1); };
  return ltc_table()[std::size_t(place(roughness)) * kDfgTableSize + std::size_t(place(std::sqrt(1 - NoV)))];
}

// Midpoints over the sphere's upper half and a band below, by cosine and azimuth.
template <class F>
void over_hemisphere(int side, const F& f) {
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < 2 * side; ++j) {
      const double z = (i + 0.5) / side, sine = std::sqrt(1 - z * z),
                   phi = std::numbers::pi * (j + 0.5) / side;
      f(sine * std::cos(phi), sine * std::sin(phi), z, std::numbers::pi / (double(side) * side));
    }
  }
}

// Half the integral of the difference: the share of the light that is looked for in a wrong direction. Measured 0.01 to 0.11
// where the surface is not seen at grazing angles.
TEST(Ltc, IsNearlyTheLobe) {
  for (const double roughness : {0.35, 0.5, 0.7, 0.9}) {
    for (const double NoV : {0.98, 0.8, 0.5, 0.3}) {
      const double alpha = roughness * roughness, a2 = alpha * alpha, sine = std::sqrt(1 - NoV * NoV);
      const LtcTexel texel = texel_at(NoV, roughness);
      const auto moments = reference::integrate_lobe(NoV, alpha, 400);
      double difference = 0, whole = 0;
      over_hemisphere(300, [&](double x, double y, double z, double solid_angle) {
        const double length = std::sqrt((x + sine) * (x + sine) + y * y + (z + NoV) * (z + NoV)),
                     h = (z + NoV) / length;
        const double q = h * h * (a2 - 1) + 1, D = a2 / (std::numbers::pi * q * q);
        const double V =
            0.5 / (z * std::sqrt(a2 + (1 - a2) * NoV * NoV) + NoV * std::sqrt(a2 + (1 - a2) * z * z));
        // The table leans to the viewer's side with +x, and light comes from the other.
        const double fitted = ltc_density(texel, alpha, x, y, z);
        difference += 0.5 * solid_angle * std::abs(D * V * z / (moments.scale + moments.bias) - fitted);
        whole += solid_angle * fitted;
      });
      EXPECT_LT(difference, 0.12) << roughness << " " << NoV;
      EXPECT_GT(whole, 0.93) << roughness << " " << NoV;  // the rest lies below the horizon
      EXPECT_LT(whole, 1.005);
    }
  }
}

TEST(Ltc, ASmoothMirrorLooksWhereItReflects) {
  for (const double NoV : {0.95, 0.7, 0.4}) {
    const LtcTexel texel = texel_at(NoV, 0.1);
    const double alpha = 0.01, sine = std::sqrt(1 - NoV * NoV);
    const double peak = ltc_density(texel, alpha, -sine, 0, NoV);
    // D V (n.l) over its integral, at its peak: 1 / (4 pi alpha^2 n.v).
    EXPECT_NEAR(peak * 4 * std::numbers::pi * alpha * alpha * NoV, 1, 0.1) << NoV;
  }
}

}  // namespace
}  // namespace furnace
