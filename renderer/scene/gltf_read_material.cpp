// Images, samplers, textures and materials. A factor outside its range is brought back into it and noted; a
// wrong type or reference is an error.
#include <algorithm>
#include <array>
#include <utility>

#include <glm/gtc/type_ptr.hpp>

#include "renderer/scene/gltf_factors.hpp"

namespace furnace {

namespace {

// WebGL's constants, as glTF 2.0 lists them.
constexpr std::uint64_t kNearest = 9728, kLinear = 9729, kNearestMipmapNearest = 9984,
                        kLinearMipmapNearest = 9985, kNearestMipmapLinear = 9986, kLinearMipmapLinear = 9987,
                        kClampToEdge = 33071, kMirroredRepeat = 33648, kRepeat = 10497;

// The best picture first.
constexpr std::array<std::string_view, 3> kSourceExtensions{"KHR_texture_basisu", "EXT_texture_avif",
                                                            "EXT_texture_webp"};

Wrap read_wrap(const JsonObject& json, std::string_view key) {
  switch (json.integer(key, kRepeat)) {
    case kClampToEdge:
      return Wrap::kClampToEdge;
    case kMirroredRepeat:
      return Wrap::kMirroredRepeat;
    case kRepeat:
      return Wrap::kRepeat;
    default:
      json.refuse(key, "must be 33071, 33648 or 10497");
  }
}

glm::vec2 read_vec2(const JsonObject& json, std::string_view key, glm::vec2 fallback) {
  const auto values = json.vector<2>(key);
  if (!values) return fallback;
  return {bounded(json, key, (*values)[0]), bounded(json, key, (*values)[1])};
}

int read_uv_set(const JsonObject& json, int fallback) {
  return static_cast<int>(
      std::min<std::uint64_t>(json.integer("texCoord", static_cast<std::uint64_t>(fallback)), 99));
}

AlphaMode read_alpha_mode(const JsonObject& json) {
  const std::string mode = json.string("alphaMode", "OPAQUE");
  if (mode == "OPAQUE") return AlphaMode::kOpaque;
  if (mode == "MASK") return AlphaMode::kMask;
  if (mode == "BLEND") return AlphaMode::kBlend;
  json.refuse("alphaMode", "must be OPAQUE, MASK or BLEND");
}

void read_metallic_roughness(const JsonObject& json, const GltfCounts& counts, GltfMaterial& material) {
  Factors factors(json, material.notes);
  material.values.base_color = factors.vector<4>("baseColorFactor", material.values.base_color);
  material.values.metallic = factors.number("metallicFactor", 1, 0, 1);
  material.values.perceptual_roughness = factors.number("roughnessFactor", 1, 0, 1);
  material.texture(TextureUse::kBaseColor) = read_texture_ref(json, "baseColorTexture", counts);
  material.texture(TextureUse::kMetallicRoughness) =
      read_texture_ref(json, "metallicRoughnessTexture", counts);
}

}  // namespace

std::optional<GltfTextureRef> read_texture_ref(const JsonObject& owner, std::string_view key,
                                               const GltfCounts& counts) {
  const auto json = owner.object(key);
  if (!json) return std::nullopt;
  GltfTextureRef ref;
  ref.pointer = json->pointer();
  ref.texture = json->required_reference("index", "texture", counts.textures);
  ref.uv_set = read_uv_set(*json, 0);
  if (const auto transform = json->extension("KHR_texture_transform")) {
    ref.uv_set = read_uv_set(*transform, ref.uv_set);
    ref.transform.offset = read_vec2(*transform, "offset", {0, 0});
    ref.transform.rotation_rad = bounded(*transform, "rotation", transform->number("rotation", 0));
    ref.transform.scale = read_vec2(*transform, "scale", {1, 1});
  }
  return ref;
}

GltfImage read_image(const JsonObject& json, const GltfCounts& counts) {
  GltfImage image;
  image.uri = json.string("uri");
  image.buffer_view = json.reference("bufferView", "bufferView", counts.buffer_views);
  if (json.has("uri") == image.buffer_view.has_value()) {
    fail(ErrorCode::kUnprocessable, "must have either a uri or a bufferView", json.pointer());
  }
  return image;
}

SamplerDesc read_sampler(const JsonObject& json) {
  SamplerDesc sampler;
  sampler.wrap_u = read_wrap(json, "wrapS");
  sampler.wrap_v = read_wrap(json, "wrapT");
  switch (json.integer("magFilter", kLinear)) {
    case kNearest:
      sampler.mag = Filter::kNearest;
      break;
    case kLinear:
      sampler.mag = Filter::kLinear;
      break;
    default:
      json.refuse("magFilter", "must be 9728 or 9729");
  }
  const auto set_min = [&](Filter min, MipFilter mip) {
    sampler.min = min;
    sampler.mip = mip;
  };
  switch (json.integer("minFilter", kLinearMipmapLinear)) {
    case kNearest:
      set_min(Filter::kNearest, MipFilter::kNone);
      break;
    case kLinear:
      set_min(Filter::kLinear, MipFilter::kNone);
      break;
    case kNearestMipmapNearest:
      set_min(Filter::kNearest, MipFilter::kNearest);
      break;
    case kLinearMipmapNearest:
      set_min(Filter::kLinear, MipFilter::kNearest);
      break;
    case kNearestMipmapLinear:
      set_min(Filter::kNearest, MipFilter::kLinear);
      break;
    case kLinearMipmapLinear:
      set_min(Filter::kLinear, MipFilter::kLinear);
      break;
    default:
      json.refuse("minFilter", "must be 9728, 9729 or 9984 to 9987");
  }
  return sampler;
}

GltfTexture read_texture(const JsonObject& json, const GltfCounts& counts,
                         const std::vector<SamplerDesc>& samplers) {
  GltfTexture texture;
  for (const std::string_view name : kSourceExtensions) {
    const auto extension = json.extension(name);
    if (!extension) continue;
    if (const auto image = extension->reference("source", "image", counts.images))
      texture.images.push_back(*image);
  }
  if (const auto image = json.reference("source", "image", counts.images)) texture.images.push_back(*image);
  if (const auto sampler = json.reference("sampler", "sampler", counts.samplers)) {
    texture.sampler = samplers[static_cast<std::size_t>(*sampler)];
  }
  return texture;
}

GltfMaterial read_material(const JsonObject& json, const GltfCounts& counts) {
  GltfMaterial material;
  Material& values = material.values;
  values.name = json.string("name");
  if (const auto pbr = json.object("pbrMetallicRoughness")) read_metallic_roughness(*pbr, counts, material);

  material.texture(TextureUse::kNormal) = read_texture_ref(json, "normalTexture", counts);
  if (const auto normal = json.object("normalTexture")) {
    values.normal_scale = bounded(*normal, "scale", normal->number("scale", 1));
  }
  material.texture(TextureUse::kOcclusion) = read_texture_ref(json, "occlusionTexture", counts);
  if (const auto occlusion = json.object("occlusionTexture")) {
    values.occlusion_strength = Factors(*occlusion, material.notes).number("strength", 1, 0, 1);
  }
  material.texture(TextureUse::kEmissive) = read_texture_ref(json, "emissiveTexture", counts);
  Factors factors(json, material.notes);
  values.emissive = factors.vector<3>("emissiveFactor", values.emissive);
  values.alpha_mode = read_alpha_mode(json);
  values.alpha_cutoff = factors.number("alphaCutoff", 0.5, 0, kFloatMax);
  values.double_sided = json.boolean("doubleSided", false);

  values.unlit = json.extension("KHR_materials_unlit").has_value();
  if (const auto strength = json.extension("KHR_materials_emissive_strength")) {
    values.emissive_strength = Factors(*strength, material.notes).number("emissiveStrength", 1, 0, kFloatMax);
  }
  read_material_layers(json, counts, material);
  return material;
}

}  // namespace furnace
