// Interpolated attributes, textures and material -> Surface.
#include "lib/brdf.glsl"
#include "lib/thin_film.glsl"
#include "surface/constants.glsl"
#include "surface/material.glsl"
#include "surface/needs.glsl"

// A point of a surface as its vertices describe it; forward.frag and deferred.frag have it from different places.
struct Attributes {
  vec3 to_viewer_world;     // not normalised
  vec3 position_world;      // with NEEDS_POSITION only
  vec3 normal_world;        // not normalised
  vec4 tangent_world;
  vec4 uv01;                // both UV sets
  vec4 uv01_dx, uv01_dy;    // a pixel further right, down
  vec4 color;
  float normal_change2;     // of the unit interpolated normal: see antialiased_alpha()
  bool front;
  float lod;                // aligned_lod() of the rest
#if FEATURE_TRANSMISSION
  float world_from_model_scale;
  float curvature2;         // of the interpolated normal over the world, 1/m^2
#endif
};

// What a shader that includes this gives, beside `SurfaceConstants constants`: of a quad of pixels the software rasteriser takes one for all.
float quad_lod(float lod);
// Squared differences to the neighbouring pixels, summed; 0 for those that see something else.
float quad_change2(vec3 value);

struct Surface {
  vec4 base_color;
  vec3 emissive;
  float metallic;
  float alpha;       // GGX, widened for the pixel
  float occlusion;
  vec3 normal;       // unit, world, towards the viewer's side
  vec3 vertex_normal;  // the same without a map
  vec3 to_viewer;    // unit, world
  vec3 position;     // m, world; with NEEDS_POSITION only
  float NoV;
  vec3 f0, f90;      // reflectance of the dielectric, seen at right angles and grazing
  vec3 metal_f0;
#if FEATURE_ANISOTROPY
  vec3 tangent;      // unit, at right angles to the normal
  float alpha_t;     // along it; `alpha` is across
#endif
#if FEATURE_CLEARCOAT
  float clearcoat, clearcoat_alpha, clearcoat_NoV;
  vec3 clearcoat_normal;
#endif
#if FEATURE_SHEEN
  vec3 sheen_color;
  float sheen_roughness;  // perceptual
#endif
#if FEATURE_TRANSMISSION
  float transmission;
  float thickness_m;  // of the volume behind, world
  float transmitted_roughness;  // perceptual, of the lobe behind
  float roundness;    // 0: the volume is a pane, 1: a ball
#endif
#if FEATURE_DIFFUSE_TRANSMISSION
  float diffuse_transmission;
  vec3 diffuse_transmission_color;
#endif
};

float level_of_detail(vec2 dx, vec2 dy) {
  return quad_lod(0.5 * log2(max(max(dot(dx, dx), dot(dy, dy)), 1e-12)));
}

#if FEATURE_ALIGNED_MAPS
float aligned_lod(Attributes a) {
  vec2 size = constants.pixel.yz;
  return level_of_detail(a.uv01_dx.xy * size, a.uv01_dy.xy * size);
}

vec4 sample_slot(sampler2D map, uint slot, Attributes a) { return textureLod(map, a.uv01.xy, a.lod); }
#else
float aligned_lod(Attributes a) { return 0.0; }

vec4 sample_slot(sampler2D map, uint slot, Attributes a) {
  vec2 size = vec2(textureSize(map, 0));
  vec2 dx = slot_coordinates(slot, a.uv01_dx, 0.0) * size;
  vec2 dy = slot_coordinates(slot, a.uv01_dy, 0.0) * size;
  return textureLod(map, slot_uv(slot, a.uv01), level_of_detail(dx, dy));
}
#endif

#if NEEDS_TANGENT
// MikkTSpace: the interpolated frame is used as it is, not re-orthogonalised (Mikkelsen 2008).
vec3 bitangent_of(Attributes a) { return a.tangent_world.w * cross(a.normal_world, a.tangent_world.xyz); }

