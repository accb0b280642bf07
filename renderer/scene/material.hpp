// The material of glTF 2.0 core, with every field's unit, range and default. Layout for the GPU is floor 5's
// business.
#pragma once

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

struct Material {
  std::string name;
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
  bool unlit = false;  // KHR_materials_unlit
  std::optional<TextureSlot> base_color_texture, metallic_roughness_texture, normal_texture,
      occlusion_texture, emissive_texture;
};

// glTF 2.0, section 3.7.2.1: the material of a primitive that names none, all properties at their defaults.
Material default_material();

// Presets: metals by name with "-rough" (sand-blasted) and "-brushed" variants ("gold", "gold-rough",
// "steel-brushed"), and families with a colour or kind ("plastic-red", "rubber-black", "wood-oak",
// "paint-blue"). The table is in material.cpp; names are kebab-case and listed in its order; the material
// carries its preset's name.
std::optional<Material> material_preset(std::string_view name);
std::vector<std::string_view> material_preset_names();

}  // namespace furnace
