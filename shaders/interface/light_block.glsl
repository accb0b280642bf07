// Lights beside the environment. Rows as in frame_block.glsl.
const uint MOST_LIGHTS = 36u;         // of a request or a model, and the suns
const uint MOST_SHADOW_VIEWS = 48u;   // a directional or spot light has one, a point light six

struct LightRow {
  vec4 place;      // xyz: where it is (m), w 1; of a directional light the unit vector to it, w 0
  vec4 intensity;  // rgb: candela, or lux of a directional light; w: 1 / range^2, 0 for no range
  vec4 axis;       // xyz: unit, where a spot looks; w: radius (m), of a directional light angular radius (rad)
  vec4 cone;       // xy: scale and offset of a spot's falloff, (0, 1) for no cone; zw unused
  vec4 shadow;     // x: first view, -1 for none; y: radius of the penumbra in the map for a unit of depth; z: metres of a
                   // texel, at a distance of 1 m unless directional; w: views
  vec4 eye;        // xyz: where its views look from, m; w unused
};

struct LightBlock {
  uint count;
  float shadow_texel;   // 1 / side of the shadow maps
  float tile_x;         // px: of the tile in the picture
  float tile_y;
  LightRow lights[36];
  mat4 shadow_from_world[48];   // clip space of each view; depth is reversed
};
