#include "renderer/scene/gltf_material.hpp"

#include <string>
#include <utility>

#include "renderer/image/decode.hpp"

namespace furnace {

int GltfMaterials::scene_material(std::optional<int> material) {
  const int key = material.value_or(-1);
  const auto known = materials_.find(key);
  if (known != materials_.end()) return known->second;
  const int index = static_cast<int>(scene_.materials.size());
  scene_.materials.push_back(material ? convert(document_.materials[static_cast<std::size_t>(*material)])
                                      : default_material());
  materials_.emplace(key, index);
  return index;
}

Material GltfMaterials::convert(const GltfMaterial& material) {
  for (const Note& note : material.notes) notes_.add(note.code, note.pointer, note.message);
  Material result = material.values;
  for (std::size_t use = 0; use < kTextureUses; ++use) result.textures[use] = convert(material.textures[use]);
  return result;
}

std::optional<TextureSlot> GltfMaterials::convert(const std::optional<GltfTextureRef>& ref) {
  if (!ref) return std::nullopt;
  if (ref->uv_set > 1) {
    notes_.add("uv-set-unsupported", ref->pointer, "samples TEXCOORD_2 or higher; the texture was left out");
    return std::nullopt;
  }
  const GltfTexture& texture = document_.textures[static_cast<std::size_t>(ref->texture)];
  for (const int candidate : texture.images) {
    if (const std::optional<int> image = scene_image(candidate))
      return TextureSlot{*image, ref->uv_set, texture.sampler, ref->transform};
  }
  if (texture.images.empty()) {
    notes_.add("texture-without-image", "/textures/" + std::to_string(ref->texture),
               "has no source that can be read; the texture was left out");
  }
  return std::nullopt;
}

std::optional<int> GltfMaterials::scene_image(int image) {
  const auto known = images_.find(image);
  if (known != images_.end()) return known->second;
  std::optional<int> index;
  if (std::optional<Blob> encoded = find_image(image)) {
    index = static_cast<int>(scene_.images.size());
    scene_.images.push_back({std::move(*encoded), "/images/" + std::to_string(image)});
  }
  images_.emplace(image, index);
  return index;
}

std::optional<Blob> GltfMaterials::find_image(int index) {
  const GltfImage& image = document_.images[static_cast<std::size_t>(index)];
  const std::string pointer = "/images/" + std::to_string(index);
  Blob encoded;
  if (image.buffer_view) {
    encoded = data_.view_blob(*image.buffer_view);
  } else if (is_data_uri(image.uri)) {
    encoded = Blob(decode_data_uri(image.uri, pointer + "/uri"));
  } else {
    const auto sibling = bundle_.siblings.find(decode_relative_uri(image.uri, pointer + "/uri"));
    if (sibling == bundle_.siblings.end()) {
      notes_.add("image-missing", pointer + "/uri", "the file " + image.uri + " is missing; it was left out");
      return std::nullopt;
    }
    encoded = sibling->second;
  }
  if (const std::optional<std::string> refusal = texture_refusal(encoded.bytes())) {
    notes_.add("image-unreadable", pointer,
               *refusal + "; it was left out, another source may stand in for it");
    return std::nullopt;
  }
  return encoded;
}

}  // namespace furnace
