// One draw. Rows as in frame_block.glsl.
struct DrawBlock {
  mat4 world_from_model;
  mat4 world_from_model_normal;  // inverse transpose of the upper 3x3 up to a positive factor
  float handedness;              // sign of the determinant of world_from_model
  float pad_0;
  float pad_1;
  float pad_2;
};
