// The C++ view of shaders/interface: one text for both compilers, and the only bridge from meaning to layout.
#pragma once

#include <cstdint>
#include <optional>

#include <glm/glm.hpp>

#include "renderer/scene/material.hpp"
#include "renderer/scene/scene.hpp"

namespace furnace::gpu {

using glm::mat4;
using glm::vec4;
using uint = std::uint32_t;

#include "shaders/interface/draw_block.glsl"
#include "shaders/interface/frame_block.glsl"
#include "shaders/interface/ground_block.glsl"
#include "shaders/interface/light_block.glsl"
#include "shaders/interface/material_block.glsl"

static_assert(sizeof(DrawBlock) % 16 == 0 && sizeof(FrameBlock) % 16 == 0 &&
              sizeof(MaterialBlock) % 16 == 0 && sizeof(GroundBlock) % 16 == 0 &&
              sizeof(LightBlock) % 16 == 0);

// Texture slots in the order of MaterialBlock::uv_rows and of the shaders' bindings.
enum Slot { kBaseColor, kMetallicRoughness, kNormal, kOcclusion, kEmissive, kSlotCount };

inline constexpr std::optional<TextureSlot> Material::*kMaterialSlots[kSlotCount] = {
    &Material::base_color_texture, &Material::metallic_roughness_texture, &Material::normal_texture,
    &Material::occlusion_texture, &Material::emissive_texture};

MaterialBlock pack_material(const Material& material);
// `key`, `vertex_rows`: see draw_block.glsl.
DrawBlock pack_draw(const glm::mat4& world_from_model, uint key, uint vertex_rows);

}  // namespace furnace::gpu
