// What the passes that draw surfaces bind alike: units, buffers, materials.
#pragma once

#include "renderer/frame/passes.hpp"
#include "renderer/gl/pass_state.hpp"

namespace furnace {

// A target of two samples a pixel each way, or of one.
enum class Grid { kPixels, kSamples };

gl::PassState tile_state(const PassContext& pass, const gl::Framebuffer& framebuffer, Grid grid);

// The environment's own texture, where every shader that reads it expects it.
void bind_sky(const PassContext& pass);
// The sky, the atlas and the DFG table.
void bind_environment(const PassContext& pass);
// A texture whose texels are fetched one by one.
void bind_texels(const PassContext& pass, GLuint unit, const gl::Texture& texture);
// The blocks and textures of a draw.
void bind_draw(const PassContext& pass, const Draw& draw);
void bind_program(const PassContext& pass, const char* vertex, const char* fragment, gl::FeatureSet features);

// One triangle over the viewport, of a program without vertex attributes.
void draw_viewport(const PassContext& pass);
// The draw's mesh; culls `face`, or nothing for GL_NONE.
void draw_mesh(const Draw& draw, GLenum face);

}  // namespace furnace
