// The exact variant key of a shader: one bit a feature of shaders/interface/features.glsl, in that order.
#pragma once

#include <cstdint>

namespace furnace::gl {

using FeatureSet = std::uint32_t;

enum Feature : FeatureSet {
  kFeatureAlphaMask = 1u << 0,
  kFeatureAlphaBlend = 1u << 1,
  kFeatureUnlit = 1u << 2,
  kFeatureNormalMap = 1u << 3,
  kFeatureMaterialMaps = 1u << 4,
  kFeaturePackedOcclusion = 1u << 5,
  kFeatureEmissiveMap = 1u << 6,
  kFeatureAlignedMaps = 1u << 7,
  kFeatureVertexColor = 1u << 8,
  kFeatureSharpReflection = 1u << 9,
  kFeatureLights = 1u << 10,
  kFeatureLayerMaps = 1u << 11,
  kFeatureSpecular = 1u << 12,
  kFeatureGlossy = 1u << 13,
  kFeatureAnisotropy = 1u << 14,
  kFeatureIridescence = 1u << 15,
  kFeatureClearcoat = 1u << 16,
  kFeatureCoatNormalMap = 1u << 17,
  kFeatureSheen = 1u << 18,
  kFeatureDiffuseTransmission = 1u << 19,
  kFeatureTransmission = 1u << 20,
  kFeatureSchlickBeckmann = 1u << 21,
  kFeaturePhong = 1u << 22,
  kFeatureVeil = 1u << 23,
  kFeatureSky = 1u << 24,
  kFeatureMagnified = 1u << 25,
  kFeatureGroundProjection = 1u << 26,
  kFeatureGroundShadow = 1u << 27,
  kFeatureGrade = 1u << 28,
  kFeatureBloom = 1u << 29,
  kFeatureEmission = 1u << 30,
};

}  // namespace furnace::gl
