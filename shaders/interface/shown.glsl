// What surfaces show in place of their radiance, for film layers. Read as GLSL and as C++ (renderer/residency/gpu_blocks.hpp).
// With FEATURE_SURFACE_VALUE:
const uint SHOWN_POSITION = 0u;   // m, world
const uint SHOWN_UV = 1u;         // set 0
const uint SHOWN_NUMBERS = 2u;    // of the draw (DrawBlock::key) and of the triangle in its mesh
const uint SHOWN_NORMAL = 3u;     // world
const uint SHOWN_ALBEDO = 4u;     // base colour
const uint SHOWN_FACTORS = 5u;    // perceptual roughness, metallic, occlusion
const uint SHOWN_WIREFRAME = 6u;  // cover of a line a pixel wide along the triangle's edges
// With FEATURE_LIGHT_TERM:
const uint SHOWN_IRRADIANCE = 7u;    // of the environment
const uint SHOWN_PREFILTERED = 8u;   // radiance of the environment within the specular lobe
const uint SHOWN_DISTRIBUTION = 9u;  // D, 1/sr
const uint SHOWN_FRESNEL = 10u;      // F
const uint SHOWN_GEOMETRY = 11u;     // G, masking and shadowing
