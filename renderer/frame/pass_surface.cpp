#include <iterator>

#include "renderer/frame/passes.hpp"
#include "renderer/gl/pass_state.hpp"

namespace furnace {
namespace {

constexpr GLuint kDrawBinding = 1, kMaterialBinding = 2;
constexpr GLuint kSkyUnit = 5, kAtlasUnit = 6, kDfgUnit = 7;
constexpr GLuint kColorLocation = 5;

constexpr SamplerDesc kSkySampler{Wrap::kRepeat, Wrap::kClampToEdge, Filter::kLinear, Filter::kLinear,
                                  MipFilter::kLinear};
constexpr SamplerDesc kTableSampler{Wrap::kClampToEdge, Wrap::kClampToEdge, Filter::kLinear, Filter::kLinear,
                                    MipFilter::kNone};

gl::PassState surface_state(const PassContext& pass) {
  gl::PassState state;
  state.framebuffer = pass.targets.draw.id();
  state.viewport_x = -pass.tile.x;
  state.viewport_y = -pass.tile.y;
  state.viewport = pass.plan.picture;
  return state;
}

void bind_environment(const PassContext& pass) {
  bind_sky(pass);
  gl::SamplerCache& samplers = pass.residency.samplers();
  glBindTextureUnit(kAtlasUnit, pass.scene.environment->atlas.id());
  glBindSampler(kAtlasUnit, samplers.get(pass.context, kTableSampler));
  glBindTextureUnit(kDfgUnit, pass.residency.dfg_texture());
  glBindSampler(kDfgUnit, samplers.get(pass.context, kTableSampler));
}

void bind_draw(const PassContext& pass, const Draw& draw) {
  const GpuScene& scene = pass.scene;
  const GpuMaterial& material = scene.materials[std::size_t(draw.material)];
  glUseProgram(
      pass.programs.request(pass.context, {"surface/surface.vert", "surface/surface.frag", draw.features}));
  glBindBufferRange(GL_UNIFORM_BUFFER, kDrawBinding, scene.draw_blocks.id(), draw.block * scene.draw_stride,
                    sizeof(gpu::DrawBlock));
  glBindBufferRange(GL_UNIFORM_BUFFER, kMaterialBinding, scene.material_blocks.id(),
                    draw.material * scene.material_stride, sizeof(gpu::MaterialBlock));
  glBindTextures(0, gpu::kSlotCount, material.textures.data());
  glBindSamplers(0, gpu::kSlotCount, material.samplers.data());
  // GL reverses the sense of winding itself when the clip origin is the upper left.
  glFrontFace(draw.mirrored ? GL_CW : GL_CCW);
}

void submit(const Draw& draw) {
  glBindVertexArray(draw.mesh->vertex_array.id());
  glDrawElements(draw.mesh->mode, draw.mesh->index_count, GL_UNSIGNED_INT, nullptr);
}

void cull(GLenum face) {
  if (face == GL_NONE) {
    glDisable(GL_CULL_FACE);
  } else {
    glEnable(GL_CULL_FACE);
    glCullFace(face);
  }
}

}  // namespace

void bind_sky(const PassContext& pass) {
  glBindTextureUnit(kSkyUnit, pass.scene.environment->sky.id());
  glBindSampler(kSkyUnit, pass.residency.samplers().get(pass.context, kSkySampler));
}

void pass_surface_opaque(const PassContext& pass) {
  gl::PassState state = surface_state(pass);
  state.depth = gl::DepthUse::kTestAndWrite;
  state.clear_color = pass.plan.background_color;
  state.clear_depth = true;
  gl::begin_pass(pass.context, state);
  bind_environment(pass);
  glVertexAttrib4f(kColorLocation, 1, 1, 1, 1);
  const bool multisampled = pass.plan.msaa_samples > 1;
  for (const Draw& draw : pass.scene.opaque) {
    const GpuMaterial& material = pass.scene.materials[std::size_t(draw.material)];
    if (multisampled && material.alpha_mode == AlphaMode::kMask) {
      glEnable(GL_SAMPLE_ALPHA_TO_COVERAGE);
    } else {
      glDisable(GL_SAMPLE_ALPHA_TO_COVERAGE);
    }
    bind_draw(pass, draw);
    cull(material.double_sided ? GL_NONE : GL_BACK);
    submit(draw);
  }
}

void pass_surface_blended(const PassContext& pass) {
  if (pass.scene.blended.empty()) return;
  gl::PassState state = surface_state(pass);
  state.depth = gl::DepthUse::kTest;
  state.blend = gl::Blend::kPremultiplied;
  gl::begin_pass(pass.context, state);
  bind_environment(pass);
  for (const Draw& draw : pass.scene.blended) {
    bind_draw(pass, draw);
    if (pass.scene.materials[std::size_t(draw.material)].double_sided && draw.mesh->mode == GL_TRIANGLES) {
      // The far side first: of a closed shape both sides then blend in order.
      cull(GL_FRONT);
      submit(draw);
    }
    cull(GL_BACK);
    submit(draw);
  }
}

}  // namespace furnace
