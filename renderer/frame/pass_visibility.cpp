#include <array>

#include "renderer/base/content_hash.hpp"
#include "renderer/frame/covered_pixels.hpp"
#include "renderer/frame/draw_binding.hpp"

namespace furnace {
namespace {

GLenum culled_face(const PassContext& pass, const Draw& draw) {
  return pass.scene.materials[std::size_t(draw.material)].double_sided ? GL_NONE : GL_BACK;
}

bool is_masked(const Draw& draw) {
  return (draw.features & gl::kFeatureAlphaMask) != 0;
}

template <class T>
std::span<const std::byte> bytes_of(const T& value) {
  return std::as_bytes(std::span(&value, 1));
}

void find_visible(const PassContext& pass) {
  const gl::Framebuffer& framebuffer = pass.targets.visibility.framebuffer;
  gl::PassState state = tile_state(pass, framebuffer, Grid::kSamples);
  state.depth = gl::DepthUse::kTestAndWrite;
  state.clear_depth = true;
  gl::begin_pass(pass.context, state);
  constexpr std::array<GLuint, 4> kNothing{};
  glClearNamedFramebufferuiv(framebuffer.id(), GL_COLOR, 0, kNothing.data());
  for (const Draw& draw : pass.scene.deferred) {
    if (!pass.draws(draw)) continue;
    const gl::FeatureSet masking = gl::kFeatureAlphaMask | gl::kFeatureMaterialMaps;
    bind_program(pass, "visibility/visibility.vert", "visibility/visibility.frag",
                 is_masked(draw) ? draw.features & masking : 0);
    bind_draw(pass.scene, draw);
    draw_mesh(draw, culled_face(pass, draw));
  }
}

void find_shares(const PassContext& pass, VisibleSurfaces surfaces) {
  gl::PassState state = tile_state(pass, pass.targets.shading.share, Grid::kPixels);
  gl::PixelRect covered;
  for (const Draw& draw : pass.scene.deferred) {
    if (pass.draws(draw)) covered = joined(covered, covered_pixels(pass.frame, pass.tile.size, draw));
  }
  state.depth = gl::DepthUse::kWrite;
  state.scissor = covered;
  gl::begin_pass(pass.context, state);
  const bool nearest = surfaces == VisibleSurfaces::kNearest;
  bind_program(pass, "screen/fullscreen.vert", "visibility/shares.frag",
               nearest ? gl::FeatureSet(gl::kFeatureNearest) : 0);
  bind_texels(pass.context, pass.residency, 0, pass.targets.visibility.texels);
  bind_texels(pass.context, pass.residency, 1, pass.targets.visibility.depth);
  draw_viewport(pass.empty_vertex_array);
}

}  // namespace

std::optional<ContentHash> visibility_key(const PassContext& pass, const PreparedScene& prepared) {
  if (!pass.scene.strokes.empty()) return std::nullopt;  // the veil writes their depth over the triangles'
  HashBuilder key;
  key.add(bytes_of(pass.frame.clip_from_world)).add(bytes_of(pass.frame.depth_tolerance));
  key.add(std::int64_t(pass.is_backdrop));
  for (const Draw& draw : pass.scene.deferred) {
    if (is_masked(draw)) return std::nullopt;
    key.add(prepared.meshes[std::size_t(draw.source_mesh)].key).add(bytes_of(draw.world_from_model));
    key.add(std::int64_t(draw.key)).add(std::int64_t(culled_face(pass, draw)));
    key.add(std::int64_t(pass.draws(draw)));
  }
  return key.finish();
}

void pass_visibility(const PassContext& pass, VisibleSurfaces surfaces) {
  find_visible(pass);
  find_shares(pass, surfaces);
}

}  // namespace furnace
