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
  void (*finish)(Material& material) = nullptr;  // what lies over it or goes through it
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

// Scratches along the tangent: as rough across as a grinding belt leaves steel.
void brush(Material& material) {
  material.anisotropy = 0.7f;
}

void lacquer(Material& material) {
  material.clearcoat = 1;
  material.clearcoat_perceptual_roughness = 0.03f;
}

// Solid, half a metre deep as seen by rays, since built-in meshes are 1 m wide. `ior` at the sodium D line.
void fill_with_clear(Material& material, float ior) {
  material.transmission = 1;
  material.ior = ior;
  material.thickness_m = 0.5f;
}

void make_glass(Material& material) {
  fill_with_clear(material, 1.52f);  // soda-lime
}

void make_green_glass(Material& material) {
  make_glass(material);
  material.attenuation_color = {0.10f, 0.52f, 0.16f};
  material.attenuation_distance_m = 0.3f;
}

void make_pane(Material& material) {
  make_glass(material);
  material.thickness_m = 0;
}

// Pope and Fry 1997, "Absorption spectrum (380-700 nm) of pure water": 0.34, 0.057 and 0.009 1/m at 620, 545 and 450
// nm, after 5 m.
void fill_with_water(Material& material) {
  fill_with_clear(material, 1.333f);
  material.attenuation_color = {0.18f, 0.75f, 0.96f};
  material.attenuation_distance_m = 5;
}

void cut_diamond(Material& material) {
  fill_with_clear(material, 2.417f);
  material.dispersion = 20 / 55.3f;  // Abbe number
}

// Air on both sides of a film of water that runs down and thins out; half a wave of light to one and a half.
void blow_bubble(Material& material) {
  material.transmission = 1;
  material.ior = 1;
  material.iridescence = 1;
  material.iridescence_ior = 1.333f;
  material.iridescence_thickness_min_nm = 150;
  material.iridescence_thickness_max_nm = 550;
}

// Nacre is platelets of aragonite.
void cover_with_nacre(Material& material) {
  material.iridescence = 0.6f;
  material.iridescence_ior = 1.68f;
  material.iridescence_thickness_max_nm = 420;
  lacquer(material);
}

// A titanium dioxide layer, as anodising or heat leaves it.
void temper(Material& material) {
  material.iridescence = 1;
  material.iridescence_ior = 2.4f;
  material.iridescence_thickness_max_nm = 60;
}

// The pile's tips catch light at grazing angles, of the cloth's own colour bleached.
void raise_pile(Material& material) {
  material.sheen_color = glm::mix(glm::vec3(material.base_color), glm::vec3(1), 0.25f);
  material.sheen_perceptual_roughness = 0.45f;
  material.specular = 0.3f;
}

void make_satin(Material& material) {
  raise_pile(material);
  material.specular = 1;
  material.sheen_perceptual_roughness = 0.25f;
  material.anisotropy = 0.5f;
}

void let_light_through(Material& material) {
  material.diffuse_transmission = 0.4f;
  material.diffuse_transmission_color = glm::vec3(material.base_color);
}

