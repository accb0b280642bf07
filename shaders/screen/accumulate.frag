// One sub-frame, weighted; added into the accumulated frame by blending.
#include "screen/frame_pixel.glsl"

layout(location = 0) uniform float weight;  // 1 / sub-frames
layout(location = 0) out vec4 out_color;

void main() { out_color = frame_pixel(ivec2(gl_FragCoord.xy)) * weight; }
