#include "interface/frame_block.glsl"
#include "surface/constants.glsl"
#include "surface/material.glsl"

SurfaceConstants surface_constants(FrameBlock frame) {
  return SurfaceConstants(
      material.base_color, vec4(material.emissive.rgb, float(material.double_sided)),
      vec4(material.metallic, material.perceptual_roughness, material.normal_scale, material.occlusion_strength),
      mat3(frame.environment_from_world), vec4(frame.irradiance_tile.xyz, frame.atlas_gain),
      vec4(frame.atlas_texel_u, frame.atlas_texel_v, frame.exposure, frame.sky_gain),
      vec4(frame.pixel_footprint, material.map_width, material.map_height, 0.0));
}
