// What one sub-frame's shaders need to know. Read as GLSL (std140) and as C++ (renderer/residency/gpu_blocks.hpp): every
// 16-byte row is a vec4, a uvec4 or four scalars.
const uint BACKDROP_LIGHT = 0u;        // behind the scene is seen the environment that lights it
const uint BACKDROP_MAP = 1u;          // another map
const uint BACKDROP_COLOR = 2u;        // background_top to background_bottom
const uint BACKDROP_TRANSPARENT = 3u;  // nothing

struct FrameBlock {
  mat4 clip_from_world;         // of the tile, with this sub-frame's jitter
  mat4 world_from_ray;          // (ndc.x, ndc.y, 1, 0) -> direction of the background ray, not normalised; ndc of the tile
  mat4 environment_from_world;  // undoes the environment's rotation
  mat4 background_from_world;   // undoes that of the background
  mat4 origin_from_ndc;         // (ndc.x, ndc.y, 1, 0) -> where the background ray begins (m), from the middle of the dome
  mat4 ground_from_ndc;         // (ndc.x, ndc.y, 1, 0) -> (u, v) of the ground's shadow times z; z <= 0 where there is no ground
  mat4 backdrop_from_world;     // world -> (x, y) of the whole picture, [0, 1], y down; without jitter
  vec4 background_top;          // radiance, where it is a colour, at the edges of the whole picture
  vec4 background_bottom;
  vec4 eye_world;               // xyz: m; w: 1 perspective, 0 orthographic
  vec4 towards_viewer_world;    // xyz: unit, used when orthographic
  vec4 level_tiles[32];         // x, y of the first inner texel, inner side (px), level_coordinate(); rising
  vec4 irradiance_tile;         // x, y, inner side (px), unused
  float atlas_texel_u;          // 1 / atlas width (px)
  float atlas_texel_v;          // 1 / atlas height (px)
  float atlas_gain;             // radiance per stored unit, intensity included
  float sky_gain;               // the same for the environment's own texture
  uint level_count;             // tiles in use
  float background_lod;         // mip level of the background's texture whose texels are as large as pixels
  float pixel_footprint;        // 1 / sqrt(sub-frames)
  float point_size_samples;
  float ndc_per_pixel_x;        // to the right
  float ndc_per_pixel_y;        // downwards: negative
  float depth_tolerance;        // relative difference of depth within one surface and pixel
  float exposure;               // multiplier
  float background_gain;        // radiance per stored unit of the background's texture
  float shadow_strength;        // of the ground, [0, 1]
  float dome_radius;            // m: of the ground projection
  float dome_height;            // m, of its middle above the ground
  uint backdrop_kind;           // one of the above
  float background_share;       // radiance of the background for each of the environment, where they are one map
  uint pad_0;
  uint pad_1;
};
