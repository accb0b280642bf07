#include "renderer/frame/ground_shadow.hpp"

#include <algorithm>
#include <cmath>

#include "renderer/frame/draw_binding.hpp"
#include "renderer/frame/light_places.hpp"
#include "renderer/frame/light_plan.hpp"

namespace furnace {
namespace {

constexpr GLuint kGroundBinding = 3, kLightBinding = 4;
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

// By all that is far.
glm::dvec3 far_irradiance(const PreparedGround& ground) {
  glm::dvec3 total = ground.free_irradiance;
  for (const LightDirection& light : *ground.light)
    total += glm::dvec3(light.irradiance[0], light.irradiance[1], light.irradiance[2]);
  return total;
}

gpu::GroundBlock pack_map(const PreparedGround& ground, const GroundRectangle& rectangle) {
  gpu::GroundBlock block{};
  const glm::dvec2 size = rectangle.high - rectangle.low, centre = (rectangle.low + rectangle.high) * 0.5;
  // Clip space points up, rows grow along +z.
  const glm::dvec2 scale(2 / size.x, -2 / size.y);
  block.clip_from_ground = glm::vec4(scale, -centre * scale);
  block.rectangle = glm::vec4(rectangle.low, size);
  block.far_light = glm::vec4(far_irradiance(ground), 0);
  block.level = float(ground.level_m);
  return block;
}

glm::vec4 shift_of(std::size_t light, Extent map) {
  return glm::vec4(2.f * r2_offset(int(light)) / glm::vec2(map.width, map.height), 0, 0);
}

void set_far_lights(const PreparedGround& ground, Extent map, std::size_t first, gpu::GroundBlock& block) {
  const std::size_t count = std::min<std::size_t>(ground.light->size() - first, gpu::GROUND_LIGHTS);
  block.light_count = gpu::uint(count);
  const glm::dvec3 total = far_irradiance(ground);
  for (std::size_t i = 0; i < count; ++i) {
    const LightDirection& light = (*ground.light)[first + i];
    const double least_opacity =
        radical_inverse(std::uint32_t(first + i)) + 0.5 / double(ground.light->size());
    block.light[i] = glm::vec4(slope_of(light), 0, least_opacity);
    for (int c = 0; c < 3; ++c)
      block.weight[i][c] = total[c] > 0 ? float(light.irradiance[std::size_t(c)] / total[c]) : 0;
    block.shift[i] = shift_of(first + i, map);
  }
}

// Where a lamp's place lies below the ground it sheds nothing there.
void set_places(const PreparedGround& ground, const Light& lamp, Extent map, gpu::GroundBlock& block) {
  for (int i = 0; i < ground.places; ++i) {
    const glm::dvec3 place = place_on(lamp, ground.first_place + i);
    const double height = place.y - ground.level_m;
    if (height <= 0) continue;
    const gpu::uint at = block.light_count++;
    const double least_opacity = radical_inverse(std::uint32_t(i)) + 0.5 / ground.places;
    block.light[at] = glm::vec4(glm::dvec2(place.x, place.z) / height, 1 / height, least_opacity);
    block.shift[at] = shift_of(std::size_t(ground.first_place + i), map);
  }
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

// The shadows of the upper corners, from the lamp's middle and from its ends.
void add_shadow_of_bounds(const PreparedGround& ground, const Light& lamp, GroundRectangle& rectangle) {
  const glm::dvec3 low = ground.bounds.min, high = ground.bounds.max;
  const double height = std::max(high.y - ground.level_m, 0.0), size = extent_m(lamp);
  for (const glm::dvec2 offset : {glm::dvec2(0), {size, 0}, {-size, 0}, {0, size}, {0, -size}}) {
    const glm::dvec2 lamp_at = glm::dvec2(lamp.position.x, lamp.position.z) + offset;
    const double lamp_height = lamp.position.y - ground.level_m;
    if (lamp_height <= 0) continue;
    for (const glm::dvec2 corner :
         {glm::dvec2(low.x, low.z), {low.x, high.z}, {high.x, low.z}, {high.x, high.z}}) {
      const double above = std::max(lamp_height - height, 1e-6 * height);
      glm::dvec2 shift = (corner - lamp_at) * (height / above);
      if (const double reach = glm::length(shift); reach > kLongestShadow * height)
        shift *= kLongestShadow * height / reach;
      rectangle.low = glm::min(rectangle.low, corner + shift);
      rectangle.high = glm::max(rectangle.high, corner + shift);
    }
  }
}

// Threads: the context's. Owns: what one shadow is drawn with.
class GroundShadowWork {
 public:
  GroundShadowWork(gl::Context& context, gl::ProgramCache& programs, Residency& residency,
                   const GpuScene& scene, const PreparedGround& ground,
                   const gl::VertexArray& empty_vertex_array, const Deadline& deadline)
      : context_(context),
        programs_(programs),
        residency_(residency),
        scene_(scene),
        ground_(ground),
        empty_vertex_array_(empty_vertex_array),
        deadline_(deadline),
        rectangle_(ground_rectangle(ground)),
        extent_(map_extent(rectangle_, ground.light->size())),
        occluders_(upload_occluders(context, ground)),
        hidden_(gl::create_texture(context, GL_RGBA32UI, extent_, 1)),
        collected_(gl::create_framebuffer(context, hidden_, {})) {}

  GpuGroundShadow draw() {
    GpuGroundShadow shadow;
    shadow.rectangle = rectangle_;
    shadow.bytes = std::size_t(extent_.area()) * 16 * 4 / 3;
    shadow.texture = gl::create_texture(context_, GL_RGBA32F, extent_, gl::mip_levels(extent_));
    if (ground_.lamps.empty())
      draw_far_share(shadow.texture);
    else
      draw_share_of_all(shadow.texture);
    glGenerateTextureMipmap(shadow.texture.id());
    return shadow;
  }

 private:
  void draw_far_share(const gl::Texture& into) {
    const gl::Framebuffer target = gl::create_framebuffer(context_, into, {});
    gl::PassState gather = state_of(target);
    gather.blend = gl::Blend::kAdd;
    gather.clear_color = glm::vec4(1);
    gl::begin_pass(context_, gather);
    gather.clear_color.reset();
    for (std::size_t first = 0; first < ground_.light->size(); first += gpu::GROUND_LIGHTS) {
      gpu::GroundBlock block = pack_map(ground_, rectangle_);
      set_far_lights(ground_, extent_, first, block);
      collect(block);
      gl::begin_pass(context_, gather);
      fullscreen(block, "ground/gather.frag", 0, {&hidden_});
    }
  }

  void draw_share_of_all(const gl::Texture& into) {
    const gl::Texture far_share = gl::create_texture(context_, GL_RGBA32F, extent_, 1);
    draw_far_share(far_share);
    const gl::Texture lit = gl::create_texture(context_, GL_RGBA32F, extent_, 1),
                      free = gl::create_texture(context_, GL_RGBA32F, extent_, 1);
    const gl::Framebuffer lit_target = gl::create_framebuffer(context_, lit, {}),
                          free_target = gl::create_framebuffer(context_, free, {});
    const LightPlan plan = plan_lights(ground_.lamps, Bounds(), glm::vec2(0), 0, 1);
    const gl::Buffer lights = gl::create_buffer(context_, &plan.block, sizeof plan.block);
    glBindBufferBase(GL_UNIFORM_BUFFER, kLightBinding, lights.id());
    for (std::size_t i = 0; i < ground_.lamps.size(); ++i) {
      gpu::GroundBlock block = pack_map(ground_, rectangle_);
      block.lamp = gpu::uint(i);
      add_lamp(block, free_target, i == 0);
      if (ground_.lamps[i].casts_shadow) set_places(ground_, ground_.lamps[i], extent_, block);
      if (block.light_count > 0) collect(block);
      add_lamp(block, lit_target, i == 0);
    }
    const gl::Framebuffer target = gl::create_framebuffer(context_, into, {});
    gl::begin_pass(context_, state_of(target));
    fullscreen(pack_map(ground_, rectangle_), "ground/join.frag", 0, {&far_share, &lit, &free});
  }

  void add_lamp(const gpu::GroundBlock& block, const gl::Framebuffer& target, bool is_first) {
    const Light& lamp = ground_.lamps[block.lamp];
    gl::FeatureSet features = 0;
    if (lamp.is_surface()) features |= gl::kFeatureSurfaceLights;
    if (lamp.profile != nullptr) features |= gl::kFeatureLightProfiles;
    gl::PassState state = state_of(target);
    state.blend = gl::Blend::kAdd;
    if (is_first) state.clear_color = glm::vec4(0);
    gl::begin_pass(context_, state);
    bind_tables(context_, residency_, scene_);
    fullscreen(block, "ground/gather_lamp.frag", features, {&hidden_});
  }

  // Which of the block's lights the scene keeps from each place of the ground.
  void collect(const gpu::GroundBlock& block) {
    const gl::Buffer uniform = bind_block(block);
    gl::PassState state = state_of(collected_);
    state.blend = gl::Blend::kOr;
    gl::begin_pass(context_, state);
    constexpr std::array<GLuint, 4> kNone{};
    glClearNamedFramebufferuiv(collected_.id(), GL_COLOR, 0, kNone.data());
    for (const std::vector<Draw>* draws : {&scene_.deferred, &scene_.blended}) {
      for (const Draw& draw : *draws) {
        check_deadline(deadline_, "ground shadow");
        if (draw.mesh->mode != GL_TRIANGLES) continue;
        const GpuOccluder& occluder = occluders_[std::size_t(draw.source_mesh)];
        cast(context_, programs_, scene_, draw, occluder.count > 0 ? &occluder : nullptr,
             GLsizei(block.light_count));
      }
    }
  }

  void fullscreen(const gpu::GroundBlock& block, const char* fragment, gl::FeatureSet features,
                  std::initializer_list<const gl::Texture*> textures) {
    const gl::Buffer uniform = bind_block(block);
    glUseProgram(programs_.request(context_, {"screen/fullscreen.vert", fragment, features}));
    GLuint unit = 0;
    for (const gl::Texture* texture : textures) bind_texels(context_, residency_, unit++, *texture);
    draw_viewport(empty_vertex_array_);
    glFinish();
  }

  gl::Buffer bind_block(const gpu::GroundBlock& block) {
    gl::Buffer uniform = gl::create_buffer(context_, &block, sizeof block);
    glBindBufferBase(GL_UNIFORM_BUFFER, kGroundBinding, uniform.id());
    return uniform;
  }

  gl::PassState state_of(const gl::Framebuffer& target) const {
    gl::PassState state;
    state.framebuffer = target.id();
    state.viewport = extent_;
    return state;
  }

  gl::Context& context_;
  gl::ProgramCache& programs_;
  Residency& residency_;
  const GpuScene& scene_;
  const PreparedGround& ground_;
  const gl::VertexArray& empty_vertex_array_;
  const Deadline& deadline_;
  const GroundRectangle rectangle_;
  const Extent extent_;
  const std::vector<GpuOccluder> occluders_;
  const gl::Texture hidden_;  // a bit for each light of a block
  const gl::Framebuffer collected_;
};

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
  for (const Light& lamp : ground.lamps)
    if (lamp.casts_shadow) add_shadow_of_bounds(ground, lamp, rectangle);
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
  return GroundShadowWork(context, programs, residency, scene, ground, empty_vertex_array, deadline).draw();
}

}  // namespace furnace
