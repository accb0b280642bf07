// The part of the environment's light that the scene keeps from itself: of directions that stand for the environment, those that
// see something else of the scene. Each sub-frame looks along some; what they find hidden is taken as a share of what all of all
// sub-frames shed on the lobe, a number that is known before, so that the mean over the sub-frames has no bias: it is the share
// that all directions together find. Where nothing is hidden the prefiltered light stays as it is.
#include "interface/sky_block.glsl"

layout(std140, binding = 6) uniform SkyUniform { SkyBlock sky; };
layout(binding = 13) uniform sampler2D sky_sums;  // of all directions: renderer/ibl/light_sums.hpp
layout(binding = 15) uniform sampler2DArray shadow_depths;

// 1 where something hides the direction from the surface, else 0.
float hidden_from(uint i, vec3 position, vec3 normal) {
  SkyView view = sky.views[i];
  vec3 l = view.towards.xyz;
  // Off the surface by some texels, more where the light grazes it, so that it does not shadow itself.
  float cosine = clamp(dot(normal, l), -1.0, 1.0);
  vec3 lit_side = cosine < 0.0 ? -normal : normal;
  vec4 lifted = vec4(position + (lit_side * sqrt(1.0 - cosine * cosine) + 0.5 * l) * view.towards.w, 1.0);
  // One texel: the maps of all directions lie differently over the surface, so that their mean has no steps.
  vec2 uv = vec2(dot(view.map_u, lifted), dot(view.map_v, lifted));
  float depth = texelFetch(shadow_depths, ivec3(ivec2(uv * sky.map_px), sky.first_layer + i), 0).r;
  return depth > dot(view.map_depth, lifted) ? 1.0 : 0.0;
}

// As in renderer/ibl/light_sums.hpp.
float ggx_lobe(float cosine, float alpha) {
  float a2 = alpha * alpha;
  float d = 0.5 * (1.0 - cosine) + a2 * 0.5 * (1.0 + cosine);
  return max(cosine, 0.0) * a2 * a2 / (d * d);
}

// Of map `index`, around unit `direction` (world).
vec4 sum_around(vec3 direction, int index) {
  vec2 texel = octahedral_from_direction(direction) * float(SKY_SUMS_PX - 1) + 0.5 + vec2(0.0, index * SKY_SUMS_PX);
  return textureLod(sky_sums, texel / vec2(SKY_SUMS_PX, SKY_SUMS_PX * (1 + SKY_LOBES)), 0.0);
}

// A specular lobe of the environment's light. Its light is taken for that of two round ones: of a rough lobe some part lies so far
// off its middle that a round one has nothing there, and bright light counts there. That part, `broad`, is taken for a cosine about
// the normal, and the rest leans less.
struct SkyLobe {
  vec3 direction, normal, to_viewer;  // unit, world; of the rest
  float NoV, broad;
  float alpha;  // no narrower than the directions lie apart
  float norm;   // of ggx_lobe() over the sphere
  vec4 sums;    // of all directions on the rest, over its norm: light and solid angle
};

// Fitted to the shares of the true lobe that lie beyond planes through the surface; from alpha 0.25 on their error is half of a round
// lobe's.
float broad_share(float NoV, float alpha) {
  float m = 1.0 - NoV;
  float x = (2.0 + 4.0 * m * m * m) * alpha * alpha;
  return x / (1.0 + x);
}

SkyLobe sky_lobe(vec3 normal, vec3 to_viewer, float NoV, float alpha) {
  SkyLobe lobe;
  float lean = dfg_at(NoV, sqrt(alpha)).z * (0.75 - 0.4 * NoV + 0.4 * alpha * alpha);
  lobe.direction = lobe_direction(normal, to_viewer, NoV, lean);
  lobe.normal = normal;
  // A normal that points away from the viewer sees him at its horizon.
  lobe.to_viewer = normalize(to_viewer + (NoV - dot(normal, to_viewer)) * normal);
  lobe.NoV = NoV;
  lobe.broad = broad_share(NoV, alpha);
  // At 1 its norm would be a difference of equals.
  lobe.alpha = clamp(alpha, sky.least_alpha, 0.95);
  float a2 = lobe.alpha * lobe.alpha, p = 0.5 + 0.5 * a2, q = 0.5 - 0.5 * a2;
  lobe.norm = TWO_PI * a2 * a2 / (q * q) * (p / a2 - 1.0 + log(a2 / p));
  float at = (1.0 - log(lobe.alpha) / log(sky.least_alpha)) * float(SKY_LOBES - 1);
  int low = clamp(int(at), 0, SKY_LOBES - 2);
  lobe.sums = mix(sum_around(lobe.direction, 1 + low), sum_around(lobe.direction, 2 + low), at - float(low));
  return lobe;
}

