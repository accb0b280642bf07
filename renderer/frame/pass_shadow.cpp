#include "renderer/frame/draw_binding.hpp"

namespace furnace {
namespace {

void draw_casters(const PassContext& pass, const glm::mat4& clip_from_world, const std::vector<Draw>& draws,
                  Casters casters) {
  for (const Draw& draw : draws) {
    if (draw.mesh->mode != GL_TRIANGLES) continue;
    const gl::FeatureSet features = caster_features(draw);
    const GLuint program =
        pass.programs.request(pass.context, {"shadow/depth.vert", "shadow/depth.frag", features});
    glProgramUniformMatrix4fv(program, 0, 1, GL_FALSE, &clip_from_world[0][0]);
    glUseProgram(program);
    bind_draw(pass.scene, draw);
    if (features == 0 && casters == Casters::kSimplified) {
      draw_occluder(draw, *draw.occluder);
    } else {
      draw_mesh(draw, GL_NONE);
    }
  }
}

}  // namespace

void pass_shadow(const PassContext& pass, std::span<const glm::mat4> clip_from_world, int first_layer,
                 Casters casters) {
  const ShadowTarget& target = *pass.targets.shadows;
  for (std::size_t view = 0; view < clip_from_world.size(); ++view) {
    glNamedFramebufferTextureLayer(target.framebuffer.id(), GL_DEPTH_ATTACHMENT, target.maps.id(), 0,
                                   first_layer + GLint(view));
    gl::PassState state;
    state.framebuffer = target.framebuffer.id();
    state.viewport = {target.side_px, target.side_px};
    state.depth = gl::DepthUse::kTestAndWrite;
    state.clear_depth = true;
    gl::begin_pass(pass.context, state);
    if (casters == Casters::kExact) {
      // A surface that the light grazes falls by more than a texel's depth within it.
      glEnable(GL_POLYGON_OFFSET_FILL);
      glPolygonOffset(-1.5f, -2.f);
    }
    draw_casters(pass, clip_from_world[view], pass.scene.deferred, casters);
    draw_casters(pass, clip_from_world[view], pass.scene.blended, casters);
    glDisable(GL_POLYGON_OFFSET_FILL);
  }
}

}  // namespace furnace
