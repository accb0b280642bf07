// What the filter's negative lobes take from a pixel. Where they see white at most, or no more than its other part sees, that
// is what the filter says. Beyond, the brighter it is the less it counts (Hampel 1974, "The Influence Curve and its Role in
// Robust Estimation": redescending), until the mean of the other part is left: one sample of a sun would else make black of all
// the pixels round it.
layout(binding = 0) uniform sampler2D positive_map;  // sums of the sub-frames of either sign
layout(binding = 1) uniform sampler2D negative_map;

layout(location = 0) uniform vec3 lobes;  // sums of the weights of either sign; radiance that is exposed to white
layout(location = 0) out vec4 out_color;

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec4 positive = texelFetch(positive_map, at, 0), negative = texelFetch(negative_map, at, 0);
  vec4 mean = positive / lobes.x;
  vec4 most = max(mean, vec4(vec3(lobes.z), 1.0));
  vec4 excess = max(negative / (lobes.y * most), 1.0);
  vec4 trusted = mix(mean, most, 1.0 / excess) * lobes.y;
  out_color = positive - mix(negative, trusted, greaterThan(excess, vec4(1.0)));
}