vec3 mapped_normal(Attributes a, vec3 m) {
  return m.x * a.tangent_world.xyz + m.y * bitangent_of(a) + m.z * a.normal_world;
}
#endif

// change2: see antialiased_alpha(); of the vertices' normals and, beyond them, of the map's.
vec3 shading_normal(Attributes a, vec3 vertex_normal, float flip, out float change2) {
  change2 = a.normal_change2;
#if FEATURE_NORMAL_MAP
  vec3 m = sample_slot(normal_map, SLOT_NORMAL, a).xyz * 2.0 - 1.0;
  m = vec3(m.xy * constants.factors.z, m.z);
  change2 += quad_change2(m);
  vec3 mapped = mapped_normal(a, m);
  float length2 = dot(mapped, mapped);
  if (length2 > 1e-12) return flip * mapped * inversesqrt(length2);
#endif
  return vertex_normal;
}

#include "surface/layers.glsl"

Surface read_surface(Attributes a) {
  a.lod = aligned_lod(a);
  Surface s;
  s.base_color = constants.base_color * a.color;
  s.emissive = constants.emissive_flip.rgb;
  s.metallic = constants.factors.x;
  s.occlusion = 1.0;
  s.f0 = vec3(0.04);  // glTF 2.0, appendix B: index of refraction 1.5
  s.f90 = vec3(1.0);
  float roughness = constants.factors.y;
#if FEATURE_GLOSSY
  s.f0 = layers.glossy.rgb;
  float glossiness = layers.glossy.w;
#endif
#if FEATURE_MATERIAL_MAPS
  s.base_color *= sample_slot(base_color_map, SLOT_BASE_COLOR, a);
  vec4 packed_map = sample_slot(metallic_roughness_map, SLOT_METALLIC_ROUGHNESS, a);
#if FEATURE_GLOSSY
  s.f0 *= packed_map.rgb;
  glossiness *= packed_map.a;
#else
  roughness *= packed_map.g;
  s.metallic *= packed_map.b;
#endif
#if FEATURE_PACKED_OCCLUSION
  float visible = packed_map.r;
#else
  float visible = sample_slot(occlusion_map, SLOT_OCCLUSION, a).r;
#endif
  s.occlusion += constants.factors.w * (visible - 1.0);
#endif
#if FEATURE_GLOSSY
  roughness = 1.0 - glossiness;
  s.metallic = 0.0;
#endif
#if FEATURE_EMISSIVE_MAP
  s.emissive *= sample_slot(emissive_map, SLOT_EMISSIVE, a).rgb;
#endif
  float flip = constants.emissive_flip.w > 0.5 && !a.front ? -1.0 : 1.0;
  vec3 vertex_normal = flip * normalize(a.normal_world);
  float change2;
  s.vertex_normal = vertex_normal;
  s.normal = shading_normal(a, vertex_normal, flip, change2);
  s.to_viewer = normalize(a.to_viewer_world);
  s.position = a.position_world;
  s.NoV = clamp(dot(s.normal, s.to_viewer), MIN_COSINE, 1.0);
  s.alpha = antialiased_alpha(change2, roughness * roughness, constants.pixel.x);
  s.metal_f0 = s.base_color.rgb;
#if FEATURE_SPECULAR
  read_specular(a, s);
#endif
#if FEATURE_ANISOTROPY
  read_anisotropy(a, a.tangent_world.xyz, bitangent_of(a), s);
#endif
#if FEATURE_IRIDESCENCE
  read_iridescence(a, s);
#endif
#if FEATURE_CLEARCOAT
  read_clearcoat(a, vertex_normal, flip, a.normal_change2, s);
#endif
#if FEATURE_SHEEN
  read_sheen(a, s);
#endif
#if FEATURE_TRANSMISSION
  read_transmission(a, roughness, s);
#endif
#if FEATURE_DIFFUSE_TRANSMISSION
  read_diffuse_transmission(a, s);
#endif
  return s;
}
