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
  kFeatureVeil = 1u << 11,
  kFeatureSky = 1u << 12,
  kFeatureMagnified = 1u << 13,
  kFeatureGroundProjection = 1u << 14,
  kFeatureGroundShadow = 1u << 15,
  kFeatureGrade = 1u << 16,
  kFeatureSkyVisibility = 1u << 17,
};

}  // namespace furnace::gl
