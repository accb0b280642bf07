// Every shader feature, one a line: its bit is its place in this list, its value in a shader is 0 or 1.
// A feature is a define only if leaving it out removes a lobe, a class of texture fetches or as much arithmetic at every pixel.
// The shader library refuses any other name; renderer/gl/feature_set.hpp names the same bits for C++.
//
// FEATURE_ALPHA_MASK         alpha is cut at a threshold, its edge becomes coverage
// FEATURE_ALPHA_BLEND        colour is premultiplied by alpha
// FEATURE_UNLIT              base colour is the radiance (KHR_materials_unlit, points and lines without normals)
// FEATURE_NORMAL_MAP         tangent frames and the normal texture are read
// FEATURE_MATERIAL_MAPS      base colour, metallic-roughness and occlusion textures are read
// FEATURE_PACKED_OCCLUSION   occlusion is the red channel of the metallic-roughness texture: one fetch for both
// FEATURE_EMISSIVE_MAP       the emissive texture is read
// FEATURE_ALIGNED_MAPS       every texture is of one size and read at UV set 0, untransformed: one level of detail for all
// FEATURE_VERTEX_COLOR       vertices have colours
// FEATURE_SHARP_REFLECTION   roughness may fall below the first baked level: the environment itself is read too
// FEATURE_LIGHTS             lights shine beside the environment
// FEATURE_VEIL               blended surfaces, lines or points stand before the frame
// FEATURE_SKY                the environment stands behind the frame
// FEATURE_MAGNIFIED          its texels are larger than pixels: they are interpolated smoothly
// FEATURE_GROUND_PROJECTION  its lower half lies flat, as a floor
// FEATURE_GROUND_SHADOW      a ground under the scene shows its shadow
// FEATURE_GRADE              white balance, contrast and saturation, and the tone curves of many operations
// FEATURE_SKY_VISIBILITY     the scene keeps the environment's light from itself
