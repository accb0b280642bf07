// What is shown of a surface in place of its radiance, for a film layer.
#include "interface/shown.glsl"

#if FEATURE_LIGHT_PART
layout(location = 1) uniform vec4 environment_share;  // of what the environment brings: diffuse, specular, sheen, clearcoat
layout(location = 2) uniform vec4 light_share;        // the same of lights
layout(location = 3) uniform vec3 other_share;        // of what is seen through, emitted, and of unlit colours
#endif
#if FEATURE_SURFACE_VALUE || FEATURE_LIGHT_TERM
layout(location = 4) uniform uint shown;  // numbers of interface/shown.glsl
#endif
