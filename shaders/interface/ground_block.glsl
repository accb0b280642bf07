// The light that one pass of the ground's shadow takes together. Rows as in frame_block.glsl.
const uint GROUND_LIGHTS = 128u;    // bits of one RGBA32UI texel
const float GROUND_FADE = 0.06f;    // of the shadow's map, at each side: where it fades out

struct GroundBlock {
  vec4 clip_from_ground;   // clip.xy = (x, z) * clip_from_ground.xy + clip_from_ground.zw, world metres
  float level;             // world y, m
  uint light_count;        // at most GROUND_LIGHTS
  uint pad_0;
  uint pad_1;
  vec4 light[128];         // xy: metres that a shadow moves in x and z for each metre of height; z: opacity above which it is cast; w: shift in clip space, x
  vec4 weight[128];        // xyz: share of all the light that falls on the ground, by colour; w: shift in clip space, y
};
