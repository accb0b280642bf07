// What one sub-frame's shaders need to know. Read as GLSL (std140) and as C++ (renderer/residency/gpu_blocks.hpp): every
// 16-byte row is a vec4, a uvec4 or four scalars.
struct FrameBlock {
  mat4 clip_from_world;         // of the tile, with this sub-frame's jitter
  mat4 world_from_ray;          // (ndc.x, ndc.y, 1, 0) -> direction of the background ray, not normalised; ndc of the tile
  mat4 environment_from_world;  // undoes the environment's rotation
  vec4 eye_world;               // xyz: m; w: 1 perspective, 0 orthographic
  vec4 towards_viewer_world;    // xyz: unit, used when orthographic
  vec4 level_tiles[32];         // x, y of the first inner texel, inner side (px), level_coordinate(); rising
  vec4 irradiance_tile;         // x, y, inner side (px), unused
  float atlas_texel_u;          // 1 / atlas width (px)
  float atlas_texel_v;          // 1 / atlas height (px)
  float atlas_gain;             // radiance per stored unit, intensity included
  float sky_gain;               // the same for the environment's own texture
  uint level_count;             // tiles in use
  float sky_lod;                // mip level of the environment's own texture whose texels are as large as pixels
  float pixel_footprint;        // 1 / sqrt(sub-frames)
  float point_size_samples;
  float ndc_per_pixel_x;        // to the right
  float ndc_per_pixel_y;        // downwards: negative
  float depth_tolerance;        // relative difference of depth within one surface and pixel
  float exposure;               // multiplier
};
