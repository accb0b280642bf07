#include "api/light_request.hpp"

#include <cmath>

namespace furnace::api {
namespace {

void read_direction(const Value& value, Light& light, Faults& faults) {
  if (!value) return;
  glm::dvec3 direction(0);
  read(value, direction);
  if (glm::length(direction) > 0) {
    light.direction = glm::normalize(direction);
  } else {
    faults.add(ErrorCode::kUnprocessable, value, "has no length; straight down is [0, -1, 0]");
  }
}

void read_profile(const Value& light, const AssetResolver& assets, Light& out, Faults& faults) {
  const Value reference = light["profile"];
  if (!reference) {
    faults.add(ErrorCode::kUnprocessable, light, "an ies light needs its file as profile");
    return;
  }
  faults.collect(reference, [&] {
    const Blob file = assets.read(std::string(reference.text()), reference.pointer());
    const auto bytes = file.bytes();
    out.profile = std::make_shared<const LightProfile>(
        parse_ies({reinterpret_cast<const char*>(bytes.data()), bytes.size()}));
  });
}

// In the unit of Light::intensity, of its brightest side.
double read_brightness(const Value& value, const Light& light) {
  constexpr double kLux = 1, kCandela = 10, kNits = 10;
  const bool is_ies = light.profile != nullptr;
  double brightness = light.kind == LightKind::kDirectional ? kLux : light.is_surface() ? kNits : kCandela;
  if (is_ies) brightness = light.profile->peak_candela;
  read(value["illuminanceLux"], brightness);
  read(value["intensityCandela"], brightness);
  read(value["luminanceNits"], brightness);
  const Value flux = value["fluxLumen"];
  if (!flux) return brightness;
  // Of a surface that is as bright from every side; of a spot that is even within its outer cone.
  if (light.is_surface()) return flux.number() / (kPi * light_area_m2(light));
  if (is_ies) return flux.number() * light.profile->peak_candela / light.profile->flux_lumen;
  if (light.kind == LightKind::kSpot) return flux.number() / (2 * kPi * (1 - std::cos(light.outer_cone_rad)));
  return flux.number() / (4 * kPi);
}

}  // namespace

Light read_light(const Value& value, const AssetResolver& assets, Faults& faults) {
  static constexpr Choice<LightKind> kKinds[] = {{"directional", LightKind::kDirectional},
                                                 {"point", LightKind::kPoint},
                                                 {"spot", LightKind::kSpot},
                                                 {"sphere", LightKind::kSphere},
                                                 {"disc", LightKind::kDisc},
                                                 {"rectangle", LightKind::kRectangle},
                                                 {"ies", LightKind::kPoint}};
  Light light;
  read_choice(value["type"], kKinds, light.kind);
  if (value["type"].text() == "ies") read_profile(value, assets, light, faults);
  read(value["name"], light.name);
  glm::vec3 color(1);
  read(value["position"], light.position);
  read_direction(value["direction"], light, faults);
  read(value["color"], color);
  read_degrees(value["innerConeDegrees"], light.inner_cone_rad);
  read_degrees(value["outerConeDegrees"], light.outer_cone_rad);
  if (light.inner_cone_rad >= light.outer_cone_rad)
    faults.add(ErrorCode::kUnprocessable, value, "innerConeDegrees must be less than outerConeDegrees");
  read(value["rangeMetres"], light.range_m);
  constexpr double kSurfaceRadius = 0.5;
  if (light.is_surface()) light.radius_m = kSurfaceRadius;
  read(value["radiusMetres"], light.radius_m);
  if (light.is_surface() && light.radius_m == 0)
    faults.add(ErrorCode::kUnprocessable, value["radiusMetres"],
               "must be above 0 for a surface; a light of no size is a point");
  read_degrees(value["angularRadiusDegrees"], light.angular_radius_rad);
  read(value["widthMetres"], light.width_m);
  read(value["heightMetres"], light.height_m);
  read_degrees(value["rollDegrees"], light.roll_rad);
  read(value["twoSided"], light.two_sided);
  light.intensity = glm::dvec3(color) * read_brightness(value, light);
  read(value["shadow"], light.casts_shadow);
  return light;
}

}  // namespace furnace::api
