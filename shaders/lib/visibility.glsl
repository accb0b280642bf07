// Burns and Hunt 2013, "The Visibility Buffer: A Cache-Friendly Approach to Deferred Shading". A texel of the visibility
// frame, which has 2x2 samples a pixel:
//   x: patch << 24 | triangle: its number in the mesh
//   y: 0 where nothing is seen, else key << 14 | normal
// `key`: the draw's (draw_block.glsl). A patch is a part of a mesh whose triangles share vertices, so that its attributes are
// continuous; its number stands in every vertex. The normal is octahedral, seven bits each way, in the frame of the model.
#include "lib/sphere.glsl"

const uint NORMAL_BITS = 14u;
const uint TRIANGLE_BITS = 24u;
const uint SAMPLE_COUNT = 4u;

uvec2 visibility_texel(uint triangle, uint patch_number, uint key, vec3 normal) {
  uvec2 steps = uvec2(octahedral_from_direction(normal) * 127.0 + 0.5);
  return uvec2(patch_number << TRIANGLE_BITS | triangle, key << NORMAL_BITS | steps.y << 7u | steps.x);
}

uint triangle_of(uvec2 texel) { return texel.x & (1u << TRIANGLE_BITS) - 1u; }
uint key_of(uint y) { return y >> NORMAL_BITS; }

// Whether two texels of one pixel may share a shading: one patch of one draw, normals less than about ten degrees apart.
bool is_one_surface(uvec2 a, uvec2 b) {
  const int most = 8;  // steps of 1/64 in the octahedron; its folds only part what could be shared
  ivec2 normal_a = ivec2(a.y & 127u, a.y >> 7u & 127u), normal_b = ivec2(b.y & 127u, b.y >> 7u & 127u);
  ivec2 apart = abs(normal_a - normal_b);
  return (a.x ^ b.x) >> TRIANGLE_BITS == 0u && key_of(a.y ^ b.y) == 0u && apart.x + apart.y <= most;
}

ivec2 sample_at(ivec2 pixel, uint index) { return 2 * pixel + ivec2(index & 1u, index >> 1u); }

// A depth that is exact for every key, so that "equal" selects one draw.
float depth_of_key(uint key) { return float(key) * (1.0 / 262144.0); }

// Which sample's shading each sample of a pixel takes: three bits a sample, 4: nothing is seen there.
const uint NO_SAMPLE = 4u;

uint shaded_by(uint shares, uint index) { return shares >> 3u * index & 7u; }
