#include "renderer/frame/white_balance.hpp"

#include <algorithm>

namespace furnace {
namespace {

constexpr double kDaylightKelvin = 6504;  // of D65, CIE 15:2004

// Krystek 1985, "An algorithm to calculate correlated colour temperature": black bodies of 1000 to 15000 K in CIE 1960 (u, v).
glm::dvec2 planckian_uv(double t) {
  return {
      (0.860117757 + t * (1.54118254e-4 + t * 1.28641212e-7)) / (1 + t * (8.42420235e-4 + t * 7.08145163e-7)),
      (0.317398726 + t * (4.22806245e-5 + t * 4.20481691e-8)) /
          (1 + t * (-2.89741816e-5 + t * 1.61456053e-7))};
}

// CIE 15:2004, "Colorimetry", section 3.1: daylight of 4000 to 25000 K.
glm::dvec2 daylight_xy(double t) {
  const double r = 1000 / t;
  const double x = t <= 7000 ? 0.244063 + r * (0.09911 + r * (2.9678 - r * 4.6070))
                             : 0.237040 + r * (0.24748 + r * (1.9018 - r * 2.0064));
  return {x, -0.275 + x * (2.870 - 3.000 * x)};
}

glm::dvec2 xy_from_uv(glm::dvec2 uv) {
  return glm::dvec2(3 * uv.x, 2 * uv.y) / (2 * uv.x - 8 * uv.y + 4);
}
glm::dvec2 uv_from_xy(glm::dvec2 xy) {
  return glm::dvec2(4 * xy.x, 6 * xy.y) / (-2 * xy.x + 12 * xy.y + 3);
}

// Of luminance 1.
glm::dvec3 xyz_from_xy(glm::dvec2 xy) {
  return {xy.x / xy.y, 1, (1 - xy.x - xy.y) / xy.y};
}

// CIE 224:2017, "Colour Fidelity Index": black bodies up to 4000 K, daylight from 5000 K, in between a mixture of both.
glm::dvec2 locus_xy(double kelvin) {
  constexpr double kPlanckianBelow = 4000, kDaylightAbove = 5000;
  const double share = std::clamp((kelvin - kPlanckianBelow) / (kDaylightAbove - kPlanckianBelow), 0.0, 1.0);
  if (share == 1) return daylight_xy(kelvin);
  const glm::dvec2 planckian = xy_from_uv(planckian_uv(kelvin));
  if (share == 0) return planckian;
  const glm::dvec3 mixed = glm::mix(xyz_from_xy(planckian), xyz_from_xy(daylight_xy(kelvin)), share);
  return glm::dvec2(mixed) / (mixed.x + mixed.y + mixed.z);
}

// IEC 61966-2-1:1999, table 1: primaries and white of sRGB, which are those of ITU-R BT.709.
glm::dmat3 xyz_from_rec709() {
  const glm::dmat3 primaries(xyz_from_xy({0.64, 0.33}), xyz_from_xy({0.30, 0.60}), xyz_from_xy({0.15, 0.06}));
  const glm::dvec3 luminance = glm::inverse(primaries) * xyz_from_xy({0.3127, 0.3290});
  return {primaries[0] * luminance.x, primaries[1] * luminance.y, primaries[2] * luminance.z};
}

}  // namespace

glm::dvec2 white_chromaticity(double kelvin, double tint) {
  constexpr double kTintsPerUv = 3000;
  constexpr double kStepKelvin = 1;
  const glm::dvec2 along =
      uv_from_xy(locus_xy(kelvin - kStepKelvin)) - uv_from_xy(locus_xy(kelvin + kStepKelvin));
  // Hotter lies at smaller u: a quarter turn of the way to cooler points up, to green.
  const glm::dvec2 up = glm::normalize(glm::dvec2(-along.y, along.x));
  return xy_from_uv(uv_from_xy(locus_xy(kelvin)) + up * (tint / kTintsPerUv));
}

// Lam 1985, "Metamerism and Colour Constancy": von Kries' scaling of the responses of sharpened cones ("Bradford").
glm::dmat3 adaptation(glm::dvec2 from, glm::dvec2 to) {
  const glm::dmat3 cones_from_xyz =
      glm::transpose(glm::dmat3(0.8951, 0.2664, -0.1614, -0.7502, 1.7135, 0.0367, 0.0389, -0.0685, 1.0296));
  // Of blue in the light of a black body of 1600 K. What gives less, as strong tints of low kelvin, no gain can mend.
  constexpr double kLeastResponse = 0.05;
  const glm::dvec3 response = glm::max(cones_from_xyz * xyz_from_xy(from), kLeastResponse);
  const glm::dvec3 gain = (cones_from_xyz * xyz_from_xy(to)) / response;
  const glm::dmat3 scale(gain.x, 0, 0, 0, gain.y, 0, 0, 0, gain.z);
  return glm::inverse(cones_from_xyz) * scale * cones_from_xyz;
}

glm::dmat3 white_balance(double kelvin, double tint) {
  const glm::dmat3 xyz_from_rgb = xyz_from_rec709();
  const glm::dvec2 white = white_chromaticity(kDaylightKelvin, 0);
  return glm::inverse(xyz_from_rgb) * adaptation(white_chromaticity(kelvin, tint), white) * xyz_from_rgb;
}

}  // namespace furnace
