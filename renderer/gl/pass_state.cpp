#include "renderer/gl/pass_state.hpp"

#include <glm/gtc/type_ptr.hpp>

namespace furnace::gl {
namespace {

void set(GLenum capability, bool on) {
  on ? glEnable(capability) : glDisable(capability);
}

}  // namespace

void begin_pass(Context&, const PassState& state) {
  glBindFramebuffer(GL_FRAMEBUFFER, state.framebuffer);
  glViewport(state.viewport_x, state.viewport_y, state.viewport.width, state.viewport.height);
  // Row 0 of every target is the top of the picture; depth runs from 1 (near) to 0 (far).
  glClipControl(GL_UPPER_LEFT, GL_ZERO_TO_ONE);
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_STENCIL_TEST);
  glDisable(GL_CULL_FACE);
  glDisable(GL_FRAMEBUFFER_SRGB);
  glDisable(GL_DITHER);
  glEnable(GL_PROGRAM_POINT_SIZE);
  glEnable(GL_MULTISAMPLE);
  set(GL_SAMPLE_ALPHA_TO_COVERAGE, state.alpha_to_coverage);
  set(GL_DEPTH_TEST, state.depth != DepthUse::kOff);
  glDepthFunc(GL_GEQUAL);
  glDepthMask(GL_TRUE);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  set(GL_BLEND, state.blend != Blend::kOff);
  glBlendEquation(GL_FUNC_ADD);
  if (state.blend == Blend::kPremultiplied) glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  if (state.blend == Blend::kAdd) glBlendFunc(GL_ONE, GL_ONE);
  if (state.clear_color) {
    glClearNamedFramebufferfv(state.framebuffer, GL_COLOR, 0, glm::value_ptr(*state.clear_color));
  }
  constexpr float kFar = 0;
  if (state.clear_depth) glClearNamedFramebufferfv(state.framebuffer, GL_DEPTH, 0, &kFar);
  glDepthMask(state.depth == DepthUse::kTestAndWrite);
}

}  // namespace furnace::gl
