// Shades what sample `layer` of each pixel sees, times the share of the pixel that it stands for.
#include "lib/veil.glsl"
#include "surface/constants.glsl"
#include "surface/deferred_constants.glsl"
#include "surface/tangent_frame.glsl"

layout(binding = 8) uniform usampler2D visibility_map;
layout(binding = 9) uniform usampler2D shares_map;
layout(binding = 10) uniform samplerBuffer vertices;    // deferred.draw.y rows a vertex
layout(binding = 11) uniform usamplerBuffer triangles;  // three vertex numbers each
#if FEATURE_VEIL
layout(binding = 12) uniform usampler2D veil_map;
#endif

layout(location = 0) uniform uint layer;
layout(location = 0) in vec2 ndc;
layout(location = 1) in vec3 to_viewer_world;
layout(location = 2) flat in SurfaceConstants constants;
layout(location = 11) flat in DeferredConstants deferred;
layout(location = 0) out vec4 out_color;  // linear radiance, premultiplied

#include "surface/radiance.glsl"

// What the pixel sees; another draw's pixels are shaded beside ours to complete a quad, and must be known for that.
uint seen_patch;  // of which draw
bool is_ours;

float quad_lod(float lod) {
  // The least of the quad, leaving out pixels that are not ours.
  const float other = 64.0;
  lod = is_ours ? lod : other;
  float right = lod + dFdxFine(lod) * (gl_FragCoord.x - 2.0 * floor(0.5 * gl_FragCoord.x) < 1.0 ? 1.0 : -1.0);
  lod = min(lod, right);
  float below = lod + dFdyFine(lod) * (gl_FragCoord.y - 2.0 * floor(0.5 * gl_FragCoord.y) < 1.0 ? 1.0 : -1.0);
  return min(lod, below);
}

float quad_change2(vec3 value) {
  vec2 seen = vec2(seen_patch & 0xffffu, seen_patch >> 16u);  // exact as floats
  vec3 dx = dFdxFine(seen) == vec2(0.0) ? dFdxFine(value) : vec3(0.0);
  vec3 dy = dFdyFine(seen) == vec2(0.0) ? dFdyFine(value) : vec3(0.0);
  return dot(dx, dx) + dot(dy, dy);
}

// Clip x, y and w of a vertex.
vec3 clip_corner(int row) {
  vec4 position = vec4(texelFetch(vertices, row).xyz, 1.0);
  return vec3(dot(deferred.clip_x_from_model, position), dot(deferred.clip_y_from_model, position),
              dot(deferred.clip_w_from_model, position));
}

// Olano and Greer 1997, "Triangle Scan Conversion using 2D Homogeneous Coordinates": perspective-correct weights of the
// corners at `ndc`, not normalised, their sum positive for one sense of winding. Differences are taken first, so that small
// triangles keep their digits.
vec3 corner_weights(vec3 c[3], vec2 at) {
  vec2 q0 = c[0].xy - at * c[0].z;
  vec2 q1 = c[1].xy - at * c[1].z;
  vec2 q2 = c[2].xy - at * c[2].z;
  return vec3(q1.x * q2.y - q1.y * q2.x, q2.x * q0.y - q2.y * q0.x, q0.x * q1.y - q0.y * q1.x);
}

vec3 normalised_weights(vec3 weights) {
  float sum = weights.x + weights.y + weights.z;
  return weights / (abs(sum) > 0.0 ? sum : 1.0);
}

vec4 interpolate(ivec3 rows, int row, vec3 weights) {
  return texelFetch(vertices, rows.x + row) * weights.x + texelFetch(vertices, rows.y + row) * weights.y +
         texelFetch(vertices, rows.z + row) * weights.z;
}

// How much v / |v| changes when v changes by d, squared.
float unit_change2(vec3 v, vec3 d) {
  float length2 = dot(v, v);
  if (!(length2 > 0.0)) return 0.0;
  vec3 across = d - v * (dot(v, d) / length2);
  return dot(across, across) / length2;
}

