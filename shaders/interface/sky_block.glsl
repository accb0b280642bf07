// The environment's light as directions, those of one sub-frame, each with a map of what it sees. Rows as in frame_block.glsl.
const uint MOST_SKY_VIEWS = 32u;
const int SKY_SUMS_PX = 64;   // side of each map of renderer/ibl/light_sums.hpp
const int SKY_LOBES = 8;      // such maps of specular lobes

struct SkyView {
  vec4 towards;     // xyz: unit, to the light; w: m, by which a surface is lifted off what it casts into the map itself
  vec4 light;       // rgb: irradiance of a plane facing it, w: solid angle (sr); both over the sub-frame's share of all directions
  vec4 map_u;       // rows that take (world position, 1) to u, v and reversed depth of the map
  vec4 map_v;
  vec4 map_depth;
};

struct SkyBlock {
  uint count;
  float least_alpha;    // of a specular lobe: a narrower one falls between the directions
  float map_px;         // side of the maps
  uint first_layer;     // of the shadow maps
  vec4 even;            // rgb: radiance that every direction of all sub-frames has at least
  SkyView views[32];
};
