// A material's numbers and textures.
#include "interface/material_block.glsl"

layout(std140, binding = 2) uniform MaterialUniform { MaterialBlock material; };

layout(binding = 0) uniform sampler2D base_color_map;
layout(binding = 1) uniform sampler2D metallic_roughness_map;
layout(binding = 2) uniform sampler2D normal_map;
layout(binding = 3) uniform sampler2D occlusion_map;
layout(binding = 4) uniform sampler2D emissive_map;

const uint SLOT_BASE_COLOR = 0u;
const uint SLOT_METALLIC_ROUGHNESS = 1u;
const uint SLOT_NORMAL = 2u;
const uint SLOT_OCCLUSION = 3u;
const uint SLOT_EMISSIVE = 4u;

// `uv01`: both UV sets, or a derivative of them with `one` = 0.
vec2 slot_coordinates(uint slot, vec4 uv01, float one) {
  vec3 uv = vec3((material.uv_sets >> slot & 1u) == 0u ? uv01.xy : uv01.zw, one);
  return vec2(dot(material.uv_rows[2u * slot].xyz, uv), dot(material.uv_rows[2u * slot + 1u].xyz, uv));
}

vec2 slot_uv(uint slot, vec4 uv01) { return slot_coordinates(slot, uv01, 1.0); }
