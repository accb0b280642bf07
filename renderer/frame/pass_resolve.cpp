#include "renderer/frame/passes.hpp"
#include "renderer/gl/pass_state.hpp"

namespace furnace {
namespace {

// Numbers of screen/resolve.frag.
enum ToneCurve : GLuint { kCurvePbrNeutral = 0, kCurveClip = 1, kCurveSceneLinear = 2 };

ToneCurve tone_curve(const FramePlan& plan) {
  if (plan.film_type != SampleType::kUint8) return kCurveSceneLinear;
  return plan.tone_map == ToneMap::kPbrNeutral ? kCurvePbrNeutral : kCurveClip;
}

gl::PassState screen_state(const PassContext& pass, const gl::Framebuffer& framebuffer) {
  gl::PassState state;
  state.framebuffer = framebuffer.id();
  state.viewport_x = -pass.tile.x;
  state.viewport_y = -pass.tile.y;
  state.viewport = pass.plan.picture;
  return state;
}

void draw_screen(const PassContext& pass, const gl::Texture& source) {
  glBindTextureUnit(0, source.id());
  glBindSampler(0, 0);
  glBindVertexArray(pass.empty_vertex_array.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

bool is_lone(const FramePlan& plan) {
  return plan.jitter_px.size() == 1;
}

// `composes`: this pass is the first to read the sub-frame, so it averages the samples and puts the sky behind them.
GLuint screen_program(const PassContext& pass, const char* fragment, bool composes) {
  gl::FeatureSet features = 0;
  if (composes && pass.plan.msaa_samples > 1) features |= gl::kFeatureMultisampled;
  if (composes && pass.plan.background == BackgroundKind::kEnvironment) {
    features |= gl::kFeatureSky;
    if (pass.sky_lod < 0) features |= gl::kFeatureMagnified;
    bind_sky(pass);
  }
  return pass.programs.request(pass.context, {"screen/fullscreen.vert", fragment, features});
}

}  // namespace

void pass_accumulate(const PassContext& pass, bool first) {
  if (is_lone(pass.plan)) return;
  gl::PassState state = screen_state(pass, pass.targets.accumulate);
  state.blend = first ? gl::Blend::kOff : gl::Blend::kAdd;
  gl::begin_pass(pass.context, state);
  const GLuint program = screen_program(pass, "screen/accumulate.frag", true);
  glProgramUniform1f(program, 0, 1.f / float(pass.plan.jitter_px.size()));
  glUseProgram(program);
  draw_screen(pass, pass.targets.color);
}

void pass_resolve(const PassContext& pass) {
  gl::begin_pass(pass.context, screen_state(pass, pass.targets.resolve));
  const bool lone = is_lone(pass.plan);
  const GLuint program = screen_program(pass, "screen/resolve.frag", lone);
  constexpr float kLargestHalf = 65504, kLargestFloat = 3.4e38f;
  glProgramUniform1f(program, 0, float(pass.plan.exposure));
  glProgramUniform1ui(program, 1, tone_curve(pass.plan));
  glProgramUniform1f(program, 2, pass.plan.film_type == SampleType::kFloat16 ? kLargestHalf : kLargestFloat);
  glUseProgram(program);
  draw_screen(pass, lone ? pass.targets.color : pass.targets.accumulated);
}

}  // namespace furnace
