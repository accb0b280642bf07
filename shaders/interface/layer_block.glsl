// The numbers of a material's layers, for shaders that have some. Rows as in frame_block.glsl.
struct LayerBlock {
  vec4 specular;              // rgb: F0 that the index of refraction gives, times the specular colour; w: factor
  vec4 clearcoat;             // factor, perceptual roughness, normal scale, unused
  vec4 sheen;                 // rgb: colour; w: perceptual roughness
  vec4 anisotropy;            // strength; cosine and sine of the rotation from the tangent; unused
  vec4 iridescence;           // factor, index of refraction, thickness where its texture is 0 and where it is 1 (nm)
  vec4 transmission;          // factor, index of refraction, thickness (m, of the mesh), dispersion
  vec4 absorption;            // rgb: of the volume, 1/m; w unused
  vec4 diffuse_transmission;  // rgb: colour; w: factor
  vec4 glossy;                // rgb: F0 of a specular-glossiness material; w: glossiness
  uint uv_sets;               // bit i: the i-th texture of a layer reads UV set 1
  uint is_phong;              // of the two older models: 1 Phong, 0 Blinn-Phong
  uint pad_0;
  uint pad_1;
  vec4 uv_rows[28];           // as MaterialBlock::uv_rows, in the order of TextureUse from kSpecular on
};
