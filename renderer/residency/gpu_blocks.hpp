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
#include "shaders/interface/layer_block.glsl"
#include "shaders/interface/light_block.glsl"
#include "shaders/interface/material_block.glsl"
#include "shaders/interface/shown.glsl"
#include "shaders/interface/sky_block.glsl"

static_assert(sizeof(DrawBlock) % 16 == 0 && sizeof(FrameBlock) % 16 == 0 &&
              sizeof(MaterialBlock) % 16 == 0 && sizeof(GroundBlock) % 16 == 0 &&
              sizeof(LayerBlock) % 16 == 0 && sizeof(LightBlock) % 16 == 0 && sizeof(SkyBlock) % 16 == 0);

// The first uses are those of every material, with rows in MaterialBlock; the others are layers', with rows in LayerBlock.
inline constexpr std::size_t kCoreTextures = 5, kLayerTextures = kTextureUses - kCoreTextures;

MaterialBlock pack_material(const Material& material);
LayerBlock pack_layers(const Material& material);
// `key`, `vertex_rows`: see draw_block.glsl.
DrawBlock pack_draw(const glm::mat4& world_from_model, uint key, uint vertex_rows);

}  // namespace furnace::gpu
