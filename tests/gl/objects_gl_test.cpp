#include <cstring>

#include <gmock/gmock.h>

#include "renderer/base/error.hpp"
#include "renderer/gl/pass_state.hpp"
#include "renderer/gl/program.hpp"
#include "renderer/gl/readback.hpp"
#include "renderer/gl/texture.hpp"
#include "renderer/residency/gpu_blocks.hpp"
#include "tests/support/gl_fixture.hpp"

namespace furnace::gl {
namespace {

using ObjectsGlTest = test::GlTest;

TEST_F(ObjectsGlTest, ContextIsTheSoftwareRasteriserAtGl45) {
  EXPECT_TRUE(context_.limits().software);
  EXPECT_GE(context_.limits().max_texture_px, 8192);
  EXPECT_THAT(context_.version(), testing::StartsWith("4.5"));
  EXPECT_FALSE(context_.lost());
}

TEST_F(ObjectsGlTest, UnknownDeviceIsRefusedWithAdvice) {
  try {
    Context::create({"0000:ff:1f.7", Determinism::kFast});
    FAIL() << "a device that does not exist was accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code, ErrorCode::kGpuUnavailable);
    EXPECT_THAT(error.message, testing::HasSubstr("furnace doctor"));
  }
}

TEST_F(ObjectsGlTest, ClearedTargetReadsBackAtItsPlace) {
  const Extent size{8, 4};
  const Texture color = create_texture(context_, GL_RGBA32F, size, 1);
  const Framebuffer framebuffer = create_framebuffer(context_, color, {});
  PassState state;
  state.framebuffer = framebuffer.id();
  state.viewport = size;
  state.clear_color = glm::vec4(0.25, 70000, -1, 1);
  begin_pass(context_, state);
  Image image = make_image({10, 6}, 4, SampleType::kFloat32, ColorSpace::kLinear);
  read_pixels(context_, framebuffer, size, image, 1, 2);
  const auto samples = image.samples<float>();
  EXPECT_EQ(samples[0], 0);  // outside of the rectangle
  const std::size_t first = (2 * 10 + 1) * 4;
  EXPECT_EQ(samples[first], 0.25f);
  EXPECT_EQ(samples[first + 1], 70000);
  EXPECT_EQ(samples[(5 * 10 + 8) * 4 + 2], -1);
}

TEST_F(ObjectsGlTest, TextureKeepsRowZeroFirst) {
  Image image = make_image({2, 2}, 4, SampleType::kUint8, ColorSpace::kNonColor);
  for (std::size_t i = 0; i < 16; ++i) image.pixels[i] = std::byte(i * 10);
  const Texture texture = upload_texture(context_, image, true);
  std::array<std::uint8_t, 16> back{};
  glGetTextureImage(texture.id(), 0, GL_RGBA, GL_UNSIGNED_BYTE, GLsizei(back.size()), back.data());
  EXPECT_EQ(std::memcmp(back.data(), image.pixels.data(), back.size()), 0);
  GLint width = 0;
  glGetTextureLevelParameteriv(texture.id(), 1, GL_TEXTURE_WIDTH, &width);
  EXPECT_EQ(width, 1);
}

// Levels that are given stay as they are; the others are made of the last one.
TEST_F(ObjectsGlTest, TextureKeepsTheLevelsItIsGiven) {
  std::vector<Image> levels;
  for (const int side : {8, 4}) {
    levels.push_back(make_image({side, side}, 4, SampleType::kUint8, ColorSpace::kNonColor));
    std::fill(levels.back().pixels.begin(), levels.back().pixels.end(), std::byte(side * 10));
  }
  const Texture texture = upload_levels(context_, levels);
  for (const auto& [level, value] :
       {std::pair(0, 80), std::pair(1, 40), std::pair(2, 40), std::pair(3, 40)}) {
    std::vector<std::uint8_t> back(std::size_t(8 >> level) * std::size_t(8 >> level) * 4);
    glGetTextureImage(texture.id(), level, GL_RGBA, GL_UNSIGNED_BYTE, GLsizei(back.size()), back.data());
    EXPECT_EQ(int(back.front()), value) << level;
    EXPECT_EQ(int(back.back()), value) << level;
  }
  GLint base = -1;
  glGetTextureParameteriv(texture.id(), GL_TEXTURE_BASE_LEVEL, &base);
  EXPECT_EQ(base, 0);
}

TEST_F(ObjectsGlTest, TextureOverTheLimitIsTooLarge) {
  const int side = context_.limits().max_texture_px + 1;
  EXPECT_THROW(create_texture(context_, GL_R8, {side, 1}, 1), Error);
}

TEST_F(ObjectsGlTest, SamplersAreMadeOnce) {
  SamplerCache cache;
  const SamplerDesc repeat;
  SamplerDesc clamp;
  clamp.wrap_u = Wrap::kClampToEdge;
  EXPECT_EQ(cache.get(context_, repeat), cache.get(context_, repeat));
  EXPECT_NE(cache.get(context_, repeat), cache.get(context_, clamp));
}

TEST_F(ObjectsGlTest, CompileErrorNamesShaderFileAndLine) {
  ShaderLibrary library({});
  library.add("broken.vert",
              "#include \"lib/constants.glsl\"\nvoid main() {\n  gl_Position = nonsense;\n}\n");
  library.add("fine.frag", "void main() {}\n");
  try {
    build_program(context_, library, {"broken.vert", "fine.frag", 0});
    FAIL() << "nonsense compiled";
  } catch (const Error& error) {
    EXPECT_THAT(error.detail, testing::HasSubstr("shaders/broken.vert:3"));
  }
}

// Every program the frame can ask for links, in every combination of features a material can have.
TEST_F(ObjectsGlTest, EveryProgramBuilds) {
  ShaderLibrary library({});
  const auto builds = [&](const char* vertex, const char* fragment, FeatureSet features) {
    EXPECT_NO_THROW(build_program(context_, library, {vertex, fragment, features}))
        << fragment << " " << features;
  };
  // Each combination of two features of a material, and all but one.
  constexpr FeatureSet kMaterialFeatures = kFeatureVeil - 1;
  const auto surface_builds = [&](FeatureSet features) {
    builds("surface/deferred.vert", "surface/deferred.frag", features);
    builds("surface/forward.vert", "surface/forward.frag", features);
  };
  for (FeatureSet a = 1; a <= kMaterialFeatures; a <<= 1) {
    for (FeatureSet b = a; b <= kMaterialFeatures; b <<= 1) surface_builds(a | b);
    surface_builds(kMaterialFeatures & ~a);
    builds("surface/deferred.vert", "surface/deferred.frag", a | kFeatureVeil);
    for (const FeatureSet shown : {FeatureSet(kFeatureEmission), FeatureSet(kFeatureSurfaceValue),
                                   kFeatureSurfaceValue | kFeatureNearest, FeatureSet(kFeatureLightPart),
                                   FeatureSet(kFeatureLightTerm)}) {
      surface_builds(a | shown);
      surface_builds((kMaterialFeatures & ~a) | shown);
    }
  }
  for (const FeatureSet features :
       {FeatureSet(0), FeatureSet(kFeatureAlphaMask), kFeatureAlphaMask | kFeatureMaterialMaps})
    builds("visibility/visibility.vert", "visibility/visibility.frag", features);
  for (const char* screen : {"visibility/shares.frag", "visibility/select.frag"})
    builds("screen/fullscreen.vert", screen, 0);
  builds("screen/fullscreen.vert", "visibility/shares.frag", kFeatureNearest);
  for (const char* screen : {"screen/accumulate.frag", "screen/resolve.frag"}) {
    for (const FeatureSet sky :
         {FeatureSet(0), FeatureSet(kFeatureSky), FeatureSet(kFeatureSky | kFeatureMagnified)}) {
      builds("screen/fullscreen.vert", screen, sky);
      builds("screen/fullscreen.vert", screen, sky | kFeatureVeil);
    }
  }
}

struct Member {
  const char* name;
  std::size_t offset;
};

// Every member that GL reports of `block` has the offset that C++ gives it, and none is missing on either side.
void expect_layout(GLuint program, const char* block, const std::vector<Member>& members, std::size_t size) {
  const GLuint index = glGetProgramResourceIndex(program, GL_UNIFORM_BLOCK, block);
  ASSERT_NE(index, GL_INVALID_INDEX) << block;
  const GLenum size_property = GL_BUFFER_DATA_SIZE, count_property = GL_NUM_ACTIVE_VARIABLES,
               list_property = GL_ACTIVE_VARIABLES;
  GLint value = 0;
  glGetProgramResourceiv(program, GL_UNIFORM_BLOCK, index, 1, &size_property, 1, nullptr, &value);
  EXPECT_EQ(std::size_t(value), size) << block;
  glGetProgramResourceiv(program, GL_UNIFORM_BLOCK, index, 1, &count_property, 1, nullptr, &value);
  std::vector<GLint> variables(static_cast<std::size_t>(value));
  glGetProgramResourceiv(program, GL_UNIFORM_BLOCK, index, 1, &list_property, value, nullptr,
                         variables.data());
  std::size_t found = 0;
  for (const GLint variable : variables) {
    char name[128] = {};
    glGetProgramResourceName(program, GL_UNIFORM, GLuint(variable), sizeof name, nullptr, name);
    const GLenum offset_property = GL_OFFSET;
    glGetProgramResourceiv(program, GL_UNIFORM, GLuint(variable), 1, &offset_property, 1, nullptr, &value);
    // Of an array of structs the first element stands for all.
    if (std::string(name).find("].") != std::string::npos &&
        std::string(name).find("[0].") == std::string::npos)
      continue;
    std::string plain = std::string(name).substr(std::string(name).rfind('.') + 1);
    plain = plain.substr(0, plain.find('['));
    const auto member =
        std::find_if(members.begin(), members.end(), [&](const Member& m) { return plain == m.name; });
    ASSERT_NE(member, members.end()) << name << " is unknown to C++";
    EXPECT_EQ(std::size_t(value), member->offset) << name;
    ++found;
  }
  EXPECT_EQ(found, members.size()) << block;
}

#define FURNACE_MEMBER(type, member) \
  Member {                           \
#member, offsetof(type, member)  \
  }

TEST_F(ObjectsGlTest, BlocksHaveTheSameLayoutInBothLanguages) {
  ShaderLibrary library({});
  library.add("layout.comp",
              "#include \"interface/frame_block.glsl\"\n#include \"interface/draw_block.glsl\"\n"
              "#include \"interface/ground_block.glsl\"\n#include \"interface/material_block.glsl\"\n"
              "layout(local_size_x = 1) in;\n"
              "layout(std140, binding = 0) uniform FrameUniform { FrameBlock frame; };\n"
              "layout(std140, binding = 1) uniform DrawUniform { DrawBlock draw; };\n"
              "layout(std140, binding = 2) uniform MaterialUniform { MaterialBlock material; };\n"
              "#include \"interface/light_block.glsl\"\n#include \"interface/sky_block.glsl\"\n"
              "layout(std140, binding = 3) uniform GroundUniform { GroundBlock ground; };\n"
              "layout(std140, binding = 5) uniform LightUniform { LightBlock lights; };\n"
              "#include \"interface/layer_block.glsl\"\n"
              "layout(std140, binding = 6) uniform LayerUniform { LayerBlock layers; };\n"
              "layout(std140, binding = 7) uniform SkyUniform { SkyBlock sky; };\n"
              "layout(std430, binding = 4) buffer Out { float result; };\n"
              "void main() { result = frame.point_size_samples + draw.handedness + material.metallic + "
              "ground.level; }\n");
  const Program program = build_program(context_, library, {"layout.comp", "", 0});
  using gpu::DrawBlock;
  using gpu::FrameBlock;
  using gpu::GroundBlock;
  using gpu::MaterialBlock;
  expect_layout(
      program.id(), "DrawUniform",
      {FURNACE_MEMBER(DrawBlock, world_from_model), FURNACE_MEMBER(DrawBlock, world_from_model_normal),
       FURNACE_MEMBER(DrawBlock, handedness), FURNACE_MEMBER(DrawBlock, key),
       FURNACE_MEMBER(DrawBlock, vertex_rows), FURNACE_MEMBER(DrawBlock, pad_0)},
      sizeof(DrawBlock));
  expect_layout(
      program.id(), "MaterialUniform",
      {FURNACE_MEMBER(MaterialBlock, base_color), FURNACE_MEMBER(MaterialBlock, emissive),
       FURNACE_MEMBER(MaterialBlock, metallic), FURNACE_MEMBER(MaterialBlock, perceptual_roughness),
       FURNACE_MEMBER(MaterialBlock, normal_scale), FURNACE_MEMBER(MaterialBlock, occlusion_strength),
       FURNACE_MEMBER(MaterialBlock, alpha_cutoff), FURNACE_MEMBER(MaterialBlock, double_sided),
       FURNACE_MEMBER(MaterialBlock, uv_sets), FURNACE_MEMBER(MaterialBlock, map_width),
       FURNACE_MEMBER(MaterialBlock, map_height), FURNACE_MEMBER(MaterialBlock, shadow_opacity),
       FURNACE_MEMBER(MaterialBlock, pad_0), FURNACE_MEMBER(MaterialBlock, pad_1),
       FURNACE_MEMBER(MaterialBlock, uv_rows)},
      sizeof(MaterialBlock));
  expect_layout(program.id(), "GroundUniform",
                {FURNACE_MEMBER(GroundBlock, clip_from_ground), FURNACE_MEMBER(GroundBlock, rectangle),
                 FURNACE_MEMBER(GroundBlock, far_light), FURNACE_MEMBER(GroundBlock, level),
                 FURNACE_MEMBER(GroundBlock, light_count), FURNACE_MEMBER(GroundBlock, lamp),
                 FURNACE_MEMBER(GroundBlock, pad_0), FURNACE_MEMBER(GroundBlock, light),
                 FURNACE_MEMBER(GroundBlock, weight), FURNACE_MEMBER(GroundBlock, shift)},
                sizeof(GroundBlock));
  using gpu::LayerBlock;
  expect_layout(program.id(), "LayerUniform",
                {FURNACE_MEMBER(LayerBlock, specular), FURNACE_MEMBER(LayerBlock, clearcoat),
                 FURNACE_MEMBER(LayerBlock, sheen), FURNACE_MEMBER(LayerBlock, anisotropy),
                 FURNACE_MEMBER(LayerBlock, iridescence), FURNACE_MEMBER(LayerBlock, transmission),
                 FURNACE_MEMBER(LayerBlock, absorption), FURNACE_MEMBER(LayerBlock, diffuse_transmission),
                 FURNACE_MEMBER(LayerBlock, glossy), FURNACE_MEMBER(LayerBlock, uv_sets),
                 FURNACE_MEMBER(LayerBlock, is_phong), FURNACE_MEMBER(LayerBlock, pad_0),
                 FURNACE_MEMBER(LayerBlock, pad_1), FURNACE_MEMBER(LayerBlock, uv_rows)},
                sizeof(LayerBlock));
  using gpu::SkyBlock;
  using gpu::SkyView;
  expect_layout(program.id(), "SkyUniform",
                {FURNACE_MEMBER(SkyBlock, count), FURNACE_MEMBER(SkyBlock, least_alpha),
                 FURNACE_MEMBER(SkyBlock, map_px), FURNACE_MEMBER(SkyBlock, first_layer),
                 FURNACE_MEMBER(SkyBlock, even),
                 Member{"towards", offsetof(SkyBlock, views) + offsetof(SkyView, towards)},
                 Member{"light", offsetof(SkyBlock, views) + offsetof(SkyView, light)},
                 Member{"map_u", offsetof(SkyBlock, views) + offsetof(SkyView, map_u)},
                 Member{"map_v", offsetof(SkyBlock, views) + offsetof(SkyView, map_v)},
                 Member{"map_depth", offsetof(SkyBlock, views) + offsetof(SkyView, map_depth)}},
                sizeof(SkyBlock));
  using gpu::LightBlock;
  expect_layout(program.id(), "LightUniform",
                {FURNACE_MEMBER(LightBlock, count), FURNACE_MEMBER(LightBlock, shadow_texel),
                 FURNACE_MEMBER(LightBlock, tile_x), FURNACE_MEMBER(LightBlock, tile_y),
                 Member{"place", offsetof(LightBlock, lights) + offsetof(gpu::LightRow, place)},
                 Member{"intensity", offsetof(LightBlock, lights) + offsetof(gpu::LightRow, intensity)},
                 Member{"axis", offsetof(LightBlock, lights) + offsetof(gpu::LightRow, axis)},
                 Member{"cone", offsetof(LightBlock, lights) + offsetof(gpu::LightRow, cone)},
                 Member{"across", offsetof(LightBlock, lights) + offsetof(gpu::LightRow, across)},
                 Member{"shadow", offsetof(LightBlock, lights) + offsetof(gpu::LightRow, shadow)},
                 Member{"eye", offsetof(LightBlock, lights) + offsetof(gpu::LightRow, eye)},
                 FURNACE_MEMBER(LightBlock, shadow_from_world), FURNACE_MEMBER(LightBlock, corners)},
                sizeof(LightBlock));
  expect_layout(program.id(), "FrameUniform",
                {FURNACE_MEMBER(FrameBlock, clip_from_world),
                 FURNACE_MEMBER(FrameBlock, world_from_ray),
                 FURNACE_MEMBER(FrameBlock, environment_from_world),
                 FURNACE_MEMBER(FrameBlock, background_from_world),
                 FURNACE_MEMBER(FrameBlock, origin_from_ndc),
                 FURNACE_MEMBER(FrameBlock, ground_from_ndc),
                 FURNACE_MEMBER(FrameBlock, backdrop_from_world),
                 FURNACE_MEMBER(FrameBlock, background_top),
                 FURNACE_MEMBER(FrameBlock, background_bottom),
                 FURNACE_MEMBER(FrameBlock, backdrop_kind),
                 FURNACE_MEMBER(FrameBlock, background_share),
                 FURNACE_MEMBER(FrameBlock, pad_0),
                 FURNACE_MEMBER(FrameBlock, pad_1),
                 FURNACE_MEMBER(FrameBlock, eye_world),
                 FURNACE_MEMBER(FrameBlock, towards_viewer_world),
                 FURNACE_MEMBER(FrameBlock, level_tiles),
                 FURNACE_MEMBER(FrameBlock, irradiance_tile),
                 FURNACE_MEMBER(FrameBlock, atlas_texel_u),
                 FURNACE_MEMBER(FrameBlock, atlas_texel_v),
                 FURNACE_MEMBER(FrameBlock, atlas_gain),
                 FURNACE_MEMBER(FrameBlock, sky_gain),
                 FURNACE_MEMBER(FrameBlock, level_count),
                 FURNACE_MEMBER(FrameBlock, background_lod),
                 FURNACE_MEMBER(FrameBlock, pixel_footprint),
                 FURNACE_MEMBER(FrameBlock, point_size_samples),
                 FURNACE_MEMBER(FrameBlock, ndc_per_pixel_x),
                 FURNACE_MEMBER(FrameBlock, ndc_per_pixel_y),
                 FURNACE_MEMBER(FrameBlock, depth_tolerance),
                 FURNACE_MEMBER(FrameBlock, exposure),
                 FURNACE_MEMBER(FrameBlock, background_gain),
                 FURNACE_MEMBER(FrameBlock, shadow_strength),
                 FURNACE_MEMBER(FrameBlock, dome_radius),
                 FURNACE_MEMBER(FrameBlock, dome_height)},
                sizeof(FrameBlock));
}

}  // namespace
}  // namespace furnace::gl
