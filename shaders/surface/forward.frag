#include "surface/constants.glsl"
#include "surface/needs.glsl"

layout(location = 0) in vec3 to_viewer_world;
layout(location = 1) in vec3 normal_world;
layout(location = 2) in vec4 tangent_world;
layout(location = 3) in vec4 uv01;
layout(location = 4) in vec4 vertex_color;
layout(location = 5) flat in SurfaceConstants constants;
#if NEEDS_POSITION
layout(location = 14) in vec3 position_world;
#else
const vec3 position_world = vec3(0.0);
#endif

layout(location = 0) out vec4 out_color;  // linear radiance, exposed, premultiplied by alpha

#include "surface/radiance.glsl"

float quad_lod(float lod) { return lod; }

// Here a fragment is a sample.
float quad_change2(vec3 value) {
  vec3 dx = dFdx(value), dy = dFdy(value);
  return dot(dx, dx) + dot(dy, dy);
}

void main() {
  Attributes a;
  a.to_viewer_world = to_viewer_world;
  a.position_world = position_world;
  a.normal_world = normal_world;
  a.tangent_world = tangent_world;
  a.uv01 = uv01;
  a.uv01_dx = 2.0 * dFdx(uv01);
  a.uv01_dy = 2.0 * dFdy(uv01);
  a.color = vertex_color;
  a.normal_change2 = quad_change2(normalize(normal_world));
  a.front = gl_FrontFacing;
#if FEATURE_TRANSMISSION
  a.world_from_model_scale = 1.0;
  a.curvature2 = 0.0;
#endif
  Surface s = read_surface(a);
  vec3 radiance = surface_radiance(s).rgb;
  const float largest_half = 65504.0;
  radiance = min(radiance * constants.atlas.z, vec3(largest_half));
#if FEATURE_ALPHA_BLEND
  out_color = vec4(radiance * s.base_color.a, s.base_color.a);
#else
#if FEATURE_ALPHA_MASK
  if (s.base_color.a < material.alpha_cutoff) discard;
#endif
  out_color = vec4(radiance, 1.0);
#endif
}
