#include "renderer/residency/draw_list.hpp"

#include <algorithm>
#include <cstring>

#include <fmt/format.h>

#include "renderer/base/error.hpp"

namespace furnace {
namespace {

GLintptr aligned(std::size_t size) {
  GLint alignment = 256;
  glGetIntegerv(GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT, &alignment);
  const auto step = std::size_t(std::max(alignment, 1));
  return GLintptr((size + step - 1) / step * step);
}

template <class Block>
gl::Buffer upload_blocks(gl::Context& context, const std::vector<Block>& blocks, GLintptr stride) {
  std::vector<std::byte> bytes(blocks.size() * std::size_t(stride));
  for (std::size_t i = 0; i < blocks.size(); ++i)
    std::memcpy(bytes.data() + i * std::size_t(stride), &blocks[i], sizeof(Block));
  return gl::create_buffer(context, bytes.data(), bytes.size());
}

gl::FeatureSet layer_features(const Material& material) {
  gl::FeatureSet features = 0;
  if (material.specular_glossiness) {
    features |= gl::kFeatureGlossy;
  } else if (material.ior != 1.5f || material.specular != 1 || material.specular_color != glm::vec3(1) ||
             material.texture(TextureUse::kSpecular) || material.texture(TextureUse::kSpecularColor)) {
    features |= gl::kFeatureSpecular;
  }
  if (material.model == ShadingModel::kSchlickBeckmann) features |= gl::kFeatureSchlickBeckmann;
  if (material.model == ShadingModel::kBlinnPhong || material.model == ShadingModel::kPhong)
    features |= gl::kFeaturePhong;
  if (material.model == ShadingModel::kPbr) {
    if (material.anisotropy > 0) features |= gl::kFeatureAnisotropy;
    if (material.iridescence > 0) features |= gl::kFeatureIridescence;
  }
  if (material.clearcoat > 0) {
    features |= gl::kFeatureClearcoat;
    if (material.texture(TextureUse::kClearcoatNormal)) features |= gl::kFeatureCoatNormalMap;
  }
  if (material.sheen_color != glm::vec3(0)) features |= gl::kFeatureSheen;
  if (material.diffuse_transmission > 0) features |= gl::kFeatureDiffuseTransmission;
  if (material.transmission > 0) features |= gl::kFeatureTransmission;
  const auto first = material.textures.begin() + gpu::kCoreTextures;
  if (std::any_of(first, material.textures.end(), [](const auto& slot) { return slot.has_value(); }))
    features |= gl::kFeatureLayerMaps;
  return features;
}

// `roughness_map`: of the metallic-roughness slot, or null.
gl::FeatureSet material_features(const Material& material, const GpuTexture* roughness_map,
                                 double first_level_roughness) {
  gl::FeatureSet features = 0;
  if (material.alpha_mode == AlphaMode::kMask) features |= gl::kFeatureAlphaMask;
  if (material.alpha_mode == AlphaMode::kBlend) features |= gl::kFeatureAlphaBlend;
  if (material.texture(TextureUse::kBaseColor) || material.texture(TextureUse::kMetallicRoughness) ||
      material.texture(TextureUse::kOcclusion)) {
    features |= gl::kFeatureMaterialMaps;
  }
  if (material.texture(TextureUse::kOcclusion) &&
      material.texture(TextureUse::kOcclusion) == material.texture(TextureUse::kMetallicRoughness)) {
    features |= gl::kFeaturePackedOcclusion;
  }
  if (material.texture(TextureUse::kEmissive)) features |= gl::kFeatureEmissiveMap;
  if (material.unlit) return features | gl::kFeatureUnlit;
  if (material.texture(TextureUse::kNormal)) features |= gl::kFeatureNormalMap;
  float lowest = material.perceptual_roughness * (roughness_map != nullptr ? roughness_map->lowest_green : 1);
  if (material.specular_glossiness) lowest = 1 - material.glossiness;
  if (material.clearcoat > 0) {
    const bool mapped = material.texture(TextureUse::kClearcoatRoughness).has_value();
    lowest = std::min(lowest, mapped ? 0 : material.clearcoat_perceptual_roughness);
  }
  if (double(lowest) < first_level_roughness) features |= gl::kFeatureSharpReflection;
  return features | layer_features(material);
}

// The size of every texture of the material, if they share it and are all read at the same place.
std::optional<Extent> common_map_size(const Material& material,
                                      const std::vector<const GpuTexture*>& textures) {
  std::optional<Extent> size;
  for (const auto& map : material.textures) {
    if (!map) continue;
    const Extent extent = textures[std::size_t(map->image)]->extent;
    if (map->uv_set != 0 || map->transform != UvTransform{} || (size && *size != extent)) return std::nullopt;
    size = extent;
  }
  return size;
}

gl::FeatureSet light_features(const std::vector<Light>& lights) {
  gl::FeatureSet features = lights.empty() ? 0 : gl::FeatureSet(gl::kFeatureLights);
  for (const Light& light : lights) {
    if (light.is_surface()) features |= gl::kFeatureSurfaceLights;
    if (light.profile != nullptr) features |= gl::kFeatureLightProfiles;
  }
  return features;
}

constexpr gl::FeatureSet kNeedsTangents =
    gl::kFeatureNormalMap | gl::kFeatureCoatNormalMap | gl::kFeatureAnisotropy;

}  // namespace

bool make_gpu_scene(gl::Context& context, Residency& residency, const PreparedScene& scene, const View& view,
                    GpuScene& out) {
  out.environment = residency.environment(*scene.environment);
  out.sky = residency.sky(scene.environment->sky);
  out.lobe_tables = residency.lobe_tables(scene.lights);
  if (scene.background != nullptr) out.background = residency.sky(*scene.background);
  if (scene.ground && scene.ground->shadow_key) {
    out.ground_shadow = residency.find_ground_shadow(*scene.ground->shadow_key);
    if (out.ground_shadow == nullptr && scene.ground->light == nullptr) return false;
  }

  std::vector<const GpuTexture*> textures;
  for (const PreparedTexture& texture : scene.textures) {
    textures.push_back(residency.texture(texture));
    if (textures.back() == nullptr) return false;
  }

  std::vector<gpu::MaterialBlock> material_blocks;
  std::vector<gpu::LayerBlock> layer_blocks;
  for (const Material& material : scene.materials) {
    GpuMaterial gpu_material;
    for (std::size_t use = 0; use < kTextureUses; ++use) {
      const auto& slot = material.textures[use];
      gpu_material.textures[use] =
          slot ? textures[std::size_t(slot->image)]->texture.id() : residency.neutral_texture();
      gpu_material.samplers[use] = residency.samplers().get(context, slot ? slot->sampler : SamplerDesc{});
    }
    const auto& roughness_slot = material.texture(TextureUse::kMetallicRoughness);
    const GpuTexture* roughness_map = roughness_slot ? textures[std::size_t(roughness_slot->image)] : nullptr;
    gpu_material.features =
        material_features(material, roughness_map, scene.environment->atlas.level_roughness.front());
    gpu_material.alpha_mode = material.alpha_mode;
    gpu_material.double_sided = material.double_sided;
    gpu_material.layered = !material.unlit && layer_features(material) != 0;
    material_blocks.push_back(gpu::pack_material(material));
    layer_blocks.push_back(gpu::pack_layers(material));
    if (const std::optional<Extent> size = common_map_size(material, textures)) {
      gpu_material.features |= gl::kFeatureAlignedMaps;
      material_blocks.back().map_width = float(size->width);
      material_blocks.back().map_height = float(size->height);
    }
    out.materials.push_back(gpu_material);
  }

  const gl::FeatureSet lights = light_features(scene.lights);
  std::vector<gpu::DrawBlock> draw_blocks;
  constexpr std::size_t kMostDraws = (1u << 18) - 1;  // keys of lib/visibility.glsl
  if (scene.instances.size() > kMostDraws) {
    fail(ErrorCode::kTooLarge,
         fmt::format("{} drawn parts are more than one frame takes ({}); join meshes of equal material",
                     scene.instances.size(), kMostDraws));
  }
  for (const Instance& instance : scene.instances) {
    const PreparedMesh& mesh = scene.meshes[std::size_t(instance.mesh)];
    const GpuMaterial& material = out.materials[std::size_t(instance.material)];
    Draw draw;
    draw.mesh = residency.mesh(mesh);
    if (draw.mesh == nullptr) return false;
    if (!scene.sky_lights.empty() && mesh.mesh->topology == Topology::kTriangles) {
      draw.occluder = residency.occluder(mesh);
      if (draw.occluder == nullptr) return false;
    }
    draw.source_mesh = instance.mesh;
    draw.material = instance.material;
    draw.block = int(draw_blocks.size());
    draw.world_from_model = instance.world_from_model;
    draw.features = material.features;
    // glTF 2.0, 3.7.2.1: points and lines without normals are not lit.
    if (mesh.mesh->normals.empty()) draw.features |= gl::kFeatureUnlit;
    if (mesh.mesh->tangents.empty()) draw.features &= ~kNeedsTangents;
    const bool triangles = mesh.mesh->topology == Topology::kTriangles;
    if (!triangles) draw.features &= ~gl::FeatureSet(gl::kFeatureTransmission);
    draw.features |= lights;
    if (draw.features & gl::kFeatureUnlit) {
      draw.features &= gl::kFeatureAlphaMask | gl::kFeatureAlphaBlend | gl::kFeatureUnlit |
                       gl::kFeatureMaterialMaps | gl::kFeaturePackedOcclusion | gl::kFeatureAlignedMaps |
                       gl::kFeatureEmissiveMap;
    }
    if (!mesh.mesh->colors.empty()) draw.features |= gl::kFeatureVertexColor;
    draw.key = std::uint32_t(draw_blocks.size() + 1);
    draw_blocks.push_back(gpu::pack_draw(instance.world_from_model, draw.key, draw.mesh->vertex_rows));
    draw.mirrored = draw_blocks.back().handedness < 0;
    const glm::vec3 centre = (mesh.mesh->bounds.min + mesh.mesh->bounds.max) * 0.5f;
    draw.distance = glm::distance(view.eye, glm::vec3(instance.world_from_model * glm::vec4(centre, 1)));
    if (draw.seen_through())
      out.nearest_glass_m = std::min(out.nearest_glass_m.value_or(draw.distance), draw.distance);
    if (material.alpha_mode == AlphaMode::kBlend && !draw.seen_through()) {
      out.blended.push_back(draw);
    } else {
      (triangles ? out.deferred : out.strokes).push_back(draw);
    }
  }
  // Stable: equal distances keep the document's order.
  std::stable_sort(out.deferred.begin(), out.deferred.end(),
                   [](const Draw& a, const Draw& b) { return a.distance < b.distance; });
  std::stable_sort(out.blended.begin(), out.blended.end(),
                   [](const Draw& a, const Draw& b) { return a.distance > b.distance; });

  out.draw_stride = aligned(sizeof(gpu::DrawBlock));
  out.material_stride = aligned(sizeof(gpu::MaterialBlock));
  out.draw_blocks = upload_blocks(context, draw_blocks, out.draw_stride);
  out.material_blocks = upload_blocks(context, material_blocks, out.material_stride);
  out.layer_stride = aligned(sizeof(gpu::LayerBlock));
  out.layer_blocks = upload_blocks(context, layer_blocks, out.layer_stride);
  return true;
}

}  // namespace furnace
