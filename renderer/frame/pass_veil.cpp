#include <algorithm>

#include "renderer/frame/draw_binding.hpp"

namespace furnace {
namespace {

void bind(const PassContext& pass, const Draw& draw) {
  bind_program(pass, "surface/forward.vert", "surface/forward.frag", pass.shown(draw.features));
  bind_draw(pass.scene, draw);
}

void draw_strokes(const PassContext& pass) {
  gl::PassState state = tile_state(pass, pass.targets.veil->framebuffer, Grid::kSamples);
  state.depth = gl::DepthUse::kTestAndWrite;
  state.clear_color = glm::vec4(0);
  gl::begin_pass(pass.context, state);
  bind_environment(pass);
  for (const Draw& draw : pass.scene.strokes) {
    bind(pass, draw);
    draw_mesh(draw, GL_NONE);
  }
}

}  // namespace

void pass_veil(const PassContext& pass) {
  if (!pass.veiled()) return;
  // Lines a pixel wide, where the context draws them two samples wide.
  glLineWidth(std::min(2.f, pass.context.limits().max_line_width));
  draw_strokes(pass);
  gl::PassState state = tile_state(pass, pass.targets.veil->framebuffer, Grid::kSamples);
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
}

}  // namespace furnace
