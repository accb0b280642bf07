#include <algorithm>
#include <array>

#include "renderer/frame/draw_binding.hpp"
#include "renderer/frame/layer_binding.hpp"

namespace furnace {
namespace {

void bind(const PassContext& pass, const Draw& draw) {
  const GLuint program = pass.programs.request(
      pass.context, {"surface/forward.vert", "surface/forward.frag", shown_features(pass, draw.features)});
  set_shown(pass, program);
  glUseProgram(program);
  bind_draw(pass.scene, draw);
}

gl::PixelRect samples_of(const gl::PixelRect& pixels) {
  return {2 * pixels.x, 2 * pixels.y, 2 * pixels.width, 2 * pixels.height};
}

void draw_strokes(const PassContext& pass) {
  gl::PassState state = tile_state(pass, pass.targets.veil->framebuffer, Grid::kSamples);
  state.depth = gl::DepthUse::kTestAndWrite;
  state.scissor = samples_of(pass.veil);
  state.clear_color = glm::vec4(0);
  gl::begin_pass(pass.context, state);
  bind_environment(pass);
  for (const Draw& draw : pass.scene.strokes) {
    bind(pass, draw);
    draw_mesh(draw, GL_NONE);
  }
}

// Of each pixel, what the passes after this one need: so they fetch one texel and not four.
void gather_pixels(const PassContext& pass) {
  const gl::Framebuffer& framebuffer = pass.targets.veil->gather;
  constexpr GLuint kAll = 0xffffffffu;
  constexpr std::array<GLuint, 4> kNothing{0, 0, kAll, kAll};
  gl::PassState state = tile_state(pass, framebuffer, Grid::kPixels);
  gl::begin_pass(pass.context, state);
  glClearNamedFramebufferuiv(framebuffer.id(), GL_COLOR, 0, kNothing.data());
  state.scissor = pass.veil;
  gl::begin_pass(pass.context, state);
  bind_program(pass, "screen/fullscreen.vert", "visibility/veil.frag", 0);
  bind_texels(pass.context, pass.residency, 0, pass.targets.veil->color);
  draw_viewport(pass.empty_vertex_array);
}

}  // namespace

void pass_veil(const PassContext& pass) {
  if (!pass.veiled()) return;
  // Lines a pixel wide, where the context draws them two samples wide.
  glLineWidth(std::min(2.f, pass.context.limits().max_line_width));
  draw_strokes(pass);
  gl::PassState state = tile_state(pass, pass.targets.veil->framebuffer, Grid::kSamples);
  state.scissor = samples_of(pass.veil);
  state.depth = gl::DepthUse::kTest;
  state.blend = gl::Blend::kPremultiplied;
  gl::begin_pass(pass.context, state);
  bind_environment(pass);
  for (const Draw& draw : pass.scene.blended) {
    // What is nearer than any glass stands before it, not behind.
    if (pass.is_backdrop && draw.distance < pass.scene.nearest_glass_m) continue;
    bind(pass, draw);
    if (pass.scene.materials[std::size_t(draw.material)].double_sided && draw.mesh->mode == GL_TRIANGLES) {
      // The far side first: of a closed shape both sides then blend in order.
      draw_mesh(draw, GL_FRONT);
    }
    draw_mesh(draw, GL_BACK);
  }
  gather_pixels(pass);
}

}  // namespace furnace
