// The numbers and textures of a material's layers. What a shader does not read, the compiler leaves out.
#include "interface/layer_block.glsl"

layout(std140, binding = 5) uniform LayerUniform { LayerBlock layers; };

#if FEATURE_LAYER_MAPS
// Units from 16 on, in the order of LayerBlock::uv_rows.
layout(binding = 16) uniform sampler2D specular_map;
layout(binding = 17) uniform sampler2D specular_color_map;
layout(binding = 18) uniform sampler2D clearcoat_map;
layout(binding = 19) uniform sampler2D clearcoat_roughness_map;
layout(binding = 20) uniform sampler2D clearcoat_normal_map;
layout(binding = 21) uniform sampler2D sheen_color_map;
layout(binding = 22) uniform sampler2D sheen_roughness_map;
layout(binding = 23) uniform sampler2D anisotropy_map;
layout(binding = 24) uniform sampler2D iridescence_map;
layout(binding = 25) uniform sampler2D iridescence_thickness_map;
layout(binding = 26) uniform sampler2D transmission_map;
layout(binding = 27) uniform sampler2D thickness_map;
layout(binding = 28) uniform sampler2D diffuse_transmission_map;
layout(binding = 29) uniform sampler2D diffuse_transmission_color_map;

vec4 sample_layer(sampler2D map, uint index, Attributes a) {
#if FEATURE_ALIGNED_MAPS
  return textureLod(map, a.uv01.xy, a.lod);
#else
  bool second = (layers.uv_sets >> index & 1u) != 0u;
  vec3 row_u = layers.uv_rows[2u * index].xyz, row_v = layers.uv_rows[2u * index + 1u].xyz;
  vec2 uv = second ? a.uv01.zw : a.uv01.xy;
  vec2 dx = second ? a.uv01_dx.zw : a.uv01_dx.xy, dy = second ? a.uv01_dy.zw : a.uv01_dy.xy;
  vec2 size = vec2(textureSize(map, 0));
  float lod = level_of_detail(vec2(dot(row_u.xy, dx), dot(row_v.xy, dx)) * size,
                              vec2(dot(row_u.xy, dy), dot(row_v.xy, dy)) * size);
  return textureLod(map, vec2(dot(row_u, vec3(uv, 1.0)), dot(row_v, vec3(uv, 1.0))), lod);
#endif
}
#define LAYER_MAP(map, index) sample_layer(map, index, a)
#else
#define LAYER_MAP(map, index) vec4(1.0)
#endif

#if FEATURE_SPECULAR
// KHR_materials_specular, KHR_materials_ior.
void read_specular(Attributes a, inout Surface s) {
  float factor = layers.specular.w * LAYER_MAP(specular_map, 0u).a;
  s.f0 = min(layers.specular.rgb * LAYER_MAP(specular_color_map, 1u).rgb, vec3(1.0)) * factor;
  s.f90 = vec3(factor);
}
#endif

#if FEATURE_ANISOTROPY
// KHR_materials_anisotropy. `tangent` and `bitangent` need not be unit.
void read_anisotropy(Attributes a, vec3 tangent, vec3 bitangent, inout Surface s) {
  vec3 map = LAYER_MAP(anisotropy_map, 7u).rgb;
#if FEATURE_LAYER_MAPS
  vec2 along = map.rg * 2.0 - 1.0;
#else
  vec2 along = vec2(1.0, 0.0);
#endif
  // A texture that is not there reads white, which stands for no direction.
  along = map.rg == vec2(1.0) ? vec2(1.0, 0.0) : along;
  vec2 turn = layers.anisotropy.yz;
  along = vec2(turn.x * along.x - turn.y * along.y, turn.y * along.x + turn.x * along.y);
  vec3 t = along.x * normalize(tangent) + along.y * normalize(bitangent);
  t -= s.normal * dot(t, s.normal);
  float length2 = dot(t, t);
  s.tangent = length2 > 1e-8 ? t * inversesqrt(length2) : normalize(tangent);
  float strength = layers.anisotropy.x * map.b;
  s.alpha_t = mix(s.alpha, 1.0, strength * strength);
}
#endif

