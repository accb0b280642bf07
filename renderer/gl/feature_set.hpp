// The exact variant key of a shader: one bit a feature of shaders/interface/features.glsl, in that order.
#pragma once

#include <cstdint>

namespace furnace::gl {

using FeatureSet = std::uint64_t;

enum Feature : FeatureSet {
  kFeatureAlphaMask = 1ull << 0,
  kFeatureAlphaBlend = 1ull << 1,
  kFeatureUnlit = 1ull << 2,
  kFeatureNormalMap = 1ull << 3,
  kFeatureMaterialMaps = 1ull << 4,
  kFeaturePackedOcclusion = 1ull << 5,
  kFeatureEmissiveMap = 1ull << 6,
  kFeatureAlignedMaps = 1ull << 7,
  kFeatureVertexColor = 1ull << 8,
  kFeatureSharpReflection = 1ull << 9,
  kFeatureLights = 1ull << 10,
  kFeatureLayerMaps = 1ull << 11,
  kFeatureSpecular = 1ull << 12,
  kFeatureGlossy = 1ull << 13,
  kFeatureAnisotropy = 1ull << 14,
  kFeatureIridescence = 1ull << 15,
  kFeatureClearcoat = 1ull << 16,
  kFeatureCoatNormalMap = 1ull << 17,
  kFeatureSheen = 1ull << 18,
  kFeatureDiffuseTransmission = 1ull << 19,
  kFeatureTransmission = 1ull << 20,
  kFeatureSchlickBeckmann = 1ull << 21,
  kFeaturePhong = 1ull << 22,
  kFeatureVeil = 1ull << 23,
  kFeatureSky = 1ull << 24,
  kFeatureMagnified = 1ull << 25,
  kFeatureGroundProjection = 1ull << 26,
  kFeatureGroundShadow = 1ull << 27,
  kFeatureGrade = 1ull << 28,
  kFeatureBloom = 1ull << 29,
  kFeatureEmission = 1ull << 30,
  kFeatureSurfaceLights = 1ull << 31,
  kFeatureLightProfiles = 1ull << 32,
  kFeatureSurfaceValue = 1ull << 33,
  kFeatureLightPart = 1ull << 34,
  kFeatureLightTerm = 1ull << 35,
  kFeatureNearest = 1ull << 36,
  kFeatureEnvironmentVisibility = 1ull << 37,
  kFeatureDither = 1ull << 38,
};

}  // namespace furnace::gl
