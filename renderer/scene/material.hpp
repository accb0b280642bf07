// The material of glTF 2.0 and its ratified extensions, with every field's unit, range and default. Layout for
// the GPU is floor 5's business.
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

namespace furnace {

enum class AlphaMode { kOpaque, kMask, kBlend };
enum class Wrap { kRepeat, kMirroredRepeat, kClampToEdge };
enum class Filter { kNearest, kLinear };
enum class MipFilter { kNone, kNearest, kLinear };

struct SamplerDesc {
  Wrap wrap_u = Wrap::kRepeat;
  Wrap wrap_v = Wrap::kRepeat;
  Filter mag = Filter::kLinear;
  Filter min = Filter::kLinear;
  MipFilter mip = MipFilter::kLinear;

  bool operator==(const SamplerDesc&) const = default;
};

// KHR_texture_transform: uv' = translate(offset) * rotate(rotation, counter-clockwise in glTF's sense) *
// scale * uv.
struct UvTransform {
  glm::vec2 offset{0};
  float rotation_rad = 0;
  glm::vec2 scale{1};

  bool operator==(const UvTransform&) const = default;
};

struct TextureSlot {
  int image = -1;  // index into Scene::images
  int uv_set = 0;  // 0 or 1
  SamplerDesc sampler;
  UvTransform transform;

  bool operator==(const TextureSlot&) const = default;
};

// What a texture is for. Channels as glTF packs them: r, g, b, a of the texel.
enum class TextureUse {
  kBaseColor,          // rgb sRGB, a; of a specular-glossiness material its diffuse colour
  kMetallicRoughness,  // g: roughness, b: metallic; of a specular-glossiness material rgb sRGB: F0, a: glossiness
  kNormal,
  kOcclusion,                 // r
  kEmissive,                  // rgb sRGB
  kSpecular,                  // a
  kSpecularColor,             // rgb sRGB
  kClearcoat,                 // r
  kClearcoatRoughness,        // g
  kClearcoatNormal,           // rgb
  kSheenColor,                // rgb sRGB
  kSheenRoughness,            // a
  kAnisotropy,                // rg: direction, b: strength
  kIridescence,               // r
  kIridescenceThickness,      // g
  kTransmission,              // r
  kThickness,                 // g
  kDiffuseTransmission,       // a
  kDiffuseTransmissionColor,  // rgb sRGB
};
inline constexpr std::size_t kTextureUses = 19;
// "baseColor", ...: in requests and in their JSON pointers.
std::string_view texture_use_name(TextureUse use);

// How light meets the surface; all are driven by the same numbers.
enum class ShadingModel {
  kPbr,              // GGX, height-correlated Smith, multiple scattering compensated
  kSchlickBeckmann,  // GGX with Schlick's approximation of Smith, not compensated: the classic real-time model
  kBlinnPhong,
  kPhong,
};

inline constexpr float kLeastAttenuation = 1e-6f;  // black in single precision, with a logarithm

struct Material {
  std::string name;
  ShadingModel model = ShadingModel::kPbr;
  bool unlit = false;              // KHR_materials_unlit
  glm::vec4 base_color{1};         // linear, [0,1]; times texture (sRGB) times COLOR_0
  float metallic = 1;              // [0,1]; times texture B
  float perceptual_roughness = 1;  // [0,1]; times texture G
  glm::vec3 emissive{0};           // linear radiance factor (nits at exposure 1), >= 0; times texture (sRGB)
  float emissive_strength = 1;     // KHR_materials_emissive_strength, >= 0
  float normal_scale = 1;          // scales x and y of the normal map
  float occlusion_strength = 1;    // [0,1]
  AlphaMode alpha_mode = AlphaMode::kOpaque;
  float alpha_cutoff = 0.5f;  // kMask only, >= 0
  bool double_sided = false;

  float ior = 1.5f;  // KHR_materials_ior: >= 1, or 0 for a dielectric that reflects like a metal

  // KHR_materials_specular
  float specular = 1;           // [0,1]
  glm::vec3 specular_color{1};  // linear, >= 0

  // KHR_materials_clearcoat
  float clearcoat = 0;  // [0,1]
  float clearcoat_perceptual_roughness = 0;
  float clearcoat_normal_scale = 1;

  // KHR_materials_sheen
  glm::vec3 sheen_color{0};  // linear, [0,1]
  float sheen_perceptual_roughness = 0;

  // KHR_materials_anisotropy
  float anisotropy = 0;               // strength, [0,1]
  float anisotropy_rotation_rad = 0;  // counter-clockwise from the tangent

  // KHR_materials_iridescence
  float iridescence = 0;  // [0,1]
  float iridescence_ior = 1.3f;
  float iridescence_thickness_min_nm = 100;  // where the texture is 0
  float iridescence_thickness_max_nm = 400;  // where it is 1, or where there is none

  // KHR_materials_transmission, KHR_materials_volume, KHR_materials_dispersion
  float transmission = 0;  // [0,1]
  float thickness_m = 0;   // in the mesh's own frame; 0: thin-walled, rays are not bent
  float attenuation_distance_m = std::numeric_limits<float>::infinity();  // > 0, world
  glm::vec3 attenuation_color{1};  // linear, [kLeastAttenuation,1]: left after that distance
  float dispersion = 0;            // 20 / Abbe number, >= 0

  // KHR_materials_diffuse_transmission
  float diffuse_transmission = 0;           // [0,1]
  glm::vec3 diffuse_transmission_color{1};  // linear, [0,1]

  // KHR_materials_pbrSpecularGlossiness: `metallic` and `perceptual_roughness` are without effect, base_color is the diffuse colour.
  bool specular_glossiness = false;
  glm::vec3 glossy_specular{1};  // F0, linear, [0,1]
  float glossiness = 1;          // 1 - perceptual roughness

  std::array<std::optional<TextureSlot>, kTextureUses> textures;

  const std::optional<TextureSlot>& texture(TextureUse use) const { return textures[std::size_t(use)]; }
  std::optional<TextureSlot>& texture(TextureUse use) { return textures[std::size_t(use)]; }
};

// Whether its texels hold colours in sRGB, or numbers.
bool is_color_texture(const Material& material, TextureUse use);

// glTF 2.0, section 3.7.2.1: the material of a primitive that names none, all properties at their defaults.
Material default_material();

// Presets: metals by name with "-rough" (sand-blasted) and "-brushed" variants ("gold", "gold-rough",
// "steel-brushed"), and families with a colour or kind ("plastic-red", "rubber-black", "wood-oak",
// "paint-blue", "velvet-red", "glass-frosted"). The table is in material.cpp; names are kebab-case and listed in its order; the material
// carries its preset's name.
std::optional<Material> material_preset(std::string_view name);
std::vector<std::string_view> material_preset_names();

}  // namespace furnace
