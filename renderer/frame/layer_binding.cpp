#include "renderer/frame/layer_binding.hpp"

#include "renderer/base/check.hpp"

namespace furnace {
namespace {

// Of all features those that change a surface's own numbers.
constexpr gl::FeatureSet kValueFeatures = gl::kFeatureAlphaMask | gl::kFeatureAlphaBlend | gl::kFeatureUnlit |
                                          gl::kFeatureNormalMap | gl::kFeatureMaterialMaps |
                                          gl::kFeaturePackedOcclusion | gl::kFeatureAlignedMaps |
                                          gl::kFeatureVertexColor | gl::kFeatureGlossy;
// Lobes that no term tells of.
constexpr gl::FeatureSet kOtherLobes = gl::kFeatureTransmission | gl::kFeatureDiffuseTransmission |
                                       gl::kFeatureClearcoat | gl::kFeatureCoatNormalMap | gl::kFeatureSheen;

// As surface/film_layer.glsl has them.
struct Shares {
  glm::vec4 environment{0}, lights{0};  // diffuse, specular, sheen, clearcoat
  glm::vec3 other{0};                   // seen through, emitted, unlit
};

// The background has none of what surfaces send.
Shares shares_of(FilmLayer part) {
  const auto from_environment = [&](FilmLayer first) { return part >= first && int(part) < int(first) + 4; };
  Shares shares;
  if (from_environment(FilmLayer::kDiffuseEnvironment))
    shares.environment[int(part) - int(FilmLayer::kDiffuseEnvironment)] = 1;
  if (from_environment(FilmLayer::kDiffuseLights))
    shares.lights[int(part) - int(FilmLayer::kDiffuseLights)] = 1;
  if (part == FilmLayer::kTransmission) shares.other.x = 1;
  if (part == FilmLayer::kEmission) shares.other.y = 1;
  if (part == FilmLayer::kUnlit) shares.other.z = 1;
  return shares;
}

GLuint shown_number(FilmLayer source) {
  switch (source) {
    case FilmLayer::kPosition:
      return gpu::SHOWN_POSITION;
    case FilmLayer::kUv:
      return gpu::SHOWN_UV;
    case FilmLayer::kPrimitiveId:
      return gpu::SHOWN_NUMBERS;
    case FilmLayer::kNormal:
      return gpu::SHOWN_NORMAL;
    case FilmLayer::kAlbedo:
      return gpu::SHOWN_ALBEDO;
    case FilmLayer::kRoughness:
      return gpu::SHOWN_FACTORS;
    case FilmLayer::kWireframe:
      return gpu::SHOWN_WIREFRAME;
    case FilmLayer::kIrradiance:
      return gpu::SHOWN_IRRADIANCE;
    case FilmLayer::kPrefilteredRadiance:
      return gpu::SHOWN_PREFILTERED;
    case FilmLayer::kDistribution:
      return gpu::SHOWN_DISTRIBUTION;
    case FilmLayer::kFresnel:
      return gpu::SHOWN_FRESNEL;
    case FilmLayer::kGeometry:
      return gpu::SHOWN_GEOMETRY;
    default:
      FURNACE_CHECK(false, "{} is not drawn by surfaces", row_of(source).name);
      return 0;
  }
}

}  // namespace

gl::FeatureSet shown_features(const PassContext& pass, gl::FeatureSet features) {
  if (pass.emission) return features | gl::kFeatureEmission;
  const bool is_lit = (features & gl::kFeatureUnlit) == 0;
  const gl::FeatureSet hidden =
      pass.sky_sums != nullptr && is_lit ? gl::FeatureSet(gl::kFeatureEnvironmentVisibility) : 0;
  if (!pass.shown) return features | hidden;
  switch (row_of(*pass.shown).kind) {
    case FilmLayerKind::kPlace:
      return (features & kValueFeatures) | gl::kFeatureSurfaceValue | gl::kFeatureNearest;
    case FilmLayerKind::kValue:
      return (features & kValueFeatures) | gl::kFeatureSurfaceValue;
    case FilmLayerKind::kTerm:
      return (features & ~kOtherLobes) | gl::kFeatureLightTerm;
    default:
      return features | hidden | gl::kFeatureLightPart;
  }
}

void set_shown(const PassContext& pass, GLuint program) {
  if (!pass.shown) return;
  if (row_of(*pass.shown).kind == FilmLayerKind::kPart) {
    constexpr GLint kEnvironmentLocation = 1, kLightLocation = 2, kOtherLocation = 3;
    const Shares shares = shares_of(*pass.shown);
    glProgramUniform4fv(program, kEnvironmentLocation, 1, &shares.environment.x);
    glProgramUniform4fv(program, kLightLocation, 1, &shares.lights.x);
    glProgramUniform3fv(program, kOtherLocation, 1, &shares.other.x);
  } else {
    constexpr GLint kShownLocation = 4;
    glProgramUniform1ui(program, kShownLocation, shown_number(*pass.shown));
  }
}

}  // namespace furnace
