#include "renderer/gl/pass_state.hpp"

#include <algorithm>

#include <glm/gtc/type_ptr.hpp>

namespace furnace::gl {
namespace {

void set(GLenum capability, bool on) {
  on ? glEnable(capability) : glDisable(capability);
}

GLenum depth_function(DepthUse use) {
  if (use == DepthUse::kSelect) return GL_EQUAL;
  return use == DepthUse::kWrite ? GL_ALWAYS : GL_GEQUAL;
}

}  // namespace

PixelRect joined(const PixelRect& a, const PixelRect& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  const GLint x = std::min(a.x, b.x), y = std::min(a.y, b.y);
  return {x, y, std::max(a.x + a.width, b.x + b.width) - x, std::max(a.y + a.height, b.y + b.height) - y};
}

void begin_pass(Context&, const PassState& state) {
  glBindFramebuffer(GL_FRAMEBUFFER, state.framebuffer);
  glViewport(0, 0, state.viewport.width, state.viewport.height);
  // Row 0 of every target is the top of the picture; depth runs from 1 (near) to 0 (far).
  glClipControl(GL_UPPER_LEFT, GL_ZERO_TO_ONE);
  set(GL_SCISSOR_TEST, state.scissor.has_value());
  if (const auto& rect = state.scissor) glScissor(rect->x, rect->y, rect->width, rect->height);
  glDisable(GL_STENCIL_TEST);
  glDisable(GL_CULL_FACE);
  glDisable(GL_FRAMEBUFFER_SRGB);
  glDisable(GL_DITHER);
  glEnable(GL_PROGRAM_POINT_SIZE);
  set(GL_DEPTH_TEST, state.depth != DepthUse::kOff);
  glDepthFunc(depth_function(state.depth));
  glDepthMask(GL_TRUE);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  set(GL_BLEND, state.blend == Blend::kPremultiplied || state.blend == Blend::kAdd);
  set(GL_COLOR_LOGIC_OP, state.blend == Blend::kOr);
  glLogicOp(GL_OR);
  glBlendEquation(GL_FUNC_ADD);
  if (state.blend == Blend::kPremultiplied) glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  if (state.blend == Blend::kAdd) glBlendFunc(GL_ONE, GL_ONE);
  if (state.clear_color) {
    glClearNamedFramebufferfv(state.framebuffer, GL_COLOR, 0, glm::value_ptr(*state.clear_color));
  }
  constexpr float kFar = 0;
  if (state.clear_depth) glClearNamedFramebufferfv(state.framebuffer, GL_DEPTH, 0, &kFar);
  glDepthMask(state.depth == DepthUse::kTestAndWrite || state.depth == DepthUse::kWrite);
}

}  // namespace furnace::gl
