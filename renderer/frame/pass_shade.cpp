#include <algorithm>
#include <cmath>

#include "renderer/frame/draw_binding.hpp"

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

// A rectangle of the tile, px.
struct Rect {
  GLint x = 0, y = 0;
  GLsizei width = 0, height = 0;
};

// The pixels that a draw may cover: of its bounds' corners, or all where one lies behind the eye.
Rect covered_pixels(const PassContext& pass, const Draw& draw) {
  const Extent size = pass.tile.size;
  const glm::mat4 clip_from_model = pass.frame.clip_from_world * draw.world_from_model;
  const Bounds& bounds = draw.mesh->bounds;
  glm::vec2 low(1), high(-1);
  for (int corner = 0; corner < 8; ++corner) {
    const glm::vec3 at(corner & 1 ? bounds.max.x : bounds.min.x, corner & 2 ? bounds.max.y : bounds.min.y,
                       corner & 4 ? bounds.max.z : bounds.min.z);
    const glm::vec4 clip = clip_from_model * glm::vec4(at, 1);
    if (!(clip.w > 0) || clip.z > clip.w) return {0, 0, size.width, size.height};
    low = glm::min(low, glm::vec2(clip) / clip.w);
    high = glm::max(high, glm::vec2(clip) / clip.w);
  }
  low = glm::clamp(low, -1.f, 1.f);
  high = glm::clamp(high, -1.f, 1.f);
  // A pixel more on each side, for rounding.
  const auto pixel = [](float ndc, int length) { return int(std::floor((ndc + 1) * 0.5f * float(length))); };
  const int left = std::max(pixel(low.x, size.width) - 1, 0),
            right = std::min(pixel(high.x, size.width) + 2, size.width);
  const int top = std::max(pixel(-high.y, size.height) - 1, 0),
            bottom = std::min(pixel(-low.y, size.height) + 2, size.height);
  return {left, top, std::max(right - left, 0), std::max(bottom - top, 0)};
}

Rect joined(const Rect& a, const Rect& b) {
  if (a.width == 0 || a.height == 0) return b;
  if (b.width == 0 || b.height == 0) return a;
  const GLint x = std::min(a.x, b.x), y = std::min(a.y, b.y);
  return {x, y, std::max(a.x + a.width, b.x + b.width) - x, std::max(a.y + a.height, b.y + b.height) - y};
}

void limit_to(const Rect& rect) {
  glEnable(GL_SCISSOR_TEST);
  glScissor(rect.x, rect.y, rect.width, rect.height);
}

void find_shares(const PassContext& pass, const Rect& rect) {
  gl::PassState state = tile_state(pass, pass.targets.shading.share, Grid::kPixels);
  state.depth = gl::DepthUse::kWrite;
  gl::begin_pass(pass.context, state);
  limit_to(rect);
  bind_program(pass, "screen/fullscreen.vert", "visibility/shares.frag", 0);
  bind_texels(pass.context, pass.residency, 0, pass.targets.visibility.texels);
  bind_texels(pass.context, pass.residency, 1, pass.targets.visibility.depth);
  draw_viewport(pass.empty_vertex_array);
}

void select_draws(const PassContext& pass, const Rect& rect, GLuint layer) {
  gl::PassState state = tile_state(pass, pass.targets.shading.select, Grid::kPixels);
  state.depth = gl::DepthUse::kWrite;
  gl::begin_pass(pass.context, state);
  limit_to(rect);
  const GLuint program =
      pass.programs.request(pass.context, {"screen/fullscreen.vert", "visibility/select.frag", 0});
  glProgramUniform1ui(program, kLayerLocation, layer);
  glUseProgram(program);
  bind_texels(pass.context, pass.residency, 0, pass.targets.visibility.texels);
  bind_texels(pass.context, pass.residency, 1, pass.targets.shading.shares);
  draw_viewport(pass.empty_vertex_array);
}

void shade_layer(const PassContext& pass, const std::vector<Rect>& rects, GLuint layer) {
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
  if (veil) bind_texels(pass.context, pass.residency, kVeilUnit, pass.targets.veil->color);
  for (std::size_t i = 0; i < rects.size(); ++i) {
    if (rects[i].width == 0 || rects[i].height == 0) continue;
    const Draw& draw = pass.scene.deferred[i];
    limit_to(rects[i]);
    const gl::FeatureSet features = pass.shown(draw.features & ~gl::FeatureSet(gl::kFeatureAlphaMask)) | veil;
    const GLuint program =
        pass.programs.request(pass.context, {"surface/deferred.vert", "surface/deferred.frag", features});
    glProgramUniform1ui(program, kLayerLocation, layer);
    glUseProgram(program);
    bind_draw(pass.scene, draw);
    bind_texels(pass.context, pass.residency, kVerticesUnit, draw.mesh->vertex_texels);
    bind_texels(pass.context, pass.residency, kTrianglesUnit, draw.mesh->index_texels);
    draw_viewport(pass.empty_vertex_array);
  }
}

}  // namespace

void pass_shade(const PassContext& pass) {
  std::vector<Rect> rects;
  Rect all;
  for (const Draw& draw : pass.scene.deferred) {
    const bool drawn = !pass.is_backdrop || !draw.seen_through();
    rects.push_back(drawn ? covered_pixels(pass, draw) : Rect{});
    all = joined(all, rects.back());
  }
  find_shares(pass, all);
  for (GLuint layer = 0; layer < kSamplesPerPixel; ++layer) {
    if (layer > 0) select_draws(pass, all, layer);
    shade_layer(pass, rects, layer);
  }
}

}  // namespace furnace
