// Accumulated radiance -> what is stored. Pictures: exposure, grade, tone curve, transfer function, straight alpha.
// Scene-linear film: exposure and grade only, alpha stays premultiplied.
#include "lib/color.glsl"
#include "lib/grade.glsl"
#include "lib/tone.glsl"
#include "screen/frame_pixel.glsl"

layout(location = 1) uniform uint tone_curve;     // numbers of renderer/frame/pass_resolve.cpp
layout(location = 2) uniform float largest;       // of the film's format, for scene-linear
#if FEATURE_GRADE
layout(location = 6) uniform vec2 grade;          // contrast, saturation
layout(location = 7) uniform mat3 white_balance;
#endif
layout(location = 0) out vec4 out_color;

vec3 toned(vec3 color) {
  if (tone_curve == 0u) color = tone_pbr_neutral(color);
#if FEATURE_GRADE
  if (tone_curve == 3u) color = tone_aces(color);
  if (tone_curve == 4u) color = tone_agx(color);
  if (tone_curve == 5u) color = tone_reinhard(color);
#endif
  return color;
}

void main() {
  vec4 pixel = frame_pixel(ivec2(gl_FragCoord.xy));
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
}