#if FEATURE_IRIDESCENCE
// KHR_materials_iridescence: F0 as the film makes it, seen from here.
void read_iridescence(Attributes a, inout Surface s) {
  float factor = layers.iridescence.x * LAYER_MAP(iridescence_map, 8u).r;
  float thickness_nm = mix(layers.iridescence.z, layers.iridescence.w, LAYER_MAP(iridescence_thickness_map, 9u).g);
  if (thickness_nm <= 0.0) factor = 0.0;
  vec3 dielectric = thin_film_reflectance(s.NoV, layers.iridescence.y, thickness_nm, s.f0);
  vec3 metal = thin_film_reflectance(s.NoV, layers.iridescence.y, thickness_nm, s.metal_f0);
  s.f0 = mix(s.f0, f0_of_reflectance(dielectric, s.NoV), factor);
  s.metal_f0 = mix(s.metal_f0, f0_of_reflectance(metal, s.NoV), factor);
}
#endif

#if FEATURE_CLEARCOAT
// KHR_materials_clearcoat. `vertex_normal`: unit, towards the viewer's side; the frame's flip is -1 where it was turned.
void read_clearcoat(Attributes a, vec3 vertex_normal, float flip, float change2, inout Surface s) {
  s.clearcoat = layers.clearcoat.x * LAYER_MAP(clearcoat_map, 2u).r;
  float roughness = layers.clearcoat.y * LAYER_MAP(clearcoat_roughness_map, 3u).g;
  s.clearcoat_normal = vertex_normal;
#if FEATURE_COAT_NORMAL_MAP && FEATURE_LAYER_MAPS
  vec3 m = LAYER_MAP(clearcoat_normal_map, 4u).xyz * 2.0 - 1.0;
  m = vec3(m.xy * layers.clearcoat.z, m.z);
  change2 += quad_change2(m);
  vec3 mapped = mapped_normal(a, m);
  float length2 = dot(mapped, mapped);
  if (length2 > 1e-12) s.clearcoat_normal = flip * mapped * inversesqrt(length2);
#endif
  s.clearcoat_NoV = clamp(dot(s.clearcoat_normal, s.to_viewer), MIN_COSINE, 1.0);
  s.clearcoat_alpha = antialiased_alpha(change2, roughness * roughness, constants.pixel.x);
}
#endif

#if FEATURE_SHEEN
// KHR_materials_sheen. Below the least roughness its lobe is a line that nothing here resolves.
void read_sheen(Attributes a, inout Surface s) {
  s.sheen_color = layers.sheen.rgb * LAYER_MAP(sheen_color_map, 5u).rgb;
  s.sheen_roughness = max(layers.sheen.w * LAYER_MAP(sheen_roughness_map, 6u).a, 0.1);
}
#endif

#if FEATURE_TRANSMISSION
// KHR_materials_transmission, KHR_materials_volume.
void read_transmission(Attributes a, float perceptual_roughness, inout Surface s) {
  s.transmission = layers.transmission.x * LAYER_MAP(transmission_map, 10u).r;
  s.thickness_m = layers.transmission.z * LAYER_MAP(thickness_map, 11u).g * a.world_from_model_scale;
  // A thin wall does not bend rays however its normal turns; and what does not bend light does not scatter it
  // (KHR_materials_volume's renderers).
  s.transmitted_roughness =
      (s.thickness_m > 0.0 ? sqrt(s.alpha) : perceptual_roughness) * clamp(2.0 * layers.transmission.y - 2.0, 0.0, 1.0);
  // Of a sphere as thick as this the curvature is 2 / thickness; a flat pane has none.
  s.roundness = clamp(0.5 * s.thickness_m * sqrt(a.curvature2), 0.0, 1.0);
}
#endif

#if FEATURE_DIFFUSE_TRANSMISSION
// KHR_materials_diffuse_transmission.
void read_diffuse_transmission(Attributes a, inout Surface s) {
  s.diffuse_transmission = layers.diffuse_transmission.w * LAYER_MAP(diffuse_transmission_map, 12u).a;
  s.diffuse_transmission_color =
      layers.diffuse_transmission.rgb * LAYER_MAP(diffuse_transmission_color_map, 13u).rgb;
}
#endif
