// One of the numbers of a surface, in place of its radiance. Means over a pixel are taken by who calls.
#include "surface/film_layer.glsl"
#include "surface/inputs.glsl"

// A line a pixel wide along an edge that lies so many pixels away, as a pixel as wide sees it.
float line_cover(float away_px) { return clamp(1.0 - away_px, 0.0, 1.0); }

vec3 surface_value(Attributes a, Surface s) {
  // Points and lines may have no normal.
  if (shown == SHOWN_NORMAL) return dot(a.normal_world, a.normal_world) > 0.0 ? s.normal : vec3(0.0);
  if (shown == SHOWN_ALBEDO) return s.base_color.rgb;
  if (shown == SHOWN_FACTORS) return vec3(s.perceptual_roughness, s.metallic, s.occlusion);
  if (shown == SHOWN_WIREFRAME) return vec3(line_cover(a.edge_px));
  if (shown == SHOWN_UV) return vec3(a.uv01.xy, 0.0);
  if (shown == SHOWN_NUMBERS) return vec3(a.numbers, 0.0);
  return s.position;
}
