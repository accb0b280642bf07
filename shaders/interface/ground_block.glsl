// The light that one pass of the ground's shadow takes together: of what is far, or of one lamp. Rows as in frame_block.glsl.
const uint GROUND_LIGHTS = 128u;    // bits of one RGBA32UI texel
const float GROUND_FADE = 0.06f;    // of the shadow's map, at each side: where it fades out

struct GroundBlock {
  vec4 clip_from_ground;   // clip.xy = (x, z) * clip_from_ground.xy + clip_from_ground.zw, world metres
  vec4 rectangle;          // of the map on the ground: least x and z, size in x and z, m
  vec4 far_light;          // rgb: irradiance of the ground by all that is far, without the scene
  float level;             // world y, m
  uint light_count;        // at most GROUND_LIGHTS; of a lamp 0 where nothing hides it
  uint lamp;               // row of LightBlock
  uint pad_0;
  vec4 light[128];         // xy: metres that a shadow moves in x and z for each metre of height; z: 1 / height over the ground (m) of
                           // a lamp's place, 0 of what is far; w: opacity above which it is cast
  vec4 weight[128];        // xyz: of what is far, share of all far light that falls on the ground, by colour
  vec4 shift[128];         // xy: in clip space
};
