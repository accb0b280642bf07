#include "renderer/scene/material.hpp"

#include <algorithm>
#include <array>

namespace furnace {
namespace {

struct Preset {
  std::string_view name;
  glm::vec3 base_color;  // linear Rec.709
  float metallic;
  float perceptual_roughness;
};

// Normal-incidence reflectance of measured metals, linear Rec.709: Akenine-Moller, Haines, Hoffman 2018,
// "Real-Time Rendering", 4th edition, table 9.2. Gold's red is 1.022 there: outside the gamut, clipped to 1.
constexpr glm::vec3 kGold{1.000f, 0.782f, 0.344f};
constexpr glm::vec3 kSilver{0.972f, 0.960f, 0.915f};
constexpr glm::vec3 kCopper{0.955f, 0.638f, 0.538f};
constexpr glm::vec3 kBrass{0.910f, 0.778f, 0.423f};  // alloy C260
constexpr glm::vec3 kAluminum{0.913f, 0.922f, 0.924f};
constexpr glm::vec3 kChromium{0.549f, 0.556f, 0.554f};
constexpr glm::vec3 kIron{0.562f, 0.565f, 0.578f};
constexpr glm::vec3 kNickel{0.660f, 0.609f, 0.526f};
constexpr glm::vec3 kPlatinum{0.673f, 0.637f, 0.585f};
constexpr glm::vec3 kPalladium{0.733f, 0.697f, 0.652f};
constexpr glm::vec3 kTitanium{0.542f, 0.497f, 0.449f};
constexpr glm::vec3 kZinc{0.664f, 0.824f, 0.850f};

// Metals: how a workshop leaves them. Dielectrics (glTF's F0 of 0.04): diffuse albedos between real extremes,
// 0.02 of black rubber and 0.9 of chalk; colours kept inside the gamut of real pigments so that light of any
// colour stays plausible.
constexpr std::array kPresets = {
    //     name                 base colour           metallic  roughness
    Preset{"gold", kGold, 1, 0.12f},
    Preset{"gold-rough", kGold, 1, 0.55f},
    Preset{"gold-brushed", kGold, 1, 0.32f},
    Preset{"silver", kSilver, 1, 0.08f},
    Preset{"silver-rough", kSilver, 1, 0.50f},
    Preset{"silver-brushed", kSilver, 1, 0.30f},
    Preset{"copper", kCopper, 1, 0.14f},
    Preset{"copper-rough", kCopper, 1, 0.55f},
    Preset{"copper-brushed", kCopper, 1, 0.34f},
    Preset{"brass", kBrass, 1, 0.16f},
    Preset{"brass-rough", kBrass, 1, 0.55f},
    Preset{"brass-brushed", kBrass, 1, 0.34f},
    Preset{"aluminum", kAluminum, 1, 0.22f},
    Preset{"aluminium", kAluminum, 1, 0.22f},
    Preset{"aluminum-rough", kAluminum, 1, 0.58f},
    Preset{"aluminium-rough", kAluminum, 1, 0.58f},
    Preset{"aluminum-brushed", kAluminum, 1, 0.36f},
    Preset{"aluminium-brushed", kAluminum, 1, 0.36f},
    Preset{"chrome", kChromium, 1, 0.03f},
    Preset{"chrome-rough", kChromium, 1, 0.40f},
    Preset{"iron", kIron, 1, 0.42f},
    Preset{"iron-cast", kIron * 0.55f, 1, 0.72f},
    Preset{"steel", kIron, 1, 0.18f},
    Preset{"steel-brushed", kIron, 1, 0.34f},
    Preset{"nickel", kNickel, 1, 0.18f},
    Preset{"platinum", kPlatinum, 1, 0.14f},
    Preset{"palladium", kPalladium, 1, 0.16f},
    Preset{"titanium", kTitanium, 1, 0.28f},
    Preset{"titanium-brushed", kTitanium, 1, 0.42f},
    Preset{"zinc", kZinc, 1, 0.48f},
    Preset{"mirror", {1.000f, 1.000f, 1.000f}, 1, 0},

    Preset{"plastic-white", {0.800f, 0.800f, 0.790f}, 0, 0.30f},
    Preset{"plastic-gray", {0.216f, 0.216f, 0.216f}, 0, 0.32f},
    Preset{"plastic-black", {0.022f, 0.022f, 0.023f}, 0, 0.30f},
    Preset{"plastic-red", {0.590f, 0.028f, 0.022f}, 0, 0.28f},
    Preset{"plastic-orange", {0.780f, 0.195f, 0.020f}, 0, 0.28f},
    Preset{"plastic-yellow", {0.800f, 0.520f, 0.030f}, 0, 0.28f},
    Preset{"plastic-green", {0.045f, 0.330f, 0.090f}, 0, 0.28f},
    Preset{"plastic-teal", {0.020f, 0.270f, 0.290f}, 0, 0.28f},
    Preset{"plastic-blue", {0.024f, 0.120f, 0.520f}, 0, 0.28f},
    Preset{"plastic-purple", {0.190f, 0.050f, 0.380f}, 0, 0.28f},
    Preset{"plastic-matte-white", {0.780f, 0.780f, 0.770f}, 0, 0.70f},
    Preset{"plastic-matte-black", {0.024f, 0.024f, 0.025f}, 0, 0.65f},
    Preset{"rubber-black", {0.020f, 0.020f, 0.021f}, 0, 0.85f},
    Preset{"rubber-gray", {0.130f, 0.130f, 0.130f}, 0, 0.88f},
    Preset{"rubber-red", {0.330f, 0.030f, 0.025f}, 0, 0.85f},

    Preset{"ceramic-white", {0.820f, 0.810f, 0.780f}, 0, 0.16f},
    Preset{"ceramic-black", {0.025f, 0.025f, 0.026f}, 0, 0.14f},
    Preset{"ceramic-blue", {0.035f, 0.110f, 0.290f}, 0, 0.16f},
    Preset{"ceramic-celadon", {0.360f, 0.480f, 0.390f}, 0, 0.18f},
    Preset{"porcelain", {0.860f, 0.855f, 0.830f}, 0, 0.10f},
    Preset{"clay", {0.440f, 0.330f, 0.260f}, 0, 0.90f},
    Preset{"terracotta", {0.500f, 0.190f, 0.100f}, 0, 0.88f},
    Preset{"chalk", {0.880f, 0.875f, 0.850f}, 0, 0.98f},
    Preset{"plaster", {0.760f, 0.750f, 0.720f}, 0, 0.95f},
    Preset{"concrete", {0.340f, 0.330f, 0.310f}, 0, 0.92f},
    Preset{"slate", {0.060f, 0.066f, 0.074f}, 0, 0.62f},
    Preset{"paper", {0.800f, 0.795f, 0.770f}, 0, 0.96f},
    Preset{"leather-brown", {0.160f, 0.066f, 0.030f}, 0, 0.58f},
    Preset{"wood-birch", {0.620f, 0.450f, 0.270f}, 0, 0.60f},
    Preset{"wood-oak", {0.400f, 0.240f, 0.115f}, 0, 0.58f},
    Preset{"wood-walnut", {0.130f, 0.066f, 0.034f}, 0, 0.52f},

    // Car paint under its lacquer: flakes give the base some metal, the lacquer a low roughness.
    Preset{"paint-white", {0.780f, 0.780f, 0.780f}, 0, 0.12f},
    Preset{"paint-black", {0.015f, 0.015f, 0.017f}, 0, 0.08f},
    Preset{"paint-red", {0.520f, 0.012f, 0.014f}, 0.25f, 0.16f},
    Preset{"paint-blue", {0.014f, 0.075f, 0.330f}, 0.35f, 0.18f},
    Preset{"paint-green", {0.012f, 0.130f, 0.060f}, 0.35f, 0.18f},
    Preset{"paint-silver", {0.580f, 0.590f, 0.600f}, 0.80f, 0.26f},
    Preset{"paint-graphite", {0.085f, 0.090f, 0.098f}, 0.75f, 0.28f},
    Preset{"paint-champagne", {0.620f, 0.500f, 0.360f}, 0.80f, 0.28f},
};

}  // namespace

Material default_material() {
  return {};
}

bool is_color_texture(const Material& material, TextureUse use) {
  switch (use) {
    case TextureUse::kBaseColor:
    case TextureUse::kEmissive:
    case TextureUse::kSpecularColor:
    case TextureUse::kSheenColor:
    case TextureUse::kDiffuseTransmissionColor:
      return true;
    case TextureUse::kMetallicRoughness:
      return material.specular_glossiness;
    default:
      return false;
  }
}

std::optional<Material> material_preset(std::string_view name) {
  const auto preset =
      std::find_if(kPresets.begin(), kPresets.end(), [&](const Preset& p) { return p.name == name; });
  if (preset == kPresets.end()) return std::nullopt;
  Material material;
  material.name = preset->name;
  material.base_color = glm::vec4(preset->base_color, 1);
  material.metallic = preset->metallic;
  material.perceptual_roughness = preset->perceptual_roughness;
  return material;
}

std::vector<std::string_view> material_preset_names() {
  std::vector<std::string_view> names;
  names.reserve(kPresets.size());
  for (const Preset& preset : kPresets) names.push_back(preset.name);
  return names;
}

}  // namespace furnace
