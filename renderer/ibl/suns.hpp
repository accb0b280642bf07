// The suns of an environment as lights of their own, which can cast shadows.
#pragma once

#include <array>
#include <numbers>
#include <vector>

#include "renderer/base/deadline.hpp"
#include "renderer/image/image.hpp"

namespace furnace {

// Threads: a value.
struct Sun {
  bool operator==(const Sun&) const = default;

  std::array<double, 3>
      direction{};  // unit, towards the sun, in the frame of the environment: the centroid of its flux
  std::array<double, 3> irradiance{};  // RGB, on a plane facing it as if all its light came from `direction`
  double angular_radius_rad = 0;       // of the even disc whose flux has the same second moment
  double solid_angle_sr =
      0;            // of the texels it was taken from, at most that of SunSettings::largest_radius_rad
  double peak = 0;  // largest sample of these texels in the map
};

struct SunSettings {
  // What the shaders take; a fifth light of this size would be no sun.
  int most = 4;
  // Of the map's flux (integral over the sphere, Rec.709 luminance), above the surroundings: a fainter light's shadow is
  // filled by the rest of the map.
  double smallest_share = 0.1;
  // Of a cone with the solid angle of the cluster, and of the disc with its second moment. Photographed suns are blurred to
  // 0.4 .. 1.9 degrees; the lamps and soft boxes of photographed studios begin at 2.3, and their shapes are to be seen.
  double largest_radius_rad = 2 * std::numbers::pi / 180;
  // Mean radiance over that of the surroundings: a sun has an edge, the brightest part of an overcast sky has none.
  double smallest_contrast = 4;
  // Of the peak: where a cluster ends. The lens's glare lies mostly below a hundredth and stays in the map; higher ends are
  // tried, each twice the last, while the glare makes the cluster too large.
  double faintest_edge = 0.01;
};

struct SunExtraction {
  std::vector<Sun> suns;  // brightest first
  Image residual;  // RGB kFloat32, same size, >= 0: the map with its suns replaced by what surrounds them
};

// `equirect`: RGB kFloat32, 2:1, finite, >= 0 (baked_environment.hpp). Brightest first. Reads the map twice and copies
// nothing. Errors: kDeadlineExceeded. Threads: any.
std::vector<Sun> find_suns(const Image& equirect, const Deadline& deadline, const SunSettings& settings = {});

// The same, and what they leave: in each channel the integral of `residual` and the suns' irradiances add up to the
// integral of `equirect`, in double precision (texels count with their exact solid angles).
// Errors: also kTooLarge as make_image.
SunExtraction extract_suns(const Image& equirect, const Deadline& deadline, const SunSettings& settings = {});

}  // namespace furnace