// `ndc_at`: where in the pixel.
Attributes seen_attributes(uint triangle, vec2 ndc_at) {
  ivec3 corner = ivec3(3u * triangle) + ivec3(0, 1, 2);
  ivec3 rows = int(deferred.draw.y) * ivec3(texelFetch(triangles, corner.x).x, texelFetch(triangles, corner.y).x,
                                             texelFetch(triangles, corner.z).x);
  vec3 c[3] = vec3[3](clip_corner(rows.x), clip_corner(rows.y), clip_corner(rows.z));
  vec3 weights = corner_weights(c, ndc_at);
  bool front = (weights.x + weights.y + weights.z > 0.0) == (deferred.scalars.x > 0.0);
  vec3 at = normalised_weights(weights);
  vec3 dx = normalised_weights(corner_weights(c, ndc_at + vec2(deferred.scalars.y, 0.0))) - at;
  vec3 dy = normalised_weights(corner_weights(c, ndc_at + vec2(0.0, deferred.scalars.z))) - at;
  // The pixel's centre may lie outside of the triangle that its sample sees. Up to the triangle's own size beyond it the
  // attributes are continued: small triangles of a smooth surface would else be shaded now here, now there.
  at = max(at, vec3(-1.0));
  at /= at.x + at.y + at.z;

  Attributes a;
  a.to_viewer_world = to_viewer_world;
#if NEEDS_POSITION
  a.position_world = deferred.world_from_model * interpolate(rows, 0, at).xyz + deferred.origin.xyz;
#else
  a.position_world = vec3(0.0);
#endif
  vec3 normal_0 = texelFetch(vertices, rows.x + 1).xyz, normal_1 = texelFetch(vertices, rows.y + 1).xyz,
       normal_2 = texelFetch(vertices, rows.z + 1).xyz;
  vec3 normal_model = normal_0 * at.x + normal_1 * at.y + normal_2 * at.z;
  vec3 normal_world = deferred.world_from_model_normal * normal_model;
  a.normal_world = with_length_of(normal_model, normal_world);
  a.normal_change2 =
      unit_change2(normal_world, deferred.world_from_model_normal * (normal_0 * dx.x + normal_1 * dx.y + normal_2 * dx.z)) +
      unit_change2(normal_world, deferred.world_from_model_normal * (normal_0 * dy.x + normal_1 * dy.y + normal_2 * dy.z));
  a.tangent_world = vec4(0.0);
#if NEEDS_TANGENT
  vec4 tangent = interpolate(rows, 2, at);
  a.tangent_world =
      vec4(with_length_of(tangent.xyz, deferred.world_from_model * tangent.xyz), tangent.w * deferred.scalars.x);
#endif
  vec4 uv_0 = texelFetch(vertices, rows.x + 3), uv_1 = texelFetch(vertices, rows.y + 3),
       uv_2 = texelFetch(vertices, rows.z + 3);
  a.uv01 = uv_0 * at.x + uv_1 * at.y + uv_2 * at.z;
  a.uv01_dx = uv_0 * dx.x + uv_1 * dx.y + uv_2 * dx.z;
  a.uv01_dy = uv_0 * dy.x + uv_1 * dy.y + uv_2 * dy.z;
  a.color = vec4(1.0);
#if FEATURE_VERTEX_COLOR
  a.color = interpolate(rows, 4, at);
#endif
  a.front = front;
#if FEATURE_SURFACE_VALUE
  vec3 away_px = at * inversesqrt(max(dx * dx + dy * dy, 1e-20));
  a.edge_px = min(away_px.x, min(away_px.y, away_px.z));
  a.numbers = vec2(deferred.draw.x, triangle);
#endif
#if FEATURE_TRANSMISSION
  a.world_from_model_scale = deferred.scalars.w;
  vec3 step_x = deferred.world_from_model * interpolate(rows, 0, dx).xyz;
  vec3 step_y = deferred.world_from_model * interpolate(rows, 0, dy).xyz;
  a.curvature2 = a.normal_change2 / max(dot(step_x, step_x) + dot(step_y, step_y), 1e-20);
#endif
  return a;
}

// Of the pixel: the samples that take this shading, where no veil hides them.
float pixel_share(ivec2 pixel, uint shares) {
  float share = 0.0;
#if FEATURE_VEIL
  vec4 passing = veil_passing(texelFetch(veil_map, pixel, 0));
#endif
  for (uint i = 0u; i < SAMPLE_COUNT; ++i) {
    if (shaded_by(shares, i) != layer) continue;
#if FEATURE_VEIL
    share += passing[i];
#else
    share += 1.0;
#endif
  }
  return share / float(SAMPLE_COUNT);
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  uvec2 texel = texelFetch(visibility_map, sample_at(pixel, layer), 0).xy;
  seen_patch = key_of(texel.y) << 8u | texel.x >> TRIANGLE_BITS;
  is_ours = key_of(texel.y) == deferred.draw.x;
  uint shares = texelFetch(shares_map, pixel, 0).x;
  // A pixel of one surface is shaded at its centre, one of several at the samples.
  vec2 offset_px = shares == 0u ? vec2(0.0) : vec2(sample_at(ivec2(0), layer)) * 0.5 - 0.25;
  Attributes a = seen_attributes(is_ours ? triangle_of(texel) : 0u, ndc + offset_px * deferred.scalars.yz);
  Surface s = read_surface(a);
  float share = pixel_share(pixel, shares);
  vec4 radiance = surface_radiance(a, s);
#if FEATURE_TRANSMISSION && FEATURE_ALPHA_BLEND && !FEATURE_SURFACE_VALUE
  radiance = covering(s, radiance);
#endif
#if FEATURE_NEAREST
  share = 1.0;
#endif
  out_color = radiance * share;
}