// What one sub-frame's directions shed on such a lobe.
struct LobeSums {
  vec4 round_hidden, cosine_hidden;  // on the rest and on the broad part, what is hidden: light and solid angle
  vec3 seen, seen_grazing;           // on the true lobe of the material, what is not: light beyond the even, for F = 1 and F = (1 - v.h)^5
};

void shed_on(SkyLobe lobe, uint i, float hidden, inout LobeSums sums) {
  vec3 l = sky.views[i].towards.xyz;
  vec4 light = sky.views[i].light;
  float NoL = dot(lobe.normal, l);
  if (NoL <= 0.0) return;
  vec4 lost = light * hidden;
  sums.round_hidden += lost * ggx_lobe(dot(lobe.direction, l), lobe.alpha);
  sums.cosine_hidden += lost * NoL;
  float LoV = dot(lobe.to_viewer, l), a2 = lobe.alpha * lobe.alpha;
  float NoH2 = (NoL + lobe.NoV) * (NoL + lobe.NoV) / max(2.0 + 2.0 * LoV, 1e-6);
  float shed = D_GGX(sqrt(min(NoH2, 1.0)), lobe.alpha) * V_SmithGGXCorrelated(lobe.NoV, NoL, lobe.alpha) * NoL;
  float m = 1.0 - sqrt(max(0.5 + 0.5 * LoV, 0.0)), m2 = m * m;
  vec3 seen = (light.rgb - sky.even.rgb * light.a) * (shed * (1.0 - hidden));
  sums.seen += seen;
  sums.seen_grazing += seen * (m2 * m2 * m);
}

// Share of the rest that is hidden. Its part below the horizon is left out: in the plane, a lobe 1 / (1 + (u / s)^2)^2 has
// (1 + x / sqrt(x^2 + s^2)) / 2 beyond a line at a distance x. Here s is 2 alpha, x the elevation. The root of it is taken: half-way to
// all of the lobe, which no hidden light could exceed where it all lies above the horizon.
float above_horizon(SkyLobe lobe) {
  float elevation = asin(clamp(dot(lobe.direction, lobe.normal), -1.0, 1.0));
  return sqrt(0.5 + 0.5 * elevation * inversesqrt(elevation * elevation + 4.0 * lobe.alpha * lobe.alpha));
}
float round_hidden(SkyLobe lobe, LobeSums sums) {
  return luminance(sums.round_hidden.rgb) / max(luminance(lobe.sums.rgb) * lobe.norm * above_horizon(lobe), 1e-9);
}

vec3 share_of(vec3 hidden, vec3 direction) { return hidden / max(sum_around(direction, 0).rgb, vec3(1e-9)); }

