#include "renderer/frame/ground_shadow.hpp"

#include <algorithm>
#include <cmath>

#include "renderer/frame/draw_binding.hpp"

namespace furnace {
namespace {

constexpr GLuint kGroundBinding = 3;
// A shadow longer than so many times the scene's height is let go: it would leave too few texels for the rest.
constexpr double kLongestShadow = 8;
// Of the light: what may cast its shadow beyond the map.
constexpr double kFarLight = 0.04;
const double kFadeSide = 1 / (1 - 2 * double(gpu::GROUND_FADE));

// Metres that a shadow moves in x and z for each metre of height.
glm::dvec2 slope_of(const LightDirection& light) {
  return glm::dvec2(light.towards[0], light.towards[2]) / std::max(light.towards[1], 1e-6);
}

// Texels as square as they go, more of them where more lights draw finer penumbrae.
Extent map_extent(const GroundRectangle& rectangle, std::size_t lights) {
  const double texels = lights <= gpu::GROUND_LIGHTS ? 0x1p18 : 0x1p20;
  const glm::dvec2 size = rectangle.high - rectangle.low;
  const double aspect = std::clamp(size.x / size.y, 1.0 / 64, 64.0);
  return {int(std::lround(std::sqrt(texels * aspect))), int(std::lround(std::sqrt(texels / aspect)))};
}

double radical_inverse(std::uint32_t bits) {
  double result = 0;
  for (double digit = 0.5; bits != 0; bits >>= 1, digit *= 0.5) result += (bits & 1) * digit;
  return result;
}

// 1 over all the light, of each colour that there is.
glm::dvec3 per_light(const PreparedGround& ground) {
  glm::dvec3 total = ground.free_irradiance;
  for (const LightDirection& light : *ground.light)
    total += glm::dvec3(light.irradiance[0], light.irradiance[1], light.irradiance[2]);
  for (int c = 0; c < 3; ++c) total[c] = total[c] > 0 ? 1 / total[c] : 0;
  return total;
}

gpu::GroundBlock pack_ground(const PreparedGround& ground, const GroundRectangle& rectangle, Extent map,
                             std::size_t first) {
  gpu::GroundBlock block{};
  const glm::dvec2 size = rectangle.high - rectangle.low, centre = (rectangle.low + rectangle.high) * 0.5;
  // Clip space points up, rows grow along +z.
  const glm::dvec2 scale(2 / size.x, -2 / size.y);
  block.clip_from_ground = glm::vec4(scale, -centre * scale);
  block.level = float(ground.level_m);
  const std::size_t count = std::min<std::size_t>(ground.light->size() - first, gpu::GROUND_LIGHTS);
  block.light_count = gpu::uint(count);
  const glm::dvec3 share = per_light(ground);
  for (std::size_t i = 0; i < count; ++i) {
    const LightDirection& light = (*ground.light)[first + i];
    const double least_opacity =
        radical_inverse(std::uint32_t(first + i)) + 0.5 / double(ground.light->size());
    const glm::vec2 shift = 2.f * r2_offset(int(first + i)) / glm::vec2(map.width, map.height);
    block.light[i] = glm::vec4(slope_of(light), least_opacity, shift.x);
    const glm::dvec3 irradiance(light.irradiance[0], light.irradiance[1], light.irradiance[2]);
    block.weight[i] = glm::vec4(irradiance * share, shift.y);
  }
  return block;
}

// `occluder`: in place of the mesh's own triangles, where nothing but their place counts; may be null.
void cast(gl::Context& context, gl::ProgramCache& programs, const GpuScene& scene, const Draw& draw,
          const GpuOccluder* occluder, GLsizei lights) {
  const gl::FeatureSet features = caster_features(draw);
  glUseProgram(programs.request(context, {"ground/cast.vert", "ground/cast.frag", features}));
  bind_draw(scene, draw);
  if (features != 0 || occluder == nullptr) return draw_mesh(draw, GL_NONE, lights);
  draw_occluder(draw, *occluder, lights);
}

std::vector<GpuOccluder> upload_occluders(gl::Context& context, const PreparedGround& ground) {
  std::vector<GpuOccluder> occluders;
  for (const auto& indices : ground.occluders) {
    GpuOccluder occluder;
    occluder.count = indices == nullptr ? 0 : GLsizei(indices->size());
    if (occluder.count > 0)
      occluder.indices = gl::create_buffer(context, indices->data(), indices->size() * sizeof(std::uint32_t));
    occluders.push_back(std::move(occluder));
  }
  return occluders;
}

}  // namespace

GroundRectangle ground_rectangle(const PreparedGround& ground) {
  const glm::dvec3 low = ground.bounds.min, high = ground.bounds.max;
  const double height = std::max(high.y - ground.level_m, 0.0);
  std::vector<glm::dvec2> slopes;
  for (const LightDirection& light : *ground.light) slopes.push_back(slope_of(light));
  std::sort(slopes.begin(), slopes.end(),
            [](const glm::dvec2& a, const glm::dvec2& b) { return glm::length(a) < glm::length(b); });
  slopes.resize(std::size_t(std::ceil(double(slopes.size()) * (1 - kFarLight))));
  GroundRectangle rectangle{{low.x, low.z}, {high.x, high.z}};
  for (glm::dvec2 slope : slopes) {
    const double reach = glm::length(slope);
    if (reach > kLongestShadow) slope *= kLongestShadow / reach;
    rectangle.low = glm::min(rectangle.low, glm::dvec2(low.x, low.z) - slope * height);
    rectangle.high = glm::max(rectangle.high, glm::dvec2(high.x, high.z) - slope * height);
  }
  const glm::dvec2 centre = (rectangle.low + rectangle.high) * 0.5;
  glm::dvec2 half = (rectangle.high - rectangle.low) * 0.5;
  // A flat or empty scene has a map all the same.
  const double least = std::max({half.x, half.y, height, 1e-6}) * 1e-2;
  half = glm::max(half, glm::dvec2(least)) * kFadeSide;
  return {centre - half, centre + half};
}

GpuGroundShadow draw_ground_shadow(gl::Context& context, gl::ProgramCache& programs, Residency& residency,
                                   const GpuScene& scene, const PreparedGround& ground,
                                   const gl::VertexArray& empty_vertex_array, const Deadline& deadline) {
  GpuGroundShadow shadow;
  shadow.rectangle = ground_rectangle(ground);
  const Extent extent = map_extent(shadow.rectangle, ground.light->size());
  shadow.bytes = std::size_t(extent.area()) * 16 * 4 / 3;
  shadow.texture = gl::create_texture(context, GL_RGBA32F, extent, gl::mip_levels(extent));
  const gl::Framebuffer sum = gl::create_framebuffer(context, shadow.texture, {});
  const gl::Texture lights = gl::create_texture(context, GL_RGBA32UI, extent, 1);
  const gl::Framebuffer collected = gl::create_framebuffer(context, lights, {});

  const std::vector<GpuOccluder> occluders = upload_occluders(context, ground);

  gl::PassState gather;
  gather.framebuffer = sum.id();
  gather.viewport = extent;
  gather.blend = gl::Blend::kAdd;
  gather.clear_color = glm::vec4(1);
  gl::PassState cast_state;
  cast_state.framebuffer = collected.id();
  cast_state.viewport = extent;
  cast_state.blend = gl::Blend::kOr;
  for (std::size_t first = 0; first < ground.light->size(); first += gpu::GROUND_LIGHTS) {
    const gpu::GroundBlock block = pack_ground(ground, shadow.rectangle, extent, first);
    const gl::Buffer uniform = gl::create_buffer(context, &block, sizeof block);
    glBindBufferBase(GL_UNIFORM_BUFFER, kGroundBinding, uniform.id());
    gl::begin_pass(context, cast_state);
    constexpr std::array<GLuint, 4> kNone{};
    glClearNamedFramebufferuiv(collected.id(), GL_COLOR, 0, kNone.data());
    for (const std::vector<Draw>* draws : {&scene.deferred, &scene.blended}) {
      for (const Draw& draw : *draws) {
        check_deadline(deadline, "ground shadow");
        if (draw.mesh->mode != GL_TRIANGLES) continue;
        const GpuOccluder& occluder = occluders[std::size_t(draw.source_mesh)];
        cast(context, programs, scene, draw, occluder.count > 0 ? &occluder : nullptr,
             GLsizei(block.light_count));
      }
    }
    gl::begin_pass(context, gather);
    gather.clear_color.reset();
    glUseProgram(programs.request(context, {"screen/fullscreen.vert", "ground/gather.frag", 0}));
    bind_texels(context, residency, 0, lights);
    draw_viewport(empty_vertex_array);
    glFinish();
  }
  glGenerateTextureMipmap(shadow.texture.id());
  return shadow;
}

}  // namespace furnace
