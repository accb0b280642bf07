#include "renderer/scene/gltf_properties.hpp"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace furnace {

namespace {

constexpr double kAny = std::numeric_limits<double>::infinity();
constexpr double kTiny = 1e-6;
constexpr double kRightAngle = 1.5707963267948966;

struct Row {
  std::string_view pattern;  // '*' stands for an index, a leading "..." for any texture of a material
  AnimatedProperty property;
};

constexpr AnimatedProperty numbers(int components, double least = -kAny, double most = kAny) {
  return {PropertyKind::kNumbers, components, least, most};
}

// Factors of materials need no range here: their reader keeps them in theirs.
constexpr Row kRows[] = {
    {"/nodes/*/translation", numbers(3)},
    {"/nodes/*/rotation", {PropertyKind::kRotation, 4}},
    {"/nodes/*/scale", numbers(3)},
    {"/nodes/*/weights", {PropertyKind::kWeights, 1}},
    {"/nodes/*/weights/*", numbers(1)},
    {"/nodes/*/extensions/KHR_node_visibility/visible", {PropertyKind::kFlag, 1}},
    {"/meshes/*/weights", {PropertyKind::kWeights, 1}},
    {"/meshes/*/weights/*", numbers(1)},
    {"/cameras/*/perspective/aspectRatio", numbers(1, kTiny)},
    {"/cameras/*/perspective/yfov", numbers(1, kTiny, 3.1415)},
    {"/cameras/*/perspective/znear", numbers(1, kTiny)},
    {"/cameras/*/perspective/zfar", numbers(1, kTiny)},
    {"/cameras/*/orthographic/xmag", numbers(1)},
    {"/cameras/*/orthographic/ymag", numbers(1)},
    {"/cameras/*/orthographic/znear", numbers(1, 0)},
    {"/cameras/*/orthographic/zfar", numbers(1, kTiny)},
    {"/extensions/KHR_lights_punctual/lights/*/color", numbers(3, 0)},
    {"/extensions/KHR_lights_punctual/lights/*/intensity", numbers(1, 0)},
    {"/extensions/KHR_lights_punctual/lights/*/range", numbers(1, kTiny)},
    {"/extensions/KHR_lights_punctual/lights/*/spot/innerConeAngle", numbers(1, 0, kRightAngle)},
    {"/extensions/KHR_lights_punctual/lights/*/spot/outerConeAngle", numbers(1, kTiny, kRightAngle)},
    {"/materials/*/alphaCutoff", numbers(1)},
    {"/materials/*/emissiveFactor", numbers(3)},
    {"/materials/*/normalTexture/scale", numbers(1)},
    {"/materials/*/occlusionTexture/strength", numbers(1)},
    {"/materials/*/pbrMetallicRoughness/baseColorFactor", numbers(4)},
    {"/materials/*/pbrMetallicRoughness/metallicFactor", numbers(1)},
    {"/materials/*/pbrMetallicRoughness/roughnessFactor", numbers(1)},
    {"/materials/*/extensions/KHR_materials_anisotropy/anisotropyStrength", numbers(1)},
    {"/materials/*/extensions/KHR_materials_anisotropy/anisotropyRotation", numbers(1)},
    {"/materials/*/extensions/KHR_materials_clearcoat/clearcoatFactor", numbers(1)},
    {"/materials/*/extensions/KHR_materials_clearcoat/clearcoatRoughnessFactor", numbers(1)},
    {"/materials/*/extensions/KHR_materials_clearcoat/clearcoatNormalTexture/scale", numbers(1)},
    {"/materials/*/extensions/KHR_materials_diffuse_transmission/diffuseTransmissionFactor", numbers(1)},
    {"/materials/*/extensions/KHR_materials_diffuse_transmission/diffuseTransmissionColorFactor", numbers(3)},
    {"/materials/*/extensions/KHR_materials_dispersion/dispersion", numbers(1)},
    {"/materials/*/extensions/KHR_materials_emissive_strength/emissiveStrength", numbers(1)},
    {"/materials/*/extensions/KHR_materials_ior/ior", numbers(1)},
    {"/materials/*/extensions/KHR_materials_iridescence/iridescenceFactor", numbers(1)},
    {"/materials/*/extensions/KHR_materials_iridescence/iridescenceIor", numbers(1)},
    {"/materials/*/extensions/KHR_materials_iridescence/iridescenceThicknessMinimum", numbers(1)},
    {"/materials/*/extensions/KHR_materials_iridescence/iridescenceThicknessMaximum", numbers(1)},
    {"/materials/*/extensions/KHR_materials_pbrSpecularGlossiness/diffuseFactor", numbers(4)},
    {"/materials/*/extensions/KHR_materials_pbrSpecularGlossiness/specularFactor", numbers(3)},
    {"/materials/*/extensions/KHR_materials_pbrSpecularGlossiness/glossinessFactor", numbers(1)},
    {"/materials/*/extensions/KHR_materials_sheen/sheenColorFactor", numbers(3)},
    {"/materials/*/extensions/KHR_materials_sheen/sheenRoughnessFactor", numbers(1)},
    {"/materials/*/extensions/KHR_materials_specular/specularFactor", numbers(1)},
    {"/materials/*/extensions/KHR_materials_specular/specularColorFactor", numbers(3)},
    {"/materials/*/extensions/KHR_materials_transmission/transmissionFactor", numbers(1)},
    {"/materials/*/extensions/KHR_materials_volume/thicknessFactor", numbers(1)},
    {"/materials/*/extensions/KHR_materials_volume/attenuationDistance", numbers(1)},
    {"/materials/*/extensions/KHR_materials_volume/attenuationColor", numbers(3)},
    {".../extensions/KHR_texture_transform/offset", numbers(2)},
    {".../extensions/KHR_texture_transform/rotation", numbers(1)},
    {".../extensions/KHR_texture_transform/scale", numbers(2)},
};

// RFC 6901, section 4: an index has no leading zeros.
bool is_index(std::string_view token) {
  constexpr std::size_t kMaxDigits = 9;
  return !token.empty() && token.size() <= kMaxDigits && (token == "0" || token[0] != '0') &&
         std::all_of(token.begin(), token.end(), [](char c) { return c >= '0' && c <= '9'; });
}

// The first token of a pointer without its slash; what remains is left in `pointer`.
std::string_view take_token(std::string_view& pointer) {
  pointer.remove_prefix(1);
  const std::size_t end = std::min(pointer.find('/'), pointer.size());
  const std::string_view token = pointer.substr(0, end);
  pointer.remove_prefix(end);
  return token;
}

bool matches(std::string_view pattern, std::string_view pointer) {
  while (pattern.starts_with('/') && pointer.starts_with('/')) {
    const std::string_view wanted = take_token(pattern), token = take_token(pointer);
    if (wanted == "*" ? !is_index(token) : wanted != token) return false;
  }
  return pattern.empty() && pointer.empty();
}

// "/materials/INDEX/.../SOMETHINGTexture"
bool is_texture(std::string_view pointer) {
  if (!pointer.ends_with("Texture") || !pointer.starts_with("/materials/")) return false;
  take_token(pointer);
  return is_index(take_token(pointer)) && !pointer.empty();
}

}  // namespace

std::optional<AnimatedProperty> find_animated_property(std::string_view pointer) {
  constexpr std::string_view kAnyTexture = "...";
  for (const Row& row : kRows) {
    if (!row.pattern.starts_with(kAnyTexture)) {
      if (matches(row.pattern, pointer)) return row.property;
      continue;
    }
    const std::string_view end = row.pattern.substr(kAnyTexture.size());
    if (pointer.ends_with(end) && is_texture(pointer.substr(0, pointer.size() - end.size())))
      return row.property;
  }
  return std::nullopt;
}

}  // namespace furnace
