#include "api/procedural_request.hpp"

#include "renderer/scene/solar_position.hpp"
#include "renderer/image/color.hpp"

#include <cmath>

namespace furnace::api {
namespace {

void read_stops(const Value& stops, std::vector<GradientStop>& target, Faults& faults) {
  if (!stops) return;
  target.clear();
  for (std::size_t i = 0; i < stops.size(); ++i) {
    const Value elevation = stops.at(i)["elevationDegrees"];
    GradientStop& stop = target.emplace_back();
    read(elevation, stop.elevation_deg);
    read(stops.at(i)["color"], stop.radiance);
    if (i > 0 && stop.elevation_deg < target[i - 1].elevation_deg)
      faults.add(ErrorCode::kUnprocessable, elevation,
                 fmt::format("lies below the stop before it, {} under {}; stops go upwards",
                             elevation.excerpt(), stops.at(i - 1)["elevationDegrees"].excerpt()));
  }
}

GradientEnvironment read_gradient(const Value& value, Faults& faults) {
  static constexpr Choice<GradientBlend> kBlends[] = {{"linear", GradientBlend::kLinear},
                                                      {"smooth", GradientBlend::kSmooth}};
  GradientEnvironment gradient;
  read_stops(value["stops"], gradient.stops, faults);
  read_choice(value["interpolation"], kBlends, gradient.blend);
  return gradient;
}

OvercastEnvironment read_overcast(const Value& value) {
  OvercastEnvironment overcast;
  read(value["zenithLuminance"], overcast.zenith_luminance);
  read(value["groundAlbedo"], overcast.ground_albedo);
  return overcast;
}

void refuse_place_without_date(const Value& value, Faults& faults) {
  for (const std::string_view key : {"latitudeDegrees", "longitudeDegrees", "northDegrees"})
    if (const Value place = value[key])
      faults.add(ErrorCode::kUnprocessable, place,
                 "is used only with \"dateTime\"; add that or leave it out");
}

void read_sun_of_date(const Value& value, ClearSkyEnvironment& sky, Faults& faults) {
  const Value date = value["dateTime"], latitude = value["latitudeDegrees"],
              longitude = value["longitudeDegrees"];
  for (const Value& place : {latitude, longitude})
    if (!place)
      faults.add(
          ErrorCode::kUnprocessable, date,
          fmt::format("needs \"{}\" beside it", place.pointer().substr(place.pointer().rfind('/') + 1)));
  const auto days = days_since_j2000(date.text());
  if (!days)
    faults.add(ErrorCode::kUnprocessable, date,
               fmt::format("must be a time in UTC from 1950 to 2050 like \"2026-06-21T16:30:00Z\", got {}",
                           date.excerpt()));
  if (!days || !latitude || !longitude) return;
  const SolarPosition sun = solar_position(*days, radians_from_degrees(latitude.number()),
                                           radians_from_degrees(longitude.number()));
  const double elevation_deg = sun.elevation_rad * 180 / kPi;
  if (elevation_deg < kMinSunElevationDeg)
    faults.add(
        ErrorCode::kUnprocessable, date,
        fmt::format("is night there: the sun stands at {:.1f} degrees, and the sky is drawn down to {}",
                    elevation_deg, kMinSunElevationDeg));
  double north_deg = 180;
  read(value["northDegrees"], north_deg);
  sky.sun_elevation_rad = sun.elevation_rad;
  // A compass goes clockwise as seen from above, azimuths in the world the other way.
  sky.sun_azimuth_rad = radians_from_degrees(north_deg) - sun.azimuth_rad;
}

ClearSkyEnvironment read_clear_sky(const Value& value, Faults& faults) {
  static constexpr Choice<SkyCalibration> kCalibrations[] = {{"white-card", SkyCalibration::kWhiteCard},
                                                             {"physical", SkyCalibration::kPhysical}};
  ClearSkyEnvironment sky;
  read(value["turbidity"], sky.turbidity);
  read(value["groundAlbedo"], sky.ground_albedo);
  read_degrees(value["elevationDegrees"], sky.sun_elevation_rad);
  read_degrees(value["azimuthDegrees"], sky.sun_azimuth_rad);
  read(value["sunDisc"], sky.sun_disc);
  read_degrees(value["sunRadiusDegrees"], sky.sun_radius_rad);
  read_choice(value["calibration"], kCalibrations, sky.calibration);
  if (value["dateTime"])
    read_sun_of_date(value, sky, faults);
  else
    refuse_place_without_date(value, faults);
  if (const Value radius = value["sunRadiusDegrees"]; radius && !sky.sun_disc)
    faults.add(ErrorCode::kUnprocessable, radius, "is not used without the sun's disc; leave it out");
  return sky;
}

SoftBox read_soft_box(const Value& value, Faults& faults) {
  static constexpr Choice<LightShape> kShapes[] = {{"rectangle", LightShape::kRectangle},
                                                   {"disc", LightShape::kDisc}};
  SoftBox box;
  read_choice(value["shape"], kShapes, box.shape);
  read_degrees(value["azimuthDegrees"], box.azimuth_rad);
  read_degrees(value["elevationDegrees"], box.elevation_rad);
  read_degrees(value["rollDegrees"], box.roll_rad);
  read_degrees(value["widthDegrees"], box.width_rad);
  read_degrees(value["heightDegrees"], box.height_rad);
  read(value["color"], box.color);
  read(value["luminance"], box.luminance);
  read(value["feather"], box.feather);
  read(value["hotspot"], box.hotspot);
  constexpr double kBlack = 1e-6;  // below, no scale leads to a luminance
  if (luminance_rec709(box.color.r, box.color.g, box.color.b) < kBlack)
    faults.add(ErrorCode::kUnprocessable, value["color"],
               "is black, which has no luminance; for a light that is off leave the light out");
  return box;
}

StudioEnvironment read_studio(const Value& value, Faults& faults) {
  StudioEnvironment studio;
  if (const Value room = value["room"]) studio.room = read_gradient(room, faults);
  if (const Value lights = value["lights"]) {
    studio.lights.clear();
    for (std::size_t i = 0; i < lights.size(); ++i)
      studio.lights.push_back(read_soft_box(lights.at(i), faults));
  }
  return studio;
}

}  // namespace

std::optional<ProceduralEnvironment> read_procedural(const Value& map, Faults& faults) {
  const Value type = map["type"];
  const std::string_view kind = type ? type.text() : "color";
  if (kind == "gradient") return read_gradient(map, faults);
  if (kind == "overcast") return read_overcast(map);
  if (kind == "clear-sky") return read_clear_sky(map, faults);
  if (kind == "studio") return read_studio(map, faults);
  FURNACE_CHECK(kind == "color", "{} is not handled", kind);
  return std::nullopt;
}

}  // namespace furnace::api
