// A material's numbers; its textures are bound beside it. Rows as in frame_block.glsl.
struct MaterialBlock {
  vec4 base_color;              // linear, with alpha
  vec4 emissive;                // xyz: linear radiance, strength included; w unused
  float metallic;
  float perceptual_roughness;
  float normal_scale;
  float occlusion_strength;
  float alpha_cutoff;
  uint double_sided;            // 0 or 1
  uint uv_sets;                 // bit i: texture slot i reads UV set 1
  float map_width;              // px of every texture, where all are of one size and read at UV set 0, untransformed; else 0
  float map_height;
  float shadow_opacity;         // [0, 1], times alpha: what the surface keeps of light that meets it
  uint pad_0;
  uint pad_1;
  vec4 uv_rows[10];             // two rows a slot (base colour, metallic-roughness, normal, occlusion, emissive):
                                // uv' = (dot(row0.xyz, (uv, 1)), dot(row1.xyz, (uv, 1)))
};
