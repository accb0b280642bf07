// Lights as they are seen from a place.
#include "interface/light_block.glsl"
#include "lib/constants.glsl"
#include "lib/lobe_tables.glsl"
#include "lib/ltc.glsl"
#include "lib/sphere.glsl"

layout(std140, binding = 4) uniform LightUniform { LightBlock lights; };

#if FEATURE_LIGHT_PROFILES
// [0, 1], towards unit `away`: renderer/scene/light_profile.hpp.
float profile_share(LightRow light, vec3 away) {
  if (light.across.w == 0.0) return 1.0;
  vec3 y = cross(light.across.xyz, light.axis.xyz);
  float vertical = acos(clamp(dot(light.axis.xyz, away), -1.0, 1.0));
  float horizontal = atan(dot(y, away), dot(light.across.xyz, away));
  vec2 at = vec2(fract(horizontal / TWO_PI), acos(clamp(1.0 - 2.0 * INV_PI * vertical, -1.0, 1.0)) * INV_PI);
  vec2 size = vec2(textureSize(lobe_tables, 0).xy);
  return textureLod(lobe_tables, vec3((at * (size - 1.0) + 0.5) / size, light.across.w), 0.0).r;
}
#endif

// Of a directional, point or spot light: a disc of angular radius `radius_rad`, its middle at unit `towards`.
struct LightAt {
  vec3 towards;
  float distance_m;  // 1 of a directional light
  float radius_rad;
  vec3 irradiance;   // of a plane that faces it
};

LightAt light_at(LightRow light, vec3 position) {
  LightAt at = LightAt(light.place.xyz, 1.0, light.axis.w, light.intensity.rgb);
  if (light.place.w != LIGHT_PLACE) return at;
  at.towards -= position;
  at.distance_m = max(length(at.towards), 1e-6);
  at.towards /= at.distance_m;
  // KHR_lights_punctual: inverse square, a window at the range, the falloff of the cone. Within a sphere the light grows
  // no more.
  float reach2 = max(at.distance_m * at.distance_m, light.axis.w * light.axis.w);
  float q = reach2 * light.intensity.w;
  float cone = clamp(dot(light.axis.xyz, -at.towards) * light.cone.x + light.cone.y, 0.0, 1.0);
  at.irradiance *= clamp(1.0 - q * q, 0.0, 1.0) * cone * cone / reach2;
#if FEATURE_LIGHT_PROFILES
  at.irradiance *= profile_share(light, -at.towards);
#endif
  at.radius_rad = atan(light.axis.w, at.distance_m);
  return at;
}

#if FEATURE_SURFACE_LIGHTS
bool shines_towards(LightRow light, vec3 to_light) {
  return light.place.w == LIGHT_BALL || light.across.w > 0.0 || dot(light.axis.xyz, to_light) < 0.0;
}

// One as it is seen from a surface: corners on two axes about its middle, m from there.
struct Outline {
  vec3 middle, x, y;
};

Outline outline_of(LightRow light, vec3 position) {
  Outline o;
  o.middle = light.place.xyz - position;
  if (light.place.w == LIGHT_BALL) {
    // The disc through its middle that covers as much of the view.
    float distance2 = dot(o.middle, o.middle), radius = light.axis.w;
    vec3 z = o.middle * inversesqrt(distance2);
    o.x = unit_across(z) * radius * sqrt(distance2 / max(distance2 - radius * radius, 1e-4 * distance2));
    o.y = cross(z, o.x);
  } else {
    o.x = light.across.xyz * light.cone.z;
    o.y = cross(light.across.xyz, light.axis.xyz) * light.cone.w;
  }
  return o;
}

vec3 corner_at(Outline o, int row, int i) {
  vec4 two = lights.corners[row + (i >> 1)];
  vec2 at = (i & 1) == 0 ? two.xy : two.zw;
  return o.middle + at.x * o.x + at.y * o.y;
}

// The share of a lobe that the light takes; `cosine_from_world` turns the lobe into a cosine about z. `corners`: first row, count.
float lobe_share(Outline o, ivec2 corners, mat3 cosine_from_world) {
  PolygonSum sum = begin_polygon(cosine_from_world * corner_at(o, corners.x, corners.y - 1));
  for (int i = 0; i < corners.y; ++i) add_corner(cosine_from_world * corner_at(o, corners.x, i), sum);
  return end_polygon(sum);
}

// Of all of the light, not of a sub-frame's part.
ivec2 whole_outline(LightRow light) {
  return light.place.w == LIGHT_RECTANGLE ? ivec2(DISC_CORNERS / 2u, 4) : ivec2(0, DISC_CORNERS);
}

// World -> a frame with unit `normal` as z and unit `x`, which is level on it.
mat3 plane_frame(vec3 normal, vec3 x) { return transpose(mat3(x, cross(normal, x), normal)); }
#endif
