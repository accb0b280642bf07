#include <array>

#include "renderer/frame/draw_binding.hpp"

namespace furnace {

void pass_visibility(const PassContext& pass) {
  const gl::Framebuffer& framebuffer = pass.targets.visibility.framebuffer;
  gl::PassState state = tile_state(pass, framebuffer, Grid::kSamples);
  state.depth = gl::DepthUse::kTestAndWrite;
  state.clear_depth = true;
  gl::begin_pass(pass.context, state);
  constexpr std::array<GLuint, 4> kNothing{};
  glClearNamedFramebufferuiv(framebuffer.id(), GL_COLOR, 0, kNothing.data());
  for (const Draw& draw : pass.scene.deferred) {
    if (pass.is_backdrop && draw.seen_through()) continue;
    const gl::FeatureSet masking = gl::kFeatureAlphaMask | gl::kFeatureMaterialMaps;
    const bool masked = (draw.features & gl::kFeatureAlphaMask) != 0;
    bind_program(pass, "visibility/visibility.vert", "visibility/visibility.frag",
                 masked ? draw.features & masking : 0);
    bind_draw(pass.scene, draw);
    draw_mesh(draw, pass.scene.materials[std::size_t(draw.material)].double_sided ? GL_NONE : GL_BACK);
  }
}

}  // namespace furnace
