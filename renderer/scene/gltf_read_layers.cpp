// The material extensions, each with the names, ranges and defaults of its text (Khronos, glTF/extensions/2.0).
#include "renderer/scene/gltf_factors.hpp"

namespace furnace {

namespace {

// Beyond it nothing in a picture changes any more; its square still has room.
constexpr double kMostIor = 1e3;
// A film that thick shows no colours; its phases would be noise in single precision.
constexpr double kMostFilmNm = 1e6;
constexpr double kLeastDistanceM = 1e-6;

// One extension of a material, if it is there.
// Threads: one. Owns: nothing.
class Layer {
 public:
  Layer(const JsonObject& json, const GltfCounts& counts, GltfMaterial& material)
      : json_(json), counts_(counts), material_(material), factors_(json, material.notes) {}

  float number(std::string_view key, double fallback, double low, double high) {
    return factors_.number(key, fallback, low, high);
  }
  float unit(std::string_view key, double fallback) { return factors_.number(key, fallback, 0, 1); }
  template <int N>
  glm::vec<N, float> color(std::string_view key, const glm::vec<N, float>& fallback, double high = 1) {
    return factors_.vector<N>(key, fallback, high);
  }
  void texture(std::string_view key, TextureUse use) {
    material_.texture(use) = read_texture_ref(json_, key, counts_);
  }
  const JsonObject& json() const { return json_; }

 private:
  const JsonObject& json_;
  const GltfCounts& counts_;
  GltfMaterial& material_;
  Factors factors_;
};

void read_ior(Layer& layer, Material& values) {
  const double ior = layer.json().number("ior", 1.5);
  values.ior = layer.number("ior", 1.5, ior == 0 ? 0 : 1, kMostIor);
}

void read_specular(Layer& layer, Material& values) {
  values.specular = layer.unit("specularFactor", 1);
  values.specular_color = layer.color("specularColorFactor", glm::vec3(1), kFloatMax);
  layer.texture("specularTexture", TextureUse::kSpecular);
  layer.texture("specularColorTexture", TextureUse::kSpecularColor);
}

void read_clearcoat(Layer& layer, Material& values) {
  values.clearcoat = layer.unit("clearcoatFactor", 0);
  values.clearcoat_perceptual_roughness = layer.unit("clearcoatRoughnessFactor", 0);
  layer.texture("clearcoatTexture", TextureUse::kClearcoat);
  layer.texture("clearcoatRoughnessTexture", TextureUse::kClearcoatRoughness);
  layer.texture("clearcoatNormalTexture", TextureUse::kClearcoatNormal);
  if (const auto normal = layer.json().object("clearcoatNormalTexture"))
    values.clearcoat_normal_scale = bounded(*normal, "scale", normal->number("scale", 1));
}

void read_sheen(Layer& layer, Material& values) {
  values.sheen_color = layer.color("sheenColorFactor", glm::vec3(0));
  values.sheen_perceptual_roughness = layer.unit("sheenRoughnessFactor", 0);
  layer.texture("sheenColorTexture", TextureUse::kSheenColor);
  layer.texture("sheenRoughnessTexture", TextureUse::kSheenRoughness);
}

void read_anisotropy(Layer& layer, Material& values) {
  values.anisotropy = layer.unit("anisotropyStrength", 0);
  values.anisotropy_rotation_rad =
      bounded(layer.json(), "anisotropyRotation", layer.json().number("anisotropyRotation", 0));
  layer.texture("anisotropyTexture", TextureUse::kAnisotropy);
}

void read_iridescence(Layer& layer, Material& values) {
  values.iridescence = layer.unit("iridescenceFactor", 0);
  values.iridescence_ior = layer.number("iridescenceIor", 1.3, 1, kMostIor);
  values.iridescence_thickness_min_nm = layer.number("iridescenceThicknessMinimum", 100, 0, kMostFilmNm);
  values.iridescence_thickness_max_nm = layer.number("iridescenceThicknessMaximum", 400, 0, kMostFilmNm);
  layer.texture("iridescenceTexture", TextureUse::kIridescence);
  layer.texture("iridescenceThicknessTexture", TextureUse::kIridescenceThickness);
}

void read_transmission(Layer& layer, Material& values) {
  values.transmission = layer.unit("transmissionFactor", 0);
  layer.texture("transmissionTexture", TextureUse::kTransmission);
}

void read_volume(Layer& layer, Material& values) {
  values.thickness_m = layer.number("thicknessFactor", 0, 0, kFloatMax);
  if (layer.json().has("attenuationDistance"))
    values.attenuation_distance_m = layer.number("attenuationDistance", 1, kLeastDistanceM, kFloatMax);
  // Black is legal, but its logarithm is no number.
  values.attenuation_color = glm::max(layer.color("attenuationColor", glm::vec3(1)), kLeastAttenuation);
  layer.texture("thicknessTexture", TextureUse::kThickness);
}

void read_dispersion(Layer& layer, Material& values) {
  values.dispersion = layer.number("dispersion", 0, 0, kMostIor);
}

void read_diffuse_transmission(Layer& layer, Material& values) {
  values.diffuse_transmission = layer.unit("diffuseTransmissionFactor", 0);
  values.diffuse_transmission_color = layer.color("diffuseTransmissionColorFactor", glm::vec3(1));
  layer.texture("diffuseTransmissionTexture", TextureUse::kDiffuseTransmission);
  layer.texture("diffuseTransmissionColorTexture", TextureUse::kDiffuseTransmissionColor);
}

// It takes the place of pbrMetallicRoughness.
void read_specular_glossiness(Layer& layer, Material& values) {
  values.specular_glossiness = true;
  values.base_color = layer.color("diffuseFactor", glm::vec4(1));
  values.glossy_specular = layer.color("specularFactor", glm::vec3(1));
  values.glossiness = layer.unit("glossinessFactor", 1);
  // For who makes a metallic-roughness material of it (MaterialOverride).
  values.metallic = 0;
  values.perceptual_roughness = 1 - values.glossiness;
  layer.texture("diffuseTexture", TextureUse::kBaseColor);
  layer.texture("specularGlossinessTexture", TextureUse::kMetallicRoughness);
}

struct Extension {
  std::string_view name;
  void (*read)(Layer& layer, Material& values);
};

constexpr Extension kExtensions[] = {
    {"KHR_materials_ior", read_ior},
    {"KHR_materials_specular", read_specular},
    {"KHR_materials_clearcoat", read_clearcoat},
    {"KHR_materials_sheen", read_sheen},
    {"KHR_materials_anisotropy", read_anisotropy},
    {"KHR_materials_iridescence", read_iridescence},
    {"KHR_materials_transmission", read_transmission},
    {"KHR_materials_volume", read_volume},
    {"KHR_materials_dispersion", read_dispersion},
    {"KHR_materials_diffuse_transmission", read_diffuse_transmission},
    {"KHR_materials_pbrSpecularGlossiness", read_specular_glossiness},
};

}  // namespace

void read_material_layers(const JsonObject& json, const GltfCounts& counts, GltfMaterial& material) {
  for (const Extension& extension : kExtensions) {
    const auto found = json.extension(extension.name);
    if (!found) continue;
    Layer layer(*found, counts, material);
    extension.read(layer, material.values);
  }
}

}  // namespace furnace
