#include "renderer/frame/covered_pixels.hpp"
#include "renderer/frame/draw_binding.hpp"
#include "renderer/frame/layer_binding.hpp"

namespace furnace {
namespace {

constexpr GLuint kLayerLocation = 0;
constexpr GLuint kSamplesPerPixel = 4;
enum Unit : GLuint {
  kVisibilityUnit = 8,
  kSharesUnit = 9,
  kVerticesUnit = 10,
  kTrianglesUnit = 11,
  kVeilUnit = 12
};

void select_draws(const PassContext& pass, const gl::PixelRect& rect, GLuint layer) {
  gl::PassState state = tile_state(pass, pass.targets.shading.select, Grid::kPixels);
  state.depth = gl::DepthUse::kWrite;
  state.scissor = rect;
  gl::begin_pass(pass.context, state);
  const GLuint program =
      pass.programs.request(pass.context, {"screen/fullscreen.vert", "visibility/select.frag", 0});
  glProgramUniform1ui(program, kLayerLocation, layer);
  glUseProgram(program);
  bind_texels(pass.context, pass.residency, 0, pass.targets.visibility.texels);
  bind_texels(pass.context, pass.residency, 1, pass.targets.shading.shares);
  draw_viewport(pass.empty_vertex_array);
}

void shade_layer(const PassContext& pass, const std::vector<gl::PixelRect>& rects, GLuint layer) {
  gl::PassState state = tile_state(pass, pass.targets.shading.shade, Grid::kPixels);
  state.depth = gl::DepthUse::kSelect;
  if (layer == 0) state.clear_color = glm::vec4(0);
  // The first layer is added too: with one state drivers compile a shader once.
  state.blend = gl::Blend::kAdd;
  gl::begin_pass(pass.context, state);
  bind_environment(pass);
  bind_backdrop(pass);
  bind_texels(pass.context, pass.residency, kVisibilityUnit, pass.targets.visibility.texels);
  bind_texels(pass.context, pass.residency, kSharesUnit, pass.targets.shading.shares);
  const gl::FeatureSet veil = pass.veiled() ? gl::FeatureSet(gl::kFeatureVeil) : 0;
  if (veil) bind_texels(pass.context, pass.residency, kVeilUnit, pass.targets.veil->pixels);
  for (std::size_t i = 0; i < rects.size(); ++i) {
    if (rects[i].empty()) continue;
    const Draw& draw = pass.scene.deferred[i];
    glEnable(GL_SCISSOR_TEST);
    glScissor(rects[i].x, rects[i].y, rects[i].width, rects[i].height);
    const gl::FeatureSet features =
        shown_features(pass, draw.features & ~gl::FeatureSet(gl::kFeatureAlphaMask)) | veil;
    const GLuint program =
        pass.programs.request(pass.context, {"surface/deferred.vert", "surface/deferred.frag", features});
    glProgramUniform1ui(program, kLayerLocation, layer);
    set_shown(pass, program);
    glUseProgram(program);
    bind_draw(pass.scene, draw);
    bind_texels(pass.context, pass.residency, kVerticesUnit, draw.mesh->vertex_texels);
    bind_texels(pass.context, pass.residency, kTrianglesUnit, draw.mesh->index_texels);
    draw_viewport(pass.empty_vertex_array);
  }
}

}  // namespace

void pass_shade(const PassContext& pass) {
  std::vector<gl::PixelRect> rects;
  gl::PixelRect all;
  for (const Draw& draw : pass.scene.deferred) {
    rects.push_back(pass.draws(draw) ? covered_pixels(pass.frame, pass.tile.size, draw) : gl::PixelRect{});
    all = joined(all, rects.back());
  }
  for (GLuint layer = 0; layer < kSamplesPerPixel; ++layer) {
    if (layer > 0 || !pass.first_is_selected) select_draws(pass, all, layer);
    shade_layer(pass, rects, layer);
  }
}

}  // namespace furnace
