#include "lib/constants.glsl"

// Equirect convention: row 0 is +Y, the centre column looks to +X, u = 0.75 to +Z (renderer/ibl/baked_environment.hpp).
vec2 equirect_from_direction(vec3 d) {
  float u = atan(d.z, d.x) * (1.0 / TWO_PI) + 0.5;
  float v = atan(length(d.xz), d.y) * INV_PI;
  return vec2(u, v);
}

// Prefiltered levels are mixed linearly in this. The same lines stand in renderer/ibl/baked_environment.hpp.
float level_coordinate(float perceptual_roughness) {
  float cube = perceptual_roughness * perceptual_roughness * perceptual_roughness;
  return cube / (1.0 + 1.8 * cube);
}

// Cigolle et al. 2014, "A Survey of Efficient Representations for Independent Unit Vectors".
// The same lines stand in renderer/ibl/octahedral_atlas.cpp.
vec2 octahedral_from_direction(vec3 d) {
  vec2 p = d.xz / (abs(d.x) + abs(d.y) + abs(d.z));
  if (d.y < 0.0) p = (1.0 - abs(p.yx)) * vec2(p.x >= 0.0 ? 1.0 : -1.0, p.y >= 0.0 ? 1.0 : -1.0);
  return p * 0.5 + 0.5;
}

// Some unit vector at right angles to unit `n`.
vec3 unit_across(vec3 n) { return normalize(cross(abs(n.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0), n)); }
