// The bits of a lamp's places that do not reach the ground here -> the irradiance by those that do.
#include "interface/ground_block.glsl"
#include "surface/light_at.glsl"

layout(std140, binding = 3) uniform GroundUniform { GroundBlock ground; };
layout(binding = 0) uniform usampler2D places_map;
layout(location = 0) out vec4 out_irradiance;

vec3 irradiance_at(LightRow light, vec3 position) {
  const vec3 kUp = vec3(0.0, 1.0, 0.0);
#if FEATURE_SURFACE_LIGHTS
  if (light.place.w >= LIGHT_RECTANGLE) {
    vec3 towards = normalize(light.place.xyz - position);
    if (!shines_towards(light, towards)) return vec3(0.0);
    return light.intensity.rgb * PI * lobe_share(outline_of(light, position), whole_outline(light), plane_frame(kUp, vec3(1.0, 0.0, 0.0)));
  }
#endif
  LightAt at = light_at(light, position);
  return at.irradiance * max(at.towards.y, 0.0);
}

// What one place of the lamp sheds on the ground, but for a factor that all have.
float weight_of(LightRow light, vec4 place, vec2 at) {
  float height = 1.0 / place.z;
  vec3 way = vec3(place.xy * height, height).xzy - vec3(at.x, 0.0, at.y);
  float distance2 = dot(way, way);
  float turned = 1.0;
#if FEATURE_SURFACE_LIGHTS
  if (light.place.w == LIGHT_RECTANGLE || light.place.w == LIGHT_DISC)
    turned = abs(dot(light.axis.xyz, way)) * inversesqrt(distance2);
#endif
  return turned * way.y * inversesqrt(distance2) / distance2;
}

float seen_share(LightRow light, uvec4 hidden, vec2 at) {
  uvec4 counts = uvec4(bitCount(hidden));
  uint count = counts.x + counts.y + counts.z + counts.w;
  if (ground.light_count == 0u || count == 0u) return 1.0;
  if (count == ground.light_count) return 0.0;
  float seen = 0.0, all = 0.0;
  for (uint i = 0u; i < ground.light_count; ++i) {
    float weight = weight_of(light, ground.light[i], at);
    all += weight;
    seen += float(~hidden[i >> 5u] >> (i & 31u) & 1u) * weight;
  }
  return seen / all;
}

void main() {
  vec2 at = ground.rectangle.xy + ground.rectangle.zw * gl_FragCoord.xy / vec2(textureSize(places_map, 0));
  LightRow light = lights.lights[ground.lamp];
  float seen = seen_share(light, texelFetch(places_map, ivec2(gl_FragCoord.xy), 0), at);
  out_irradiance = vec4(irradiance_at(light, vec3(at.x, ground.level, at.y)) * seen, 0.0);
}
