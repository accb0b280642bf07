// Environments described by a few numbers, and the pictures painted from them.
#pragma once

#include <variant>
#include <vector>

#include <glm/glm.hpp>

#include "renderer/base/deadline.hpp"
#include "renderer/base/worker_pool.hpp"
#include "renderer/image/image.hpp"
#include "renderer/scene/transform.hpp"

namespace furnace {

// Radiance is linear Rec.709. Azimuths are the orbit camera's: 0 is +Z, pi/2 is +X.

struct GradientStop {
  double elevation_deg;
  glm::dvec3 radiance;
};
// Between two stops; smooth has no slope at them.
enum class GradientBlend { kLinear, kSmooth };

// A bright day without a sun: a white card that lies flat shows about 1.
std::vector<GradientStop> default_gradient();

struct GradientEnvironment {
  std::vector<GradientStop> stops = default_gradient();  // 2 or more, ascending
  GradientBlend blend = GradientBlend::kLinear;
};

struct OvercastEnvironment {
  double zenith_luminance = 9.0 / 7;  // its horizontal irradiance is pi
  double ground_albedo = 0.2;
};

// kWhiteCard: balanced for daylight and exposed so that a white card turned to the light shows 1; kPhysical: cd/m2.
enum class SkyCalibration { kWhiteCard, kPhysical };

inline constexpr double kMinSunElevationDeg = -6;  // where civil twilight ends

struct ClearSkyEnvironment {
  double turbidity = 2.5;  // 2: clean, dry air to 10: haze
  double ground_albedo = 0.2;
  double sun_elevation_rad = radians_from_degrees(45);  // kMinSunElevationDeg to pi/2
  double sun_azimuth_rad = radians_from_degrees(-20);
  bool sun_disc = true;                                // else the sky alone
  double sun_radius_rad = radians_from_degrees(0.27);  // a larger disc is dimmer: its light stays the same
  SkyCalibration calibration = SkyCalibration::kWhiteCard;
};

enum class LightShape { kRectangle, kDisc };

// A flat light that faces the centre, painted as the eye there sees it (gnomonic projection), so that a
// mirror shows straight edges.
struct SoftBox {
  LightShape shape = LightShape::kRectangle;
  double azimuth_rad = radians_from_degrees(-25), elevation_rad = radians_from_degrees(40);
  double roll_rad = 0;  // counter-clockwise as seen from the centre
  double width_rad = radians_from_degrees(45), height_rad = radians_from_degrees(35);  // (0, pi)
  glm::dvec3 color{1};   // of any scale, not black
  double luminance = 6;  // of the plain part of the light
  double feather = 0.2;  // part of the way from the nearer edge to the middle over which the light fades out
  double hotspot = 1;    // brightness of the middle against that of the border
};

// A floor that catches the light, a sweep up into darker walls, a dim ceiling.
GradientEnvironment default_room();
// One key light.
std::vector<SoftBox> default_soft_boxes();

struct StudioEnvironment {
  GradientEnvironment room = default_room();
  std::vector<SoftBox> lights = default_soft_boxes();
};

using ProceduralEnvironment =
    std::variant<GradientEnvironment, OvercastEnvironment, ClearSkyEnvironment, StudioEnvironment>;

// Who works, and for how long: what takes long is painted row by row on the pool. The picture does not depend on it.
struct Painting {
  WorkerPool* pool = nullptr;  // null: the caller alone
  Deadline deadline = {};
};

// RGB kFloat32 equirect in the convention of ibl/baked_environment.hpp, as large as its edges need. Errors: kDeadlineExceeded.
Image paint_environment(const ProceduralEnvironment& environment, const Painting& painting = {});

}  // namespace furnace
