// One draw. Rows as in frame_block.glsl.
struct DrawBlock {
  mat4 world_from_model;
  mat4 world_from_model_normal;  // inverse transpose of the upper 3x3 up to a positive factor
  float handedness;              // sign of the determinant of world_from_model
  uint key;                      // of its visibility texels: its place among the frame's draws + 1, below 2^18
  uint vertex_rows;              // vec4 a vertex in the mesh's buffer: 4, or 5 with colours
  uint pad_0;
};
