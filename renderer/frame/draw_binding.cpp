#include "renderer/frame/draw_binding.hpp"

namespace furnace {
namespace {

constexpr GLuint kDrawBinding = 1, kMaterialBinding = 2, kLayerBinding = 5;
constexpr GLuint kSkyUnit = 5, kAtlasUnit = 6, kTablesUnit = 7, kGroundUnit = 13, kSkySumsUnit = 13,
                 kShadowUnit = 14, kShadowDepthUnit = 15, kLayerUnit = 16, kBackdropUnit = 30,
                 kBehindUnit = 31;
constexpr GLuint kColorLocation = 5;

constexpr SamplerDesc kSkySampler{Wrap::kRepeat, Wrap::kClampToEdge, Filter::kLinear, Filter::kLinear,
                                  MipFilter::kLinear};
constexpr SamplerDesc kClampedSampler{Wrap::kClampToEdge, Wrap::kClampToEdge, Filter::kLinear,
                                      Filter::kLinear, MipFilter::kLinear};
constexpr SamplerDesc kTableSampler{Wrap::kClampToEdge, Wrap::kClampToEdge, Filter::kLinear, Filter::kLinear,
                                    MipFilter::kNone};
// Integer textures are complete only so.
constexpr SamplerDesc kTexelSampler{Wrap::kClampToEdge, Wrap::kClampToEdge, Filter::kNearest,
                                    Filter::kNearest, MipFilter::kNone};

}  // namespace

gl::PassState tile_state(const PassContext& pass, const gl::Framebuffer& framebuffer, Grid grid) {
  const int per_pixel = grid == Grid::kSamples ? 2 : 1;
  gl::PassState state;
  state.framebuffer = framebuffer.id();
  state.viewport = {per_pixel * pass.tile.size.width, per_pixel * pass.tile.size.height};
  return state;
}

void bind_sky(const PassContext& pass, const GpuTexture& sky) {
  glBindTextureUnit(kSkyUnit, sky.texture.id());
  glBindSampler(kSkyUnit, pass.residency.samplers().get(pass.context, kSkySampler));
}

void bind_environment(const PassContext& pass) {
  bind_shadows(pass);
  bind_sky(pass, *pass.scene.sky);
  gl::SamplerCache& samplers = pass.residency.samplers();
  glBindTextureUnit(kAtlasUnit, pass.scene.environment->atlas.id());
  glBindSampler(kAtlasUnit, samplers.get(pass.context, kTableSampler));
  bind_tables(pass.context, pass.residency, pass.scene);
  if (pass.sky_sums == nullptr) return;
  glBindTextureUnit(kSkySumsUnit, pass.sky_sums->id());
  glBindSampler(kSkySumsUnit, samplers.get(pass.context, kTableSampler));
}

void bind_tables(gl::Context& context, Residency& residency, const GpuScene& scene) {
  glBindTextureUnit(kTablesUnit, scene.lobe_tables->texture.id());
  glBindSampler(kTablesUnit, residency.samplers().get(context, kTableSampler));
}

void bind_texels(gl::Context& context, Residency& residency, GLuint unit, const gl::Texture& texture) {
  glBindTextureUnit(unit, texture.id());
  glBindSampler(unit, residency.samplers().get(context, kTexelSampler));
}

void bind_shadows(const PassContext& pass) {
  if (!pass.targets.shadows) return;
  glBindTextureUnit(kShadowUnit, pass.targets.shadows->maps.id());
  glBindSampler(kShadowUnit, 0);
  bind_texels(pass.context, pass.residency, kShadowDepthUnit, pass.targets.shadows->maps);
}

void bind_ground(const PassContext& pass) {
  glBindTextureUnit(kGroundUnit, pass.scene.ground_shadow->texture.id());
  glBindSampler(kGroundUnit, pass.residency.samplers().get(pass.context, kClampedSampler));
}

void bind_backdrop(const PassContext& pass) {
  if (!pass.targets.backdrop || pass.is_backdrop) return;
  gl::SamplerCache& samplers = pass.residency.samplers();
  glBindTextureUnit(kBackdropUnit, pass.targets.backdrop->color.id());
  glBindSampler(kBackdropUnit, samplers.get(pass.context, kClampedSampler));
  glBindTextureUnit(kBehindUnit, pass.scene.background != nullptr ? pass.scene.background->texture.id()
                                                                  : pass.residency.neutral_texture());
  glBindSampler(kBehindUnit, samplers.get(pass.context, kSkySampler));
}

gl::FeatureSet caster_features(const Draw& draw) {
  constexpr gl::FeatureSet kOpacity = gl::kFeatureAlphaMask | gl::kFeatureAlphaBlend;
  gl::FeatureSet features = draw.features & kOpacity;
  if (draw.seen_through()) features |= gl::kFeatureAlphaBlend;
  return features == 0 ? 0 : features | (draw.features & gl::kFeatureMaterialMaps);
}

void bind_draw(const GpuScene& scene, const Draw& draw) {
  const GpuMaterial& material = scene.materials[std::size_t(draw.material)];
  glBindBufferRange(GL_UNIFORM_BUFFER, kDrawBinding, scene.draw_blocks.id(), draw.block * scene.draw_stride,
                    sizeof(gpu::DrawBlock));
  glBindBufferRange(GL_UNIFORM_BUFFER, kMaterialBinding, scene.material_blocks.id(),
                    draw.material * scene.material_stride, sizeof(gpu::MaterialBlock));
  glBindTextures(0, gpu::kCoreTextures, material.textures.data());
  glBindSamplers(0, gpu::kCoreTextures, material.samplers.data());
  if (!material.layered) return;
  glBindBufferRange(GL_UNIFORM_BUFFER, kLayerBinding, scene.layer_blocks.id(),
                    draw.material * scene.layer_stride, sizeof(gpu::LayerBlock));
  glBindTextures(kLayerUnit, gpu::kLayerTextures, material.textures.data() + gpu::kCoreTextures);
  glBindSamplers(kLayerUnit, gpu::kLayerTextures, material.samplers.data() + gpu::kCoreTextures);
}

void bind_program(const PassContext& pass, const char* vertex, const char* fragment,
                  gl::FeatureSet features) {
  glUseProgram(pass.programs.request(pass.context, {vertex, fragment, features}));
}

void draw_viewport(const gl::VertexArray& empty_vertex_array) {
  glBindVertexArray(empty_vertex_array.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

void draw_mesh(const Draw& draw, GLenum face, GLsizei instances) {
  if (face == GL_NONE) {
    glDisable(GL_CULL_FACE);
  } else {
    glEnable(GL_CULL_FACE);
    glCullFace(face);
  }
  // GL reverses the sense of winding itself when the clip origin is the upper left.
  glFrontFace(draw.mirrored ? GL_CW : GL_CCW);
  glVertexAttrib4f(kColorLocation, 1, 1, 1, 1);
  glBindVertexArray(draw.mesh->vertex_array.id());
  glDrawElementsInstanced(draw.mesh->mode, draw.mesh->index_count, GL_UNSIGNED_INT, nullptr, instances);
}

void draw_occluder(const Draw& draw, const GpuOccluder& occluder, GLsizei instances) {
  if (occluder.count == 0) return;
  glDisable(GL_CULL_FACE);
  const GLuint vertex_array = draw.mesh->vertex_array.id();
  glVertexArrayElementBuffer(vertex_array, occluder.indices.id());
  glBindVertexArray(vertex_array);
  glDrawElementsInstanced(GL_TRIANGLES, occluder.count, GL_UNSIGNED_INT, nullptr, instances);
  glVertexArrayElementBuffer(vertex_array, draw.mesh->indices.id());
}

}  // namespace furnace
