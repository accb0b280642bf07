// Sigg and Hadwiger 2005, "Fast Third-Order Texture Filtering": the cubic B-spline, which cannot ring next to a sun, by
// four bilinear fetches.
vec4 bicubic(sampler2D map, vec2 uv, float level) {
  vec2 size = vec2(textureSize(map, int(level)));
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
  return g0.y * (g0.x * textureLod(map, p0, level) + g1.x * textureLod(map, vec2(p1.x, p0.y), level)) +
         g1.y * (g0.x * textureLod(map, vec2(p0.x, p1.y), level) + g1.x * textureLod(map, p1, level));
}

// Between two levels of a mipmapped picture; at level 0 as it is. A loop, so that compilers take it once.
vec4 bicubic_lod(sampler2D map, vec2 uv, float lod) {
  float low = floor(lod), high = lod > low ? low + 1.0 : low;
  vec4 sum = vec4(0.0);
  for (float level = low; level <= high; level += 1.0) {
    vec4 value = level < 0.5 ? textureLod(map, uv, 0.0) : bicubic(map, uv, level);
    sum += value * (1.0 - abs(lod - level));
  }
  return sum;
}
