// A pixel of the frame with what stands before it (the veil) and behind it (the background). All is premultiplied and the mean
// of samples is linear, so composing the mean is exact where the background is one for the pixel.
#include "interface/ground_block.glsl"
#include "lib/bicubic.glsl"
#include "lib/color.glsl"
#include "lib/sphere.glsl"
#include "lib/veil.glsl"

layout(binding = 0) uniform sampler2D frame_map;
#if FEATURE_VEIL
layout(binding = 1) uniform usampler2D veil_map;
#endif

layout(location = 5) uniform float exposure;  // multiplier

vec4 composed(ivec2 at, vec4 background) {
  vec4 pixel = texelFetch(frame_map, at, 0);
#if FEATURE_VEIL
  vec4 veil = veil_mean(texelFetch(veil_map, at, 0));
  pixel += vec4(veil.rgb / exposure, veil.a);
#endif
  return pixel + max(1.0 - pixel.a, 0.0) * background;
}

#if FEATURE_SKY
layout(binding = 5) uniform sampler2D sky_map;

layout(location = 0) in vec3 sky_ray;  // in the frame of the environment, not normalised
layout(location = 1) flat in vec2 sky;    // radiance per stored unit; mip level

vec3 sky_bicubic(vec2 uv) { return bicubic(sky_map, uv, 0.0).rgb; }

#if FEATURE_GROUND_PROJECTION
layout(location = 2) in vec3 sky_origin;   // m, from the middle of the dome
layout(location = 3) flat in vec2 dome;    // radius; height of its middle above the ground, m

// Where the ray meets the dome, whose lower part is cut off by a flat floor.
vec3 dome_point() {
  float a = dot(sky_ray, sky_ray);
  float b = dot(sky_origin, sky_ray);
  float c = dot(sky_origin, sky_origin) - dome.x * dome.x;
  vec3 point = sky_origin + sky_ray * ((sqrt(max(b * b - a * c, 0.0)) - b) / a);
  float level = -dome.y;
  bool meets_floor = point.y < level && sky_origin.y > level && sky_ray.y < 0.0;
  return meets_floor ? sky_origin + sky_ray * ((level - sky_origin.y) / sky_ray.y) : point;
}

vec3 sky_radiance() {
  vec3 direction = normalize(dome_point());
  float texel_rad = TWO_PI / float(textureSize(sky_map, 0).x);
  float lod = log2(max(length(dFdx(direction)), length(dFdy(direction))) / texel_rad);
  vec2 uv = equirect_from_direction(direction);
  return lod < 0.0 ? sky_bicubic(uv) : textureLod(sky_map, uv, lod).rgb;
}
#elif FEATURE_MAGNIFIED
vec3 sky_radiance() { return sky_bicubic(equirect_from_direction(sky_ray)); }
#else
vec3 sky_radiance() { return textureLod(sky_map, equirect_from_direction(sky_ray), sky.y).rgb; }
#endif

vec4 background() { return vec4(sky.x * sky_radiance(), 1.0); }
#else
layout(location = 0) in float from_top;            // 0 to 1, of the tile
layout(location = 3) uniform vec4 background_ends[2];  // premultiplied, at the upper and the lower edge of the tile

vec4 background() { return mix(background_ends[0], background_ends[1], from_top); }
#endif

#if FEATURE_GROUND_SHADOW
layout(binding = 13) uniform sampler2D ground_map;

layout(location = 4) in vec3 ground_at;
layout(location = 5) flat in float shadow_strength;

// The share of its light that the ground still gets, of each colour.
vec3 ground_light() {
  vec2 uv = ground_at.xy / max(ground_at.z, 1e-20);
  vec3 light = texture(ground_map, uv).rgb;
  // Shadows that reach beyond the map end softly. renderer/frame/ground_shadow.cpp leaves as much round the scene.
  vec2 inside = smoothstep(vec2(0.0), vec2(GROUND_FADE), min(uv, 1.0 - uv));
  float strength = ground_at.z > 0.0 ? shadow_strength * inside.x * inside.y : 0.0;
  return mix(vec3(1.0), light, strength);
}

// What lets no light through to a transparent background is alpha.
vec4 shadowed(vec4 color) {
  vec3 light = ground_light();
  return vec4(color.rgb * light, color.a + (1.0 - color.a) * (1.0 - luminance(light)));
}
#else
vec4 shadowed(vec4 color) { return color; }
#endif

vec4 frame_pixel(ivec2 at) { return composed(at, shadowed(background())); }
