// Burns and Hunt 2013, "The Visibility Buffer: A Cache-Friendly Approach to Deferred Shading". A texel of the visibility
// frame, which has 2x2 samples a pixel: x: the triangle's number in its mesh; y: 0 where nothing is seen, else
// key << PATCH_BITS | patch. A patch is a part of a mesh whose triangles share vertices, so that its attributes are
// continuous (renderer/scene/mesh_patches.hpp).
const uint PATCH_BITS = 12u;
const uint SAMPLE_COUNT = 4u;

uvec2 visibility_texel(uint triangle, uint key, uint patch_number) {
  return uvec2(triangle, key << PATCH_BITS | patch_number & (1u << PATCH_BITS) - 1u);
}

uint key_of(uint surface) { return surface >> PATCH_BITS; }

ivec2 sample_at(ivec2 pixel, uint index) { return 2 * pixel + ivec2(index & 1u, index >> 1u); }

// A depth that is exact for every key, so that "equal" selects one draw.
float depth_of_key(uint key) { return float(key) * (1.0 / 1048576.0); }

// Which sample's shading each sample of a pixel takes: three bits a sample, 4: nothing is seen there.
const uint NO_SAMPLE = 4u;

uint shaded_by(uint shares, uint index) { return shares >> 3u * index & 7u; }
