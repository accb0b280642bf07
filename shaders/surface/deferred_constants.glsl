// More of constants.glsl, for draws that are shaded from the visibility frame.
struct DeferredConstants {
  vec4 clip_x_from_model, clip_y_from_model, clip_w_from_model;  // rows
  mat3 world_from_model_normal;
  mat3 world_from_model;
  vec4 origin;       // xyz: of the model in the world, m
  vec4 scalars;      // handedness; ndc a pixel to the right, downwards; metres of the world for one of the model
  uvec2 draw;        // key, vec4 rows a vertex
};