// Radiance within a lobe of a width `alpha` in the mean over the sub-frames, `f0` and `f90` at all its microfacets.
vec3 seen_radiance(SkyLobe lobe, LobeSums sums, float alpha, vec3 f0, vec3 f90) {
  vec3 rest = prefiltered_radiance(constants.environment_from_world * lobe.direction, sqrt(alpha));
  vec3 broad = diffuse_radiance(constants.environment_from_world * lobe.normal);
  vec4 cosine_sums = sum_around(lobe.normal, 0);
  vec3 as_round = mix(rest * (1.0 - round_hidden(lobe, sums)),
                      broad * (1.0 - sums.cosine_hidden.rgb / max(cosine_sums.rgb, vec3(1e-9))), lobe.broad);

  vec2 dfg = dfg_at(lobe.NoV, sqrt(lobe.alpha)).xy;
  vec3 seen = (f0 * (sums.seen - sums.seen_grazing) + f90 * sums.seen_grazing) / max(f0 * dfg.x + f90 * dfg.y, vec3(1e-6));
  vec4 all = mix(lobe.sums, cosine_sums * INV_PI, lobe.broad);
  float even_hidden = mix(sums.round_hidden.a / (lobe.norm * above_horizon(lobe)), sums.cosine_hidden.a * INV_PI, lobe.broad) / all.a;
  seen += sky.even.rgb * (1.0 - even_hidden);
  vec3 known = all.rgb + sky.even.rgb * (1.0 - all.a);
  // Where few directions stand for what lies in a narrow lobe the ratio runs wild; the more there are, the nearer it is to 1.
  vec3 as_sampled = seen * clamp(mix(rest, broad, lobe.broad) / max(known, vec3(1e-9)), 0.5, 2.0);
  // Single directions would show in a narrow lobe, and in the narrow peak that any has where the viewer grazes the surface.
  float many = smoothstep(0.4, 0.9, alpha / sky.least_alpha) * smoothstep(0.0, 0.1, lobe.NoV);
  return mix(as_round, as_sampled, many);
}

// What of each lobe of environment_light() is hidden, in the mean over the sub-frames.
struct HiddenShares {
  vec3 diffuse;
  SkyLobe specular_lobe;
  LobeSums specular;
#if FEATURE_DIFFUSE_TRANSMISSION
  vec3 scattered;
#endif
#if FEATURE_SHEEN
  vec3 sheen;
#endif
#if FEATURE_CLEARCOAT
  SkyLobe clearcoat_lobe;
  LobeSums clearcoat;
#endif
};

const LobeSums NOTHING_SHED = LobeSums(vec4(0.0), vec4(0.0), vec3(0.0), vec3(0.0));

HiddenShares hidden_shares(Surface s) {
  HiddenShares h;
#if FEATURE_ANISOTROPY
  h.specular_lobe = sky_lobe(s.normal, s.to_viewer, s.NoV, sqrt(s.alpha * s.alpha_t));
#else
  h.specular_lobe = sky_lobe(s.normal, s.to_viewer, s.NoV, s.alpha);
#endif
  h.specular = NOTHING_SHED;
#if FEATURE_DIFFUSE_TRANSMISSION
  h.scattered = vec3(0.0);
#endif
#if FEATURE_SHEEN
  h.sheen = vec3(0.0);
  vec3 sheen = sheen_direction(s);
#endif
#if FEATURE_CLEARCOAT
  h.clearcoat_lobe = sky_lobe(s.clearcoat_normal, s.to_viewer, s.clearcoat_NoV, s.clearcoat_alpha);
  h.clearcoat = NOTHING_SHED;
#endif
  for (uint i = 0u; i < sky.count; ++i) {
    float hidden = hidden_from(i, s.position, s.vertex_normal);
    shed_on(h.specular_lobe, i, hidden, h.specular);
#if FEATURE_DIFFUSE_TRANSMISSION || FEATURE_SHEEN
    vec3 l = sky.views[i].towards.xyz;
    vec3 lost = sky.views[i].light.rgb * hidden;
    float NoL = dot(s.normal, l);
#endif
#if FEATURE_DIFFUSE_TRANSMISSION
    h.scattered += lost * max(-NoL, 0.0);
#endif
#if FEATURE_SHEEN
    h.sheen += NoL > 0.0 ? lost * max(dot(sheen, l), 0.0) : vec3(0.0);
#endif
#if FEATURE_CLEARCOAT
    shed_on(h.clearcoat_lobe, i, hidden, h.clearcoat);
#endif
  }
  h.diffuse = share_of(h.specular.cosine_hidden.rgb, s.normal);
#if FEATURE_DIFFUSE_TRANSMISSION
  h.scattered = share_of(h.scattered, -s.normal);
#endif
#if FEATURE_SHEEN
  h.sheen = share_of(h.sheen, sheen);
#endif
  return h;
}
