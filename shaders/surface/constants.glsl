// What is the same for all of a draw, handed from vertex to fragment shader: the software rasteriser reads a uniform block
// again for every pixel, at some thirty cycles a number, but a flat varying once a triangle.
struct SurfaceConstants {
  vec4 base_color;
  vec4 emissive_flip;           // xyz: radiance; w: 1 where back faces are lit as front faces
  vec4 factors;                 // metallic, perceptual roughness, normal scale, occlusion strength
  mat3 environment_from_world;
  vec4 irradiance_tile;         // x, y, inner side (px); w: radiance per unit stored in the atlas
  vec4 atlas;                   // texel width, height; z: exposure, a multiplier; w: radiance per unit stored in the sky
  vec4 pixel;                   // footprint; width and height of the maps, where all are of one size (px)
};