// Metals: how a workshop leaves them. Dielectrics (glTF's F0 of 0.04): diffuse albedos between real extremes,
// 0.02 of black rubber and 0.9 of chalk; colours kept inside the gamut of real pigments so that light of any
// colour stays plausible.
constexpr std::array kPresets = {
    //     name                 base colour           metallic  roughness
    Preset{"gold", kGold, 1, 0.12f},
    Preset{"gold-rough", kGold, 1, 0.55f},
    Preset{"gold-brushed", kGold, 1, 0.32f, brush},
    Preset{"silver", kSilver, 1, 0.08f},
    Preset{"silver-rough", kSilver, 1, 0.50f},
    Preset{"silver-brushed", kSilver, 1, 0.30f, brush},
    Preset{"copper", kCopper, 1, 0.14f},
    Preset{"copper-rough", kCopper, 1, 0.55f},
    Preset{"copper-brushed", kCopper, 1, 0.34f, brush},
    Preset{"brass", kBrass, 1, 0.16f},
    Preset{"brass-rough", kBrass, 1, 0.55f},
    Preset{"brass-brushed", kBrass, 1, 0.34f, brush},
    Preset{"aluminum", kAluminum, 1, 0.22f},
    Preset{"aluminium", kAluminum, 1, 0.22f},
    Preset{"aluminum-rough", kAluminum, 1, 0.58f},
    Preset{"aluminium-rough", kAluminum, 1, 0.58f},
    Preset{"aluminum-brushed", kAluminum, 1, 0.36f, brush},
    Preset{"aluminium-brushed", kAluminum, 1, 0.36f, brush},
    Preset{"chrome", kChromium, 1, 0.03f},
    Preset{"chrome-rough", kChromium, 1, 0.40f},
    Preset{"iron", kIron, 1, 0.42f},
    Preset{"iron-cast", kIron * 0.55f, 1, 0.72f},
    Preset{"steel", kIron, 1, 0.18f},
    Preset{"steel-brushed", kIron, 1, 0.34f, brush},
    Preset{"nickel", kNickel, 1, 0.18f},
    Preset{"platinum", kPlatinum, 1, 0.14f},
    Preset{"palladium", kPalladium, 1, 0.16f},
    Preset{"titanium", kTitanium, 1, 0.28f},
    Preset{"titanium-brushed", kTitanium, 1, 0.42f, brush},
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

    // Car paint under its lacquer: flakes give the base some metal.
    Preset{"paint-white", {0.780f, 0.780f, 0.780f}, 0, 0.45f, lacquer},
    Preset{"paint-black", {0.015f, 0.015f, 0.017f}, 0, 0.45f, lacquer},
    Preset{"paint-red", {0.520f, 0.012f, 0.014f}, 0.25f, 0.40f, lacquer},
    Preset{"paint-blue", {0.014f, 0.075f, 0.330f}, 0.35f, 0.40f, lacquer},
    Preset{"paint-green", {0.012f, 0.130f, 0.060f}, 0.35f, 0.40f, lacquer},
    Preset{"paint-silver", {0.580f, 0.590f, 0.600f}, 0.80f, 0.36f, lacquer},
    Preset{"paint-graphite", {0.085f, 0.090f, 0.098f}, 0.75f, 0.38f, lacquer},
    Preset{"paint-champagne", {0.620f, 0.500f, 0.360f}, 0.80f, 0.38f, lacquer},
    Preset{"wood-lacquered", {0.240f, 0.110f, 0.045f}, 0, 0.50f, lacquer},

    // The base colour tints what goes through.
    Preset{"glass", {1.000f, 1.000f, 1.000f}, 0, 0, make_glass},
    Preset{"glass-frosted", {1.000f, 1.000f, 1.000f}, 0, 0.45f, make_glass},
    Preset{"glass-green", {1.000f, 1.000f, 1.000f}, 0, 0, make_green_glass},
    Preset{"glass-pane", {1.000f, 1.000f, 1.000f}, 0, 0, make_pane},
    Preset{"water", {1.000f, 1.000f, 1.000f}, 0, 0, fill_with_water},
    Preset{"diamond", {1.000f, 1.000f, 1.000f}, 0, 0, cut_diamond},

    Preset{"soap-bubble", {1.000f, 1.000f, 1.000f}, 0, 0, blow_bubble},
    Preset{"pearl", {0.780f, 0.740f, 0.700f}, 0, 0.30f, cover_with_nacre},
    Preset{"titanium-tempered", kTitanium, 1, 0.25f, temper},

    Preset{"velvet-red", {0.190f, 0.010f, 0.016f}, 0, 0.90f, raise_pile},
    Preset{"velvet-blue", {0.014f, 0.030f, 0.170f}, 0, 0.90f, raise_pile},
    Preset{"velvet-black", {0.012f, 0.012f, 0.012f}, 0, 0.90f, raise_pile},
    Preset{"satin-white", {0.720f, 0.710f, 0.690f}, 0, 0.42f, make_satin},
    Preset{"leaf", {0.110f, 0.250f, 0.040f}, 0, 0.50f, let_light_through},
};

}  // namespace

Material default_material() {
  return {};
}

std::string_view texture_use_name(TextureUse use) {
  static constexpr std::array<std::string_view, kTextureUses> kNames = {
      "baseColor",
      "metallicRoughness",
      "normal",
      "occlusion",
      "emissive",
      "specular",
      "specularColor",
      "clearcoat",
      "clearcoatRoughness",
      "clearcoatNormal",
      "sheenColor",
      "sheenRoughness",
      "anisotropy",
      "iridescence",
      "iridescenceThickness",
      "transmission",
      "thickness",
      "diffuseTransmission",
      "diffuseTransmissionColor",
  };
  return kNames[std::size_t(use)];
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
  if (preset->finish != nullptr) preset->finish(material);
  return material;
}

std::vector<std::string_view> material_preset_names() {
  std::vector<std::string_view> names;
  names.reserve(kPresets.size());
  for (const Preset& preset : kPresets) names.push_back(preset.name);
  return names;
}

}  // namespace furnace
