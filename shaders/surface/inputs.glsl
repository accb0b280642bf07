// Interpolated attributes, textures and material -> Surface.
#include "interface/frame_block.glsl"
#include "lib/brdf.glsl"
#include "surface/material.glsl"

layout(std140, binding = 0) uniform FrameUniform { FrameBlock frame; };

// A point of a surface as its vertices describe it; forward.frag and deferred.frag have it from different places.
struct Attributes {
  vec3 position_world;
  vec3 normal_world;        // not normalised
  vec4 tangent_world;
  vec4 uv01;                // both UV sets
  vec4 uv01_dx, uv01_dy;    // a pixel further right, down
  vec4 color;
  bool front;
};

// What a shader that includes this gives: of a quad of pixels the software rasteriser takes one for all.
float quad_lod(float lod);
// Differences of `normal` to the neighbouring pixels; 0 where they see something else.
void normal_derivatives(vec3 normal, out vec3 dx, out vec3 dy);

struct Surface {
  vec4 base_color;
  vec3 emissive;
  float metallic;
  float alpha;       // GGX, widened for the pixel
  float occlusion;
  vec3 normal;       // unit, world, towards the viewer's side
  vec3 to_viewer;    // unit, world
  float NoV;
};

vec4 sample_slot(sampler2D map, uint slot, Attributes a) {
  vec2 size = vec2(textureSize(map, 0));
  vec2 dx = slot_coordinates(slot, a.uv01_dx, 0.0) * size;
  vec2 dy = slot_coordinates(slot, a.uv01_dy, 0.0) * size;
  float lod = 0.5 * log2(max(max(dot(dx, dx), dot(dy, dy)), 1e-12));
  return textureLod(map, slot_uv(slot, a.uv01), quad_lod(lod));
}

vec3 to_viewer_world(vec3 position_world) {
  return frame.eye_world.w > 0.5 ? normalize(frame.eye_world.xyz - position_world) : frame.towards_viewer_world.xyz;
}

vec3 shading_normal(Attributes a) {
  vec3 n = normalize(a.normal_world);
#if FEATURE_NORMAL_MAP
  // MikkTSpace: the interpolated frame is used as it is, not re-orthogonalised (Mikkelsen 2008).
  vec3 t = a.tangent_world.xyz;
  vec3 b = a.tangent_world.w * cross(a.normal_world, t);
  vec3 m = sample_slot(normal_map, SLOT_NORMAL, a).xyz * 2.0 - 1.0;
  m = vec3(m.xy * material.normal_scale, m.z);
  vec3 mapped = m.x * t + m.y * b + m.z * a.normal_world;
  float length2 = dot(mapped, mapped);
  n = length2 > 1e-12 ? mapped * inversesqrt(length2) : n;
#endif
  return material.double_sided != 0u && !a.front ? -n : n;
}

Surface read_surface(Attributes a) {
  Surface s;
  s.base_color = material.base_color * a.color;
  s.emissive = material.emissive.rgb;
  s.metallic = material.metallic;
  s.occlusion = 1.0;
  float roughness = material.perceptual_roughness;
#if FEATURE_MATERIAL_MAPS
  s.base_color *= sample_slot(base_color_map, SLOT_BASE_COLOR, a);
  vec3 packed_map = sample_slot(metallic_roughness_map, SLOT_METALLIC_ROUGHNESS, a).rgb;
  roughness *= packed_map.g;
  s.metallic *= packed_map.b;
#if FEATURE_PACKED_OCCLUSION
  float visible = packed_map.r;
#else
  float visible = sample_slot(occlusion_map, SLOT_OCCLUSION, a).r;
#endif
  s.occlusion += material.occlusion_strength * (visible - 1.0);
#endif
#if FEATURE_EMISSIVE_MAP
  s.emissive *= sample_slot(emissive_map, SLOT_EMISSIVE, a).rgb;
#endif
  s.normal = shading_normal(a);
  s.to_viewer = to_viewer_world(a.position_world);
  s.NoV = clamp(dot(s.normal, s.to_viewer), MIN_COSINE, 1.0);
  vec3 dndx, dndy;
  normal_derivatives(s.normal, dndx, dndy);
  s.alpha = antialiased_alpha(dndx, dndy, roughness * roughness, frame.pixel_footprint);
  return s;
}
