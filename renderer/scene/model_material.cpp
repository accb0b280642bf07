#include "renderer/scene/model_material.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "renderer/image/color.hpp"
#include "renderer/scene/text_lines.hpp"

namespace furnace {
namespace {

constexpr const char* kModelPlace = "/scene/model";
constexpr glm::vec3 kUnstatedDiffuse(0.6f);

// What MTL files call it, the usual name first.
struct TextureNames {
  const char* usual;
  std::array<std::string_view, 3> lower_case;
};

const TextureNames& names_of(PlainTexture what) {
  static constexpr std::array<TextureNames, kPlainTextures> kNames = {
      {{"map_Kd", {"map_kd"}},
       {"map_Ke", {"map_ke", "map_emissive"}},
       {"norm", {"norm", "map_kn", "map_norm"}},
       {"map_Bump", {"map_bump", "bump"}},
       {"map_d", {"map_d", "map_opacity"}}}};
  return kNames[std::size_t(what)];
}

bool is_of(const MtlTexture& texture, PlainTexture what) {
  const auto& names = names_of(what).lower_case;
  return std::ranges::find(names, lower(texture.statement)) != names.end();
}

bool is_read(const MtlTexture& texture) {
  for (std::size_t i = 0; i < kPlainTextures; ++i)
    if (is_of(texture, PlainTexture(i))) return true;
  return false;
}

float linear(float encoded) {
  return encoded > 1 ? encoded : float(linear_from_srgb(encoded));
}

glm::vec3 linear(const glm::vec3& encoded) {
  return {linear(encoded.r), linear(encoded.g), linear(encoded.b)};
}

float roughness_of(float exponent) {
  const double alpha = std::sqrt(2 / (exponent + 2.0));
  return float(std::sqrt(alpha));
}

}  // namespace

bool looks_like_normal_map(const Image& image) {
  constexpr double kLengthSlack = 0.2, kShare = 0.9, kLeastBlue = 0.25, kSlopes = 0.3;
  if (image.channels < 3 || image.extent.area() == 0) return false;
  const bool wide = image.type == SampleType::kUint16;
  const double most = wide ? 65535 : 255;
  const auto sample = [&](std::size_t i) {
    return (wide ? image.samples<std::uint16_t>()[i] : image.samples<std::uint8_t>()[i]) / most * 2 - 1;
  };
  glm::dvec3 sum(0);
  std::int64_t unit = 0;
  const std::int64_t texels = image.extent.area();
  for (std::int64_t i = 0; i < texels; ++i) {
    const std::size_t at = std::size_t(i) * std::size_t(image.channels);
    const glm::dvec3 n(sample(at), sample(at + 1), sample(at + 2));
    sum += n;
    if (n.z > 0 && std::abs(glm::length(n) - 1) < kLengthSlack) ++unit;
  }
  const glm::dvec3 mean = sum / double(texels);
  const bool outwards = mean.z > kLeastBlue && std::abs(mean.x) < kSlopes && std::abs(mean.y) < kSlopes;
  return outwards && double(unit) >= kShare * double(texels);
}

int MaterialMaker::material(std::uint32_t plain, bool colored) {
  const PlainMaterial& from = model_.materials[plain];
  const bool takes_colors = colored && from.diffuse == kUnstatedDiffuse;
  const auto known = made_.find({plain, takes_colors});
  if (known != made_.end()) return known->second;
  Material made = made_of(from, takes_colors);
  scene_.materials.push_back(std::move(made));
  return made_[{plain, takes_colors}] = int(scene_.materials.size()) - 1;
}

Material MaterialMaker::made_of(const PlainMaterial& from, bool colored) {
  Material to;
  to.name = readable_text(model_.text_of(from.name));
  to.double_sided = true;  // nothing in these files says which side is outside
  const bool textured = from.textures[std::size_t(PlainTexture::kBaseColor)].size > 0;
  add_texture(from, PlainTexture::kBaseColor, TextureUse::kBaseColor, to);
  const bool plain = !to.texture(TextureUse::kBaseColor) && !colored;
  to.base_color = glm::vec4(plain ? linear(from.diffuse) : glm::vec3(1), from.opacity);
  to.metallic = std::max(from.metallic, 0.0f);
  to.perceptual_roughness =
      from.perceptual_roughness >= 0 ? from.perceptual_roughness : roughness_of(from.exponent);
  to.clearcoat = from.clearcoat;
  to.clearcoat_perceptual_roughness = from.clearcoat_perceptual_roughness;
  to.emissive = linear(from.emission);
  add_texture(from, PlainTexture::kEmissive, TextureUse::kEmissive, to);
  if (to.texture(TextureUse::kEmissive) && to.emissive == glm::vec3(0)) to.emissive = glm::vec3(1);

  const std::string_view alpha = model_.text_of(from.textures[std::size_t(PlainTexture::kAlpha)]);
  const bool own_alpha =
      textured && alpha == model_.text_of(from.textures[std::size_t(PlainTexture::kBaseColor)]);
  if (from.opacity < 1 || own_alpha) to.alpha_mode = AlphaMode::kBlend;
  if (!alpha.empty() && !own_alpha)
    tell_unused(from, PlainTexture::kAlpha, "is another file than map_Kd, whose alpha is all that is read");

  add_texture(from, PlainTexture::kNormal, TextureUse::kNormal, to);
  if (!to.texture(TextureUse::kNormal)) {
    add_texture(from, PlainTexture::kBump, TextureUse::kNormal, to);
  } else {
    tell_unused(from, PlainTexture::kBump, "stands beside a normal map and was left out");
  }
  tell_others(from);
  return to;
}

void MaterialMaker::tell_unused(const PlainMaterial& from, PlainTexture what, const char* why) {
  const std::string_view name = model_.text_of(from.textures[std::size_t(what)]);
  if (name.empty()) return;
  notes_.add("texture-ignored", mtl_place(model_.text_of(from.name), names_of(what).usual),
             fmt::format("\"{}\" {}", readable_text(name), why));
}

// A map_Ka that is the map_Kd says nothing more: exporters write both.
void MaterialMaker::tell_others(const PlainMaterial& from) {
  const std::string_view color = model_.text_of(from.textures[std::size_t(PlainTexture::kBaseColor)]);
  for (const MtlTexture& texture : statements_of(from)) {
    if (is_read(texture) || (lower(texture.statement) == "map_ka" && texture.name == color)) continue;
    notes_.add("texture-ignored", mtl_place(model_.text_of(from.name), texture.statement),
               fmt::format("\"{}\" has no counterpart and was left out", readable_text(texture.name)));
  }
}

std::span<const MtlTexture> MaterialMaker::statements_of(const PlainMaterial& from) const {
  const auto found = mtl_.materials.find(std::string(model_.text_of(from.name)));
  return found == mtl_.materials.end() ? std::span<const MtlTexture>() : found->second;
}

const MtlTexture* MaterialMaker::statement_of(const PlainMaterial& from, PlainTexture what) const {
  const MtlTexture* last = nullptr;
  for (const MtlTexture& texture : statements_of(from))
    if (is_of(texture, what)) last = &texture;
  return last;
}

void MaterialMaker::add_texture(const PlainMaterial& from, PlainTexture what, TextureUse use, Material& to) {
  const std::optional<int> image = image_of(from, what);
  if (!image) return;
  if (what == PlainTexture::kBump) {
    const auto [entry, fresh] = normal_maps_.try_emplace(*image, false);
    if (fresh) {
      try {
        const Blob& file = scene_.images[std::size_t(*image)].encoded;
        entry->second = looks_like_normal_map(
            decoder_.texture(file, ColorSpace::kNonColor, {}, deadline_).levels.front());
      } catch (const Error& error) {
        if (error.code == ErrorCode::kDeadlineExceeded) throw;
        notes_.add("image-unreadable", kModelPlace, error.message);
      }
    }
    if (!entry->second)
      return tell_unused(from, what, "is a map of heights, not of normals, and was left out");
  }
  TextureSlot slot;
  slot.image = *image;
  if (const MtlTexture* stated = statement_of(from, what)) {
    if (stated->clamps) slot.sampler.wrap_u = slot.sampler.wrap_v = Wrap::kClampToEdge;
    slot.transform.scale = stated->scale;
    // v points downwards here.
    slot.transform.offset = {stated->offset.x, 1 - stated->scale.y - stated->offset.y};
  }
  to.texture(use) = slot;
}

std::optional<int> MaterialMaker::image_of(const PlainMaterial& from, PlainTexture what) {
  const std::string_view written = model_.text_of(from.textures[std::size_t(what)]);
  if (written.empty()) return std::nullopt;
  const std::optional<std::string> name = sibling_name(written);
  const auto file = name ? bundle_.siblings.find(*name) : bundle_.siblings.end();
  if (file == bundle_.siblings.end()) {
    notes_.add("image-missing", mtl_place(model_.text_of(from.name), names_of(what).usual),
               fmt::format("there is no file \"{}\" beside the model; the slot stays empty",
                           readable_text(written)));
    return std::nullopt;
  }
  const auto [entry, fresh] = images_.try_emplace(*name, int(scene_.images.size()));
  if (fresh) scene_.images.push_back({file->second, kModelPlace});
  return entry->second;
}

}  // namespace furnace
