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
// FEATURE_LAYER_MAPS         textures of layers are read
// FEATURE_SPECULAR           the dielectric's reflection is not that of index of refraction 1.5 (KHR_materials_ior, _specular)
// FEATURE_GLOSSY             F0 and glossiness are given (KHR_materials_pbrSpecularGlossiness)
// FEATURE_ANISOTROPY         the lobe is wider along the tangent (KHR_materials_anisotropy)
// FEATURE_IRIDESCENCE        a thin film colours the reflection (KHR_materials_iridescence)
// FEATURE_CLEARCOAT          a coat lies over the rest (KHR_materials_clearcoat)
// FEATURE_COAT_NORMAL_MAP    with a normal texture of its own
// FEATURE_SHEEN              fibres stand on the surface (KHR_materials_sheen)
// FEATURE_DIFFUSE_TRANSMISSION  light from behind is scattered through (KHR_materials_diffuse_transmission)
// FEATURE_TRANSMISSION       what stands behind is seen through the surface (KHR_materials_transmission, _volume, _dispersion)
// FEATURE_SCHLICK_BECKMANN   masking by Schlick's approximation, without compensation
// FEATURE_PHONG              the models of Phong and of Blinn
// FEATURE_VEIL               blended surfaces, lines or points stand before the frame
// FEATURE_SKY                the environment stands behind the frame
// FEATURE_MAGNIFIED          its texels are larger than pixels: they are interpolated smoothly
// FEATURE_GROUND_PROJECTION  its lower half lies flat, as a floor
// FEATURE_GROUND_SHADOW      a ground under the scene shows its shadow
// FEATURE_GRADE              white balance, contrast and saturation, and the tone curves of many operations
// FEATURE_BLOOM              a glow spreads from what is bright
// FEATURE_EMISSION           surfaces show nothing but what they emit; only that glows
// FEATURE_SURFACE_LIGHTS     some lights are surfaces: rectangles, discs, balls
// FEATURE_LIGHT_PROFILES     some lights have photometric profiles
// FEATURE_SURFACE_VALUE      surfaces show one of their own numbers, whatever lights them: a film layer
// FEATURE_LIGHT_PART         surfaces show some parts of their light alone
// FEATURE_LIGHT_TERM         surfaces show one term of their light's formula
// FEATURE_NEAREST            of a pixel the nearest surface stands for all
// FEATURE_ENVIRONMENT_VISIBILITY  the scene keeps the environment's light from itself
// FEATURE_DITHER             what is stored is rounded by a pattern of the picture
