// The veil's four samples of a pixel, in one texel.
#include "lib/veil.glsl"

layout(binding = 0) uniform sampler2D samples;

layout(location = 0) out uvec4 out_pixel;

void main() {
  vec4 sum = vec4(0.0), passing;
  for (uint i = 0u; i < SAMPLE_COUNT; ++i) {
    vec4 veil = texelFetch(samples, sample_at(ivec2(gl_FragCoord.xy), i), 0);
    sum += veil;
    passing[i] = 1.0 - veil.a;
  }
  out_pixel = veil_pixel(sum / float(SAMPLE_COUNT), passing);
}
