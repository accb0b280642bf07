// What glows of the frame, exposed: the film from which renderer/frame/bloom.cpp makes the glow.
#include "lib/glow.glsl"
#include "screen/frame_pixel.glsl"

layout(location = 8) uniform vec2 bloom;  // intensity, threshold
layout(location = 0) out vec4 out_color;

void main() {
  vec3 exposed = max(frame_pixel(ivec2(gl_FragCoord.xy)).rgb, 0.0) * exposure;
  out_color = vec4(bright_part(exposed, bloom.y), 1.0);
}
