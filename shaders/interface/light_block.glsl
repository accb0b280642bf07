// Lights beside the environment. Rows as in frame_block.glsl.
const uint MOST_LIGHTS = 36u;         // of a request or a model, and the suns
const uint MOST_SHADOW_VIEWS = 48u;   // a directional or spot light has one, a light within the scene six
const uint FIRST_PROFILE = 2u;        // layer of the lobes' tables, whose first two hold the DFG and the LTC
const uint DISC_CORNERS = 20u;        // of the polygon, as large as the disc, that stands for it
const uint FREE_ROW = 12u;            // of the corners: before it stand those of a unit disc, then of a square from -1 to 1
const uint CORNER_ROWS = 396u;        // two corners each; 12 rows for every light of a request

// What LightRow::place.w is.
const float LIGHT_FAR = 0.0f;        // directional
const float LIGHT_PLACE = 1.0f;      // point or spot
const float LIGHT_RECTANGLE = 2.0f;  // these three are surfaces
const float LIGHT_DISC = 3.0f;
const float LIGHT_BALL = 4.0f;

struct LightRow {
  vec4 place;      // xyz: where it is (m); of a directional light the unit vector to it; w: one of the above
  vec4 intensity;  // rgb: candela, lux of a directional light, nits of a surface; w: 1 / range^2, 0 for no range; of a
                   // surface into how many parts it was cut
  vec4 axis;       // xyz: unit, where it looks; w: radius (m; of a rectangle that of a disc as large), of a directional light angular radius (rad)
  vec4 cone;       // xy: scale and offset of a spot's falloff, (0, 1) for no cone; of a surface the first row of corners and
                   // how many of them its part has; zw: half its width and height (m), or its radius twice
  vec4 across;     // xyz: unit, its x axis, corners' or profile's; w: layer of its profile in the tables, 0 for none; of a surface
                   // 1 if it is two-sided
  vec4 shadow;     // x: first view, -1 for none; y: radius of the penumbra in the map for a unit of depth; z: metres of a
                   // texel, at a distance of 1 m unless directional; w: views
  vec4 eye;        // xyz: where its views look from, m; w: radius of a disc as large as a part, m; 0 for the whole
};

struct LightBlock {
  uint count;
  float shadow_texel;   // 1 / side of the shadow maps
  float tile_x;         // px: of the tile in the picture
  float tile_y;
  LightRow lights[36];
  mat4 shadow_from_world[48];   // clip space of each view; depth is reversed
  vec4 corners[396];            // xy and zw: a corner each, counter-clockwise, in half widths and heights, or radii
};
