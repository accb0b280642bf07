// Accumulated radiance -> what is stored. Pictures: exposure, tone curve, transfer function, straight alpha.
// Scene-linear film: exposure only, alpha stays premultiplied.
#include "lib/color.glsl"
#include "screen/frame_pixel.glsl"

layout(location = 1) uniform uint tone_curve;     // 0 pbr-neutral, 1 clip, 2 scene-linear
layout(location = 2) uniform float largest;       // of the film's format, for scene-linear
layout(location = 0) out vec4 out_color;

void main() {
  vec4 pixel = frame_pixel(ivec2(gl_FragCoord.xy));
  float alpha = clamp(pixel.a, 0.0, 1.0);
  if (tone_curve == 2u) {
    out_color = vec4(min(pixel.rgb * exposure, vec3(largest)), alpha);
    return;
  }
  vec3 color = alpha > 0.0 ? pixel.rgb * (exposure / alpha) : vec3(0.0);
  if (tone_curve == 0u) color = tone_pbr_neutral(color);
  out_color = vec4(srgb_from_linear(clamp(color, 0.0, 1.0)), alpha);
}
