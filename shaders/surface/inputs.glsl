// Textures, material and interpolated attributes -> Surface.
#include "interface/frame_block.glsl"
#include "interface/material_block.glsl"
#include "lib/brdf.glsl"

layout(std140, binding = 0) uniform FrameUniform { FrameBlock frame; };
layout(std140, binding = 2) uniform MaterialUniform { MaterialBlock material; };

layout(binding = 0) uniform sampler2D base_color_map;
layout(binding = 1) uniform sampler2D metallic_roughness_map;
layout(binding = 2) uniform sampler2D normal_map;
layout(binding = 3) uniform sampler2D occlusion_map;
layout(binding = 4) uniform sampler2D emissive_map;

layout(location = 0) in vec3 position_world;
layout(location = 1) in vec3 normal_world;
layout(location = 2) in vec4 tangent_world;
layout(location = 3) in vec4 uv01;
layout(location = 4) in vec4 vertex_color;

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

const uint SLOT_BASE_COLOR = 0u;
const uint SLOT_METALLIC_ROUGHNESS = 1u;
const uint SLOT_NORMAL = 2u;
const uint SLOT_OCCLUSION = 3u;
const uint SLOT_EMISSIVE = 4u;

vec2 slot_uv(uint slot) {
  vec3 uv = vec3((material.uv_sets >> slot & 1u) == 0u ? uv01.xy : uv01.zw, 1.0);
  return vec2(dot(material.uv_rows[2u * slot].xyz, uv), dot(material.uv_rows[2u * slot + 1u].xyz, uv));
}

vec3 to_viewer_world() {
  return frame.eye_world.w > 0.5 ? normalize(frame.eye_world.xyz - position_world) : frame.towards_viewer_world.xyz;
}

vec3 shading_normal() {
  vec3 n = normalize(normal_world);
#if FEATURE_NORMAL_MAP
  // MikkTSpace: the interpolated frame is used as it is, not re-orthogonalised (Mikkelsen 2008).
  vec3 t = tangent_world.xyz;
  vec3 b = tangent_world.w * cross(normal_world, t);
  vec3 m = texture(normal_map, slot_uv(SLOT_NORMAL)).xyz * 2.0 - 1.0;
  m = vec3(m.xy * material.normal_scale, m.z);
  vec3 mapped = m.x * t + m.y * b + m.z * normal_world;
  float length2 = dot(mapped, mapped);
  n = length2 > 1e-12 ? mapped * inversesqrt(length2) : n;
#endif
  return material.double_sided != 0u && !gl_FrontFacing ? -n : n;
}

Surface read_surface() {
  Surface s;
  s.base_color = material.base_color * vertex_color;
  s.emissive = material.emissive.rgb;
  s.metallic = material.metallic;
  s.occlusion = 1.0;
  float roughness = material.perceptual_roughness;
#if FEATURE_MATERIAL_MAPS
  s.base_color *= texture(base_color_map, slot_uv(SLOT_BASE_COLOR));
  vec3 packed_map = texture(metallic_roughness_map, slot_uv(SLOT_METALLIC_ROUGHNESS)).rgb;
  roughness *= packed_map.g;
  s.metallic *= packed_map.b;
#if FEATURE_PACKED_OCCLUSION
  float visible = packed_map.r;
#else
  float visible = texture(occlusion_map, slot_uv(SLOT_OCCLUSION)).r;
#endif
  s.occlusion += material.occlusion_strength * (visible - 1.0);
#endif
#if FEATURE_EMISSIVE_MAP
  s.emissive *= texture(emissive_map, slot_uv(SLOT_EMISSIVE)).rgb;
#endif
  s.normal = shading_normal();
  s.to_viewer = to_viewer_world();
  s.NoV = clamp(dot(s.normal, s.to_viewer), MIN_COSINE, 1.0);
  s.alpha = antialiased_alpha(dFdx(s.normal), dFdy(s.normal), roughness * roughness, frame.pixel_footprint);
  return s;
}
