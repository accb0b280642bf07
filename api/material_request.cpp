#include "api/material_request.hpp"

#include "renderer/image/decode.hpp"

namespace furnace::api {
namespace {

void read_sampling(const Value& value, TextureFile& texture) {
  read(value["uvSet"], texture.uv_set);
  read(value["offset"], texture.transform.offset);
  double rotation_rad = 0;
  read_degrees(value["rotationDegrees"], rotation_rad);
  texture.transform.rotation_rad = static_cast<float>(rotation_rad);
  read(value["scale"], texture.transform.scale);
  static constexpr Choice<Wrap> kWraps[] = {{"repeat", Wrap::kRepeat},
                                            {"mirrored-repeat", Wrap::kMirroredRepeat},
                                            {"clamp-to-edge", Wrap::kClampToEdge}};
  read_choice(value["wrap"], kWraps, texture.sampler.wrap_u);
  texture.sampler.wrap_v = texture.sampler.wrap_u;
  static constexpr Choice<Filter> kFilters[] = {{"linear", Filter::kLinear}, {"nearest", Filter::kNearest}};
  read_choice(value["filter"], kFilters, texture.sampler.mag);
  texture.sampler.min = texture.sampler.mag;
  if (texture.sampler.mag == Filter::kNearest) texture.sampler.mip = MipFilter::kNearest;
}

Blob read_image(const Value& reference, const AssetResolver& assets, Faults& faults) {
  Blob encoded;
  faults.collect(reference, [&] {
    encoded = assets.read(std::string(reference.text()), reference.pointer());
    const ImageFormat format = sniff_image_format(encoded.bytes());
    if (is_texture_format(format)) return;
    fail(ErrorCode::kUnprocessable,
         fmt::format("a texture is a {} file; the format of this one is {}", kTextureFormats,
                     image_format_name(format)),
         reference.pointer());
  });
  return encoded;
}

TextureOverride read_texture(const Value& value, const AssetResolver& assets, Faults& faults) {
  if (!value) return KeepTexture{};
  if (value.type() == JsonType::kNull) return NoTexture{};
  TextureFile texture;
  const bool bare = value.type() == JsonType::kText;
  if (!bare) read_sampling(value, texture);
  texture.encoded = read_image(bare ? value : value["map"], assets, faults);
  return texture;
}

void read_layers(const Value& value, MaterialOverride& material, Faults& faults) {
  read(value["ior"], material.ior);
  if (material.ior && *material.ior > 0 && *material.ior < 1)
    faults.add(ErrorCode::kUnprocessable, value["ior"],
               fmt::format("must be 0 or at least 1, got {}", value["ior"].excerpt()));
  read(value["specular"], material.specular);
  read(value["specularColor"], material.specular_color);
  read(value["clearcoat"], material.clearcoat);
  read(value["clearcoatRoughness"], material.clearcoat_perceptual_roughness);
  read(value["clearcoatNormalScale"], material.clearcoat_normal_scale);
  read(value["sheenColor"], material.sheen_color);
  read(value["sheenRoughness"], material.sheen_perceptual_roughness);
  read(value["anisotropy"], material.anisotropy);
  if (const Value rotation = value["anisotropyRotationDegrees"])
    material.anisotropy_rotation_rad = static_cast<float>(radians_from_degrees(rotation.number()));
  read(value["iridescence"], material.iridescence);
  read(value["iridescenceIor"], material.iridescence_ior);
  read(value["iridescenceThicknessMinimumNanometres"], material.iridescence_thickness_min_nm);
  read(value["iridescenceThicknessMaximumNanometres"], material.iridescence_thickness_max_nm);
  read(value["transmission"], material.transmission);
  read(value["thicknessMetres"], material.thickness_m);
  read(value["attenuationDistanceMetres"], material.attenuation_distance_m);
  read(value["attenuationColor"], material.attenuation_color);
  read(value["dispersion"], material.dispersion);
  read(value["diffuseTransmission"], material.diffuse_transmission);
  read(value["diffuseTransmissionColor"], material.diffuse_transmission_color);
}

}  // namespace

void read_shading_model(const Value& value, ShadingModel& target) {
  static constexpr Choice<ShadingModel> kModels[] = {{"pbr", ShadingModel::kPbr},
                                                     {"schlick-beckmann", ShadingModel::kSchlickBeckmann},
                                                     {"blinn-phong", ShadingModel::kBlinnPhong},
                                                     {"phong", ShadingModel::kPhong}};
  read_choice(value, kModels, target);
}

MaterialOverride read_material(const Value& value, const AssetResolver& assets, Faults& faults) {
  MaterialOverride material;
  if (value.type() == JsonType::kText) {
    read(value, material.preset.emplace());
    return material;
  }
  read(value["preset"], material.preset);
  if (const Value model = value["model"]) read_shading_model(model, material.model.emplace());
  read(value["baseColor"], material.base_color);
  read(value["metallic"], material.metallic);
  read(value["roughness"], material.perceptual_roughness);
  read(value["emissive"], material.emissive);
  read(value["emissiveStrength"], material.emissive_strength);
  read(value["normalScale"], material.normal_scale);
  read(value["occlusionStrength"], material.occlusion_strength);
  read(value["alphaCutoff"], material.alpha_cutoff);
  read(value["doubleSided"], material.double_sided);
  read(value["unlit"], material.unlit);
  static constexpr Choice<AlphaMode> kModes[] = {
      {"OPAQUE", AlphaMode::kOpaque}, {"MASK", AlphaMode::kMask}, {"BLEND", AlphaMode::kBlend}};
  if (const Value mode = value["alphaMode"]) read_choice(mode, kModes, material.alpha_mode.emplace());
  read_layers(value, material, faults);
  for (std::size_t use = 0; use < kTextureUses; ++use)
    material.textures[use] =
        read_texture(value["textures"][texture_use_name(TextureUse(use))], assets, faults);
  return material;
}

}  // namespace furnace::api
