// Accumulated radiance -> what is stored. Pictures: exposure, bloom, grade, tone curve, transfer function, straight alpha.
// Scene-linear film: exposure, bloom and grade only, alpha stays premultiplied.
#include "lib/color.glsl"
#include "lib/glow.glsl"
#include "lib/grade.glsl"
#include "lib/tone.glsl"
#include "screen/frame_pixel.glsl"

layout(location = 1) uniform uint tone_curve;     // numbers of renderer/frame/pass_resolve.cpp
layout(location = 2) uniform float largest;       // of the film's format, for scene-linear
#if FEATURE_GRADE
layout(location = 6) uniform vec2 grade;          // contrast, saturation
layout(location = 7) uniform mat3 white_balance;
#endif
#if FEATURE_BLOOM
layout(binding = 2) uniform sampler2D glow_map;  // exposed, of the whole picture
#if FEATURE_EMISSION
layout(binding = 3) uniform sampler2D emission_map;
#endif
layout(location = 8) uniform vec2 bloom;             // intensity, threshold
layout(location = 9) uniform vec4 picture_from_tile;  // uv of the tile's upper left; of a pixel
#endif
#if FEATURE_DITHER
layout(location = 10) uniform vec2 tile_px;  // its upper left corner in the picture
#endif
layout(location = 0) out vec4 out_color;

#if FEATURE_BLOOM
// What is spread is taken from where it was. Before a transparent background the glow covers it by its brightness, so that
// straight colours can carry it.
vec4 bloomed(vec4 pixel, ivec2 at) {
#if FEATURE_EMISSION
  vec3 source = max(texelFetch(emission_map, at, 0).rgb, 0.0);
#else
  vec3 source = pixel.rgb;
#endif
  vec3 glow = bloom.x * bicubic(glow_map, picture_from_tile.xy + gl_FragCoord.xy * picture_from_tile.zw, 0.0).rgb;
  vec3 taken = bloom.x * bright_part(source * exposure, bloom.y);
  vec3 color = max(pixel.rgb + (glow - taken) / exposure, 0.0);
  return vec4(color, pixel.a + (1.0 - pixel.a) * min(max(glow.r, max(glow.g, glow.b)), 1.0));
}
#endif

vec3 toned(vec3 color) {
  if (tone_curve == 0u) color = tone_pbr_neutral(color);
#if FEATURE_GRADE
  if (tone_curve == 3u) color = tone_aces(color);
  if (tone_curve == 4u) color = tone_agx(color);
  if (tone_curve == 5u) color = tone_reinhard(color);
#endif
  return color;
}

#if FEATURE_DITHER
// Jimenez 2014, "Next Generation Post Processing in Call of Duty: Advanced Warfare": interleaved gradient noise, of each channel from
// another place. Less than half a step of 8 bits, so that a step stays what it is, black and white and whole alpha among them.
vec4 dithered(vec4 color) {
  const float kStep = 0.999 / 255.0;
  vec2 at = floor(gl_FragCoord.xy) + tile_px;
  vec4 noise = fract(52.9829189 * fract((at.x + 5.588238 * vec4(0.0, 1.0, 2.0, 3.0)) * 0.06711056 + at.y * 0.00583715));
  return color.a > 0.0 ? color + (noise - 0.5) * kStep : color;
}
#endif

void main() {
  vec4 pixel = frame_pixel(ivec2(gl_FragCoord.xy));
  pixel.rgb = max(pixel.rgb, 0.0);  // a pixel filter may have negative lobes
#if FEATURE_BLOOM
  vec4 sharp = pixel;
  pixel = bloomed(pixel, ivec2(gl_FragCoord.xy));
  if (tone_curve == 6u) {
    out_color = pixel - sharp;
    return;
  }
#endif
  float alpha = clamp(pixel.a, 0.0, 1.0);
  // Of few sub-frames environment_visibility.glsl may take more light than there is.
  pixel.rgb = max(pixel.rgb, vec3(0.0));
#if FEATURE_GRADE
  // Contrast is not linear: it sees straight colours.
  float scale = exposure / (alpha > 0.0 ? alpha : 1.0);
  pixel.rgb = graded(pixel.rgb * scale, white_balance, grade.x, grade.y) / scale;
#endif
  if (tone_curve == 2u) {
    out_color = vec4(min(pixel.rgb * exposure, vec3(largest)), alpha);
    return;
  }
  vec3 color = alpha > 0.0 ? pixel.rgb * (exposure / alpha) : vec3(0.0);
  out_color = vec4(srgb_from_linear(clamp(toned(color), 0.0, 1.0)), alpha);
#if FEATURE_DITHER
  out_color = dithered(out_color);
#endif
}
