#include "surface/inputs.glsl"
#include "surface/environment_light.glsl"

layout(location = 0) out vec4 out_color;  // linear radiance, premultiplied by alpha

// Coverage of a cut edge: the alpha function crosses the cutoff within one pixel.
float mask_coverage(float alpha, float cutoff) {
  return clamp((alpha - cutoff) / max(fwidth(alpha), 1e-4) + 0.5, 0.0, 1.0);
}

void main() {
  Surface s = read_surface();
#if FEATURE_UNLIT
  vec3 radiance = s.base_color.rgb;
#else
  vec3 radiance = s.emissive + environment_light(s.base_color.rgb, s.metallic, s.alpha, s.occlusion, s.normal,
                                                 s.to_viewer, s.NoV);
#endif
#if FEATURE_ALPHA_BLEND
  out_color = vec4(radiance * s.base_color.a, s.base_color.a);
#elif FEATURE_ALPHA_MASK
  out_color = vec4(radiance, mask_coverage(s.base_color.a, material.alpha_cutoff));
  if (out_color.a <= 0.0) discard;
#else
  out_color = vec4(radiance, 1.0);
#endif
}
