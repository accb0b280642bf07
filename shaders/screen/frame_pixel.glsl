// A pixel of the frame with what stands before it (the veil) and behind it (the background). All is premultiplied and the mean
// of samples is linear, so composing the mean is exact where the background is one for the pixel.
#include "lib/sphere.glsl"
#include "lib/visibility.glsl"

layout(binding = 0) uniform sampler2D frame_map;
#if FEATURE_VEIL
layout(binding = 1) uniform sampler2D veil_map;
#endif

layout(location = 4) uniform float exposure;  // multiplier

vec4 composed(ivec2 at, vec4 background) {
  vec4 pixel = texelFetch(frame_map, at, 0);
#if FEATURE_VEIL
  vec4 veil = vec4(0.0);
  for (uint i = 0u; i < SAMPLE_COUNT; ++i) veil += texelFetch(veil_map, sample_at(at, i), 0) / float(SAMPLE_COUNT);
  pixel += vec4(veil.rgb / exposure, veil.a);
#endif
  return pixel + max(1.0 - pixel.a, 0.0) * background;
}

#if FEATURE_SKY
layout(binding = 5) uniform sampler2D sky_map;

layout(location = 0) in vec3 sky_ray;  // in the frame of the environment, not normalised
layout(location = 1) flat in vec2 sky;    // radiance per stored unit; mip level

// Sigg and Hadwiger 2005, "Fast Third-Order Texture Filtering": the cubic B-spline, which cannot ring next to a sun, by
// four bilinear fetches.
vec3 sky_bicubic(vec2 uv) {
  vec2 size = vec2(textureSize(sky_map, 0));
  vec2 at = uv * size - 0.5;
  vec2 f = fract(at);
  vec2 base = floor(at);
  vec2 f2 = f * f;
  vec2 f3 = f2 * f;
  vec2 w0 = (1.0 - f) * (1.0 - f) * (1.0 - f) / 6.0;
  vec2 w1 = (3.0 * f3 - 6.0 * f2 + 4.0) / 6.0;
  vec2 w3 = f3 / 6.0;
  vec2 w2 = 1.0 - w0 - w1 - w3;
  vec2 g0 = w0 + w1;
  vec2 g1 = w2 + w3;
  vec2 p0 = (base - 0.5 + w1 / g0) / size;
  vec2 p1 = (base + 1.5 + w3 / g1) / size;
  return g0.y * (g0.x * textureLod(sky_map, p0, 0.0).rgb + g1.x * textureLod(sky_map, vec2(p1.x, p0.y), 0.0).rgb) +
         g1.y * (g0.x * textureLod(sky_map, vec2(p0.x, p1.y), 0.0).rgb + g1.x * textureLod(sky_map, p1, 0.0).rgb);
}

vec4 frame_pixel(ivec2 at) {
  vec2 uv = equirect_from_direction(sky_ray);
#if FEATURE_MAGNIFIED
  vec3 radiance = sky_bicubic(uv);
#else
  vec3 radiance = textureLod(sky_map, uv, sky.y).rgb;
#endif
  return composed(at, vec4(sky.x * radiance, 1.0));
}
#else
layout(location = 3) uniform vec4 background;  // premultiplied

vec4 frame_pixel(ivec2 at) { return composed(at, background); }
#endif
