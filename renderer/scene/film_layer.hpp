// What a picture can be taken apart into (elsewhere: arbitrary output variables, AOVs): one row a film layer.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace furnace {

enum class FilmLayer {
  kDepth,
  kPosition,
  kUv,
  kObjectId,
  kMaterialId,
  kPrimitiveId,
  kMotion,
  kNormal,
  kViewNormal,
  kAlbedo,
  kRoughness,
  kMetallic,
  kOcclusion,
  kCoverage,
  kWireframe,
  kDiffuseEnvironment,
  kSpecularEnvironment,
  kSheenEnvironment,
  kClearcoatEnvironment,
  kDiffuseLights,
  kSpecularLights,
  kSheenLights,
  kClearcoatLights,
  kTransmission,
  kEmission,
  kUnlit,
  kBackground,
  kGlow,
  kIrradiance,
  kPrefilteredRadiance,
  kDistribution,
  kFresnel,
  kGeometry,
  kCryptoObject,
  kCryptoMaterial,
};

enum class FilmLayerKind {
  kPlace,  // of the surface that is nearest in a pixel, never mixed with another's
  kValue,  // a number of the surface: the mean over the pixel, premultiplied by what surfaces cover of it
  kPart,   // of the light, exposed, the same mean: all parts sum to the picture before its grade
  kTerm,   // of the light's formula, the same mean
  kMatte,  // Cryptomatte: who covers how much of the pixel
};

struct FilmLayerRow {
  std::string_view name;  // in "output"."layers"
  FilmLayer layer;
  FilmLayerKind kind;
  std::string_view channels;  // a letter each, as compositors call them; of a matte, those of a pair of ranks
  bool exposed = false;       // a radiance: times the camera's exposure
};

// In the order of FilmLayer.
inline constexpr std::array kFilmLayers = {
    FilmLayerRow{"depth", FilmLayer::kDepth, FilmLayerKind::kPlace, "Z"},
    FilmLayerRow{"position", FilmLayer::kPosition, FilmLayerKind::kPlace, "XYZ"},
    FilmLayerRow{"uv", FilmLayer::kUv, FilmLayerKind::kPlace, "UV"},
    FilmLayerRow{"objectId", FilmLayer::kObjectId, FilmLayerKind::kPlace, "Y"},
    FilmLayerRow{"materialId", FilmLayer::kMaterialId, FilmLayerKind::kPlace, "Y"},
    FilmLayerRow{"primitiveId", FilmLayer::kPrimitiveId, FilmLayerKind::kPlace, "Y"},
    FilmLayerRow{"motion", FilmLayer::kMotion, FilmLayerKind::kPlace, "XY"},
    FilmLayerRow{"normal", FilmLayer::kNormal, FilmLayerKind::kValue, "XYZ"},
    FilmLayerRow{"viewNormal", FilmLayer::kViewNormal, FilmLayerKind::kValue, "XYZ"},
    FilmLayerRow{"albedo", FilmLayer::kAlbedo, FilmLayerKind::kValue, "RGB"},
    FilmLayerRow{"roughness", FilmLayer::kRoughness, FilmLayerKind::kValue, "Y"},
    FilmLayerRow{"metallic", FilmLayer::kMetallic, FilmLayerKind::kValue, "Y"},
    FilmLayerRow{"occlusion", FilmLayer::kOcclusion, FilmLayerKind::kValue, "Y"},
    FilmLayerRow{"coverage", FilmLayer::kCoverage, FilmLayerKind::kValue, "Y"},
    FilmLayerRow{"wireframe", FilmLayer::kWireframe, FilmLayerKind::kValue, "Y"},
    FilmLayerRow{"diffuseEnvironment", FilmLayer::kDiffuseEnvironment, FilmLayerKind::kPart, "RGB", true},
    FilmLayerRow{"specularEnvironment", FilmLayer::kSpecularEnvironment, FilmLayerKind::kPart, "RGB", true},
    FilmLayerRow{"sheenEnvironment", FilmLayer::kSheenEnvironment, FilmLayerKind::kPart, "RGB", true},
    FilmLayerRow{"clearcoatEnvironment", FilmLayer::kClearcoatEnvironment, FilmLayerKind::kPart, "RGB", true},
    FilmLayerRow{"diffuseLights", FilmLayer::kDiffuseLights, FilmLayerKind::kPart, "RGB", true},
    FilmLayerRow{"specularLights", FilmLayer::kSpecularLights, FilmLayerKind::kPart, "RGB", true},
    FilmLayerRow{"sheenLights", FilmLayer::kSheenLights, FilmLayerKind::kPart, "RGB", true},
    FilmLayerRow{"clearcoatLights", FilmLayer::kClearcoatLights, FilmLayerKind::kPart, "RGB", true},
    FilmLayerRow{"transmission", FilmLayer::kTransmission, FilmLayerKind::kPart, "RGB", true},
    FilmLayerRow{"emission", FilmLayer::kEmission, FilmLayerKind::kPart, "RGB", true},
    FilmLayerRow{"unlit", FilmLayer::kUnlit, FilmLayerKind::kPart, "RGB", true},
    FilmLayerRow{"background", FilmLayer::kBackground, FilmLayerKind::kPart, "RGB", true},
    FilmLayerRow{"glow", FilmLayer::kGlow, FilmLayerKind::kPart, "RGB", true},
    FilmLayerRow{"irradiance", FilmLayer::kIrradiance, FilmLayerKind::kTerm, "RGB", true},
    FilmLayerRow{"prefilteredRadiance", FilmLayer::kPrefilteredRadiance, FilmLayerKind::kTerm, "RGB", true},
    FilmLayerRow{"distribution", FilmLayer::kDistribution, FilmLayerKind::kTerm, "Y"},
    FilmLayerRow{"fresnel", FilmLayer::kFresnel, FilmLayerKind::kTerm, "RGB"},
    FilmLayerRow{"geometry", FilmLayer::kGeometry, FilmLayerKind::kTerm, "Y"},
    FilmLayerRow{"cryptoObject", FilmLayer::kCryptoObject, FilmLayerKind::kMatte, "RGBA"},
    FilmLayerRow{"cryptoMaterial", FilmLayer::kCryptoMaterial, FilmLayerKind::kMatte, "RGBA"},
};

constexpr const FilmLayerRow& row_of(FilmLayer layer) {
  return kFilmLayers[static_cast<std::size_t>(layer)];
}

constexpr bool rows_are_in_order() {
  for (std::size_t i = 0; i < kFilmLayers.size(); ++i)
    if (kFilmLayers[i].layer != static_cast<FilmLayer>(i)) return false;
  return kFilmLayers.size() == static_cast<std::size_t>(FilmLayer::kCryptoMaterial) + 1;
}
static_assert(rows_are_in_order());

// Friedman and Jones 2015, "Fully automatic ID mattes with support for motion blur and transparency": ranks of two channels
// each, two of them in a level. Three levels are what compositors expect.
inline constexpr int kMatteLevels = 3;

// Bytes that one pixel of the layer takes while it is drawn.
constexpr std::int64_t bytes_per_px(FilmLayer layer) {
  const FilmLayerRow& row = row_of(layer);
  const std::int64_t samples = std::int64_t(row.channels.size());
  return std::int64_t{sizeof(float)} * samples * (row.kind == FilmLayerKind::kMatte ? kMatteLevels : 1);
}

}  // namespace furnace
