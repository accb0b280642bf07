// Direct light of discs far away: the suns of an environment.
#include "surface/environment_light.glsl"

// Karis 2013, "Real Shading in Unreal Engine 4": of the disc's points the one nearest to the mirror direction stands for all.
vec3 representative_direction(vec3 towards, float radius_rad, vec3 mirror) {
  float cosine = dot(towards, mirror);
  float edge = cos(radius_rad);
  if (cosine >= edge) return mirror;
  vec3 across = mirror - cosine * towards;
  float length2 = dot(across, across);
  return length2 > 0.0 ? edge * towards + sin(radius_rad) * inversesqrt(length2) * across : towards;
}

// By how much that point shines too bright for all: as a half vector sees it the disc has a radius of
//   rho = radius / (2 sqrt(VoH)),
// within which D is D(0), and beyond which it falls off as it would from the centre. For small angles u, where
// D(u) = a^2 / (pi (u^2 + a^2)^2), the integral of that over the plane is 1 + (pi / 2) (rho / a) + (rho / a)^2.
// A mirror then shows irradiance / (pi radius^2), the radiance of the disc.
float disc_gain(float alpha, float radius_rad, float VoH) {
  float q = 0.5 * radius_rad * inversesqrt(max(VoH, MIN_COSINE)) / alpha;
  return 1.0 + q * (0.5 * PI + q);
}

vec3 directional_light(vec4 towards, vec3 irradiance, vec3 f0, vec3 diffuse_albedo, vec2 dfg, float alpha, vec3 normal,
                       vec3 to_viewer, float NoV) {
  vec3 mirror = reflect(-to_viewer, normal);
  vec3 l = representative_direction(towards.xyz, towards.w, mirror);
  vec3 h = normalize(l + to_viewer);
  float NoL = dot(normal, l);
  float VoH = clamp(dot(to_viewer, h), 0.0, 1.0);
  vec3 specular = vec3(0.0);
  if (NoL > 0.0) {
    // A perfect mirror's lobe has no width of its own.
    float a = max(alpha, 1e-4);
    float D = D_GGX(clamp(dot(normal, h), 0.0, 1.0), a) / disc_gain(a, towards.w, VoH);
    float e = dfg.x + dfg.y;
    vec3 compensation = 1.0 + f0 * ((1.0 - e) / max(e, MIN_COSINE));  // as specular_albedo()
    specular = D * V_SmithGGXCorrelated(NoV, NoL, a) * NoL * F_Schlick(VoH, f0) * compensation;
  }
  float cosine = max(dot(normal, towards.xyz), 0.0);
  return irradiance * (diffuse_albedo * (INV_PI * cosine) + specular);
}

vec3 directional_lights(vec3 base_color, float metallic, float alpha, vec3 normal, vec3 to_viewer, float NoV) {
  vec2 dfg = textureLod(dfg_map, vec2(NoV, sqrt(alpha)), 0.0).xy;
  vec3 f0 = mix(vec3(0.04), base_color, metallic);
  vec3 diffuse_albedo = reflectance(base_color, metallic, dfg).diffuse;
  vec3 sum = vec3(0.0);
  for (uint i = 0u; i < frame.light_count; ++i) {
    sum += directional_light(frame.lights[2u * i], frame.lights[2u * i + 1u].xyz, f0, diffuse_albedo, dfg, alpha, normal,
                             to_viewer, NoV);
  }
  return sum;
}
