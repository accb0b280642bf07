// What the passes that draw surfaces bind alike: units, buffers, materials.
#pragma once

#include "renderer/frame/passes.hpp"
#include "renderer/gl/pass_state.hpp"

namespace furnace {

// A target of two samples a pixel each way, or of one.
enum class Grid { kPixels, kSamples };

gl::PassState tile_state(const PassContext& pass, const gl::Framebuffer& framebuffer, Grid grid);

// An equirect map, where every shader that reads one expects it.
void bind_sky(const PassContext& pass, const GpuTexture& sky);
// The sky, the atlas and the DFG table.
void bind_environment(const PassContext& pass);
// The tables of lobes, with the profiles of the scene's lights.
void bind_tables(gl::Context& context, Residency& residency, const GpuScene& scene);
// A texture whose texels are fetched one by one.
void bind_texels(gl::Context& context, Residency& residency, GLuint unit, const gl::Texture& texture);
// The shadow maps, as they are compared and as they are.
void bind_shadows(const PassContext& pass);
// What stands behind what is seen through.
void bind_backdrop(const PassContext& pass);
// The ground's shadow.
void bind_ground(const PassContext& pass);
// Of the shaders that draw shadows: none where only the place of the triangles counts.
gl::FeatureSet caster_features(const Draw& draw);
// The blocks and textures of a draw.
void bind_draw(const GpuScene& scene, const Draw& draw);
void bind_program(const PassContext& pass, const char* vertex, const char* fragment, gl::FeatureSet features);

// One triangle over the viewport, of a program without vertex attributes.
void draw_viewport(const gl::VertexArray& empty_vertex_array);
// The draw's mesh; culls `face`, or nothing for GL_NONE.
void draw_mesh(const Draw& draw, GLenum face, GLsizei instances = 1);
// Other triangles over the mesh's vertices, from both sides.
void draw_occluder(const Draw& draw, const GpuOccluder& occluder, GLsizei instances = 1);

}  // namespace furnace
