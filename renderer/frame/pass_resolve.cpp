#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "renderer/frame/draw_binding.hpp"
#include "renderer/scene/transform.hpp"

namespace furnace {
namespace {

// Numbers of screen/resolve.frag.
enum ToneCurve : GLuint {
  kCurvePbrNeutral = 0,
  kCurveClip = 1,
  kCurveSceneLinear = 2,
  kCurveAces = 3,
  kCurveAgx = 4,
  kCurveReinhard = 5,
  kCurveGlow = 6,  // none: what bloom changes, as it is
};

ToneCurve tone_curve(const FramePlan& plan) {
  if (plan.scene_linear()) return kCurveSceneLinear;
  switch (plan.tone_map) {
    case ToneMap::kPbrNeutral:
      return kCurvePbrNeutral;
    case ToneMap::kAces:
      return kCurveAces;
    case ToneMap::kAgx:
      return kCurveAgx;
    case ToneMap::kReinhard:
      return kCurveReinhard;
    case ToneMap::kLinear:
    case ToneMap::kNone:
      break;
  }
  return kCurveClip;
}

void set_grade(GLuint program, const PlannedGrade& grade) {
  constexpr GLint kAmountsLocation = 6, kWhiteBalanceLocation = 7;
  glProgramUniform2f(program, kAmountsLocation, grade.contrast, grade.saturation);
  glProgramUniformMatrix3fv(program, kWhiteBalanceLocation, 1, GL_FALSE, &grade.white_balance[0].x);
}

void draw_screen(const PassContext& pass, const gl::Texture& source) {
  bind_texels(pass.context, pass.residency, 0, source);
  draw_viewport(pass.empty_vertex_array);
}

// What stands behind a film layer that is shown alone.
constexpr glm::vec4 kBlack{0, 0, 0, 1};

glm::vec4 background_at(const PassContext& pass, int row) {
  return glm::mix(pass.plan.background_top, pass.plan.background_bottom,
                  float(row) / float(pass.plan.picture.height));
}

constexpr GLint kExposureLocation = 5;

// `composes`: this pass is the first to read the sub-frame, so it puts veil and background to it.
GLuint screen_program(const PassContext& pass, const char* fragment, bool composes, bool fragment_exposes,
                      gl::FeatureSet features) {
  if (composes && pass.veiled()) {
    features |= gl::kFeatureVeil;
    bind_texels(pass.context, pass.residency, 1, pass.targets.veil->pixels);
  }
  const bool shows_other = pass.shown && pass.shown != FilmLayer::kBackground;
  const bool backed = composes && !pass.emission && !shows_other && !pass.is_backdrop;
  const bool sky = backed && pass.scene.background != nullptr;
  if (sky) {
    features |= gl::kFeatureSky;
    if (pass.plan.projection) {
      features |= gl::kFeatureGroundProjection;
    } else if (pass.frame.background_lod < 0) {
      features |= gl::kFeatureMagnified;
    }
    bind_sky(pass, *pass.scene.background);
  }
  if (backed && pass.scene.ground_shadow != nullptr) {
    features |= gl::kFeatureGroundShadow;
    bind_ground(pass);
  }
  const GLuint program = pass.programs.request(pass.context, {"screen/fullscreen.vert", fragment, features});
  constexpr GLint kBackgroundLocation = 3;
  if (fragment_exposes || (composes && pass.veiled()))
    glProgramUniform1f(program, kExposureLocation, pass.veil_exposure());
  if (!sky) {
    std::array<glm::vec4, 2> ends{};
    if (backed)
      ends = {background_at(pass, pass.tile.y), background_at(pass, pass.tile.y + pass.tile.size.height)};
    if (!composes && pass.shown && pass.plan.opaque) ends.fill(kBlack);
    glProgramUniform4fv(program, kBackgroundLocation, 2, &ends[0].x);
  }
  return program;
}

bool emission_glows(const PassContext& pass) {
  return pass.plan.bloom && pass.plan.bloom->source == BloomSource::kEmission;
}

void set_bloom(GLuint program, const PlannedBloom& bloom) {
  constexpr GLint kBloomLocation = 8;
  glProgramUniform2f(program, kBloomLocation, bloom.intensity, bloom.threshold);
}

// What screen/resolve.frag reads of the bloom.
void bind_bloom(const PassContext& pass, GLuint program) {
  constexpr GLuint kGlowUnit = 2, kEmissionUnit = 3;
  constexpr GLint kPictureLocation = 9;
  constexpr SamplerDesc kGlowSampler{Wrap::kMirroredRepeat, Wrap::kMirroredRepeat, Filter::kLinear,
                                     Filter::kLinear, MipFilter::kNone};
  set_bloom(program, *pass.plan.bloom);
  const Extent& picture = pass.plan.picture;
  const glm::vec2 pixel = 1.f / glm::vec2(picture.width, picture.height);
  glProgramUniform4f(program, kPictureLocation, float(pass.tile.x) * pixel.x, float(pass.tile.y) * pixel.y,
                     pixel.x, pixel.y);
  glBindTextureUnit(kGlowUnit, pass.glow->id());
  glBindSampler(kGlowUnit, pass.residency.samplers().get(pass.context, kGlowSampler));
  if (emission_glows(pass))
    bind_texels(pass.context, pass.residency, kEmissionUnit, pass.targets.emission->color);
}

const gl::Texture& frame_of(const PassContext& pass) {
  return pass.sum != nullptr ? pass.sum->color : pass.targets.shading.color;
}

// `composes`: as screen_program().
GLuint resolve_program(const PassContext& pass, bool composes, gl::FeatureSet features) {
  const bool blooms = pass.plan.bloom && !pass.shown;
  if (blooms) features |= gl::kFeatureBloom;
  if (blooms && emission_glows(pass)) features |= gl::kFeatureEmission;
  const GLuint program = screen_program(pass, "screen/resolve.frag", composes, true, features);
  if (blooms) bind_bloom(pass, program);
  return program;
}

constexpr GLint kCurveLocation = 1, kLargestLocation = 2;
// The radiance of a white surface.
constexpr float kWhiteFromIrradiance = float(1 / kPi);

void resolve_picture(const PassContext& pass) {
  const ToneCurve curve = tone_curve(pass.plan);
  const bool graded = pass.plan.grade || curve > kCurveSceneLinear;
  gl::FeatureSet features = 0;
  if (graded) features |= gl::kFeatureGrade;
  if (pass.plan.dither) features |= gl::kFeatureDither;
  const GLuint program = resolve_program(pass, pass.sum == nullptr, features);
  constexpr GLint kTileLocation = 10;
  if (pass.plan.dither) glProgramUniform2f(program, kTileLocation, float(pass.tile.x), float(pass.tile.y));
  if (graded) set_grade(program, pass.plan.grade.value_or(PlannedGrade{}));
  if (pass.shown == FilmLayer::kIrradiance && !pass.plan.scene_linear())
    glProgramUniform1f(program, kExposureLocation, pass.veil_exposure() * kWhiteFromIrradiance);
  constexpr float kLargestHalf = 65504, kLargestFloat = 3.4e38f;
  glProgramUniform1ui(program, kCurveLocation, curve);
  glProgramUniform1f(program, kLargestLocation,
                     pass.plan.film_type == SampleType::kFloat16 ? kLargestHalf : kLargestFloat);
  glUseProgram(program);
  draw_screen(pass, frame_of(pass));
}

// Emission is always accumulated, so it is composed already.
void resolve_glow(const PassContext& pass) {
  const bool emission = emission_glows(pass);
  const GLuint program = screen_program(pass, "screen/glow.frag", pass.sum == nullptr && !emission, true, 0);
  set_bloom(program, *pass.plan.bloom);
  glUseProgram(program);
  draw_screen(pass, emission ? pass.targets.emission->color : frame_of(pass));
}

}  // namespace

void pass_accumulate(const PassContext& pass, std::size_t subframe) {
  const std::vector<float>& weights = pass.plan.weights;
  float weight = pass.alone ? 1 : weights[subframe];
  const bool is_lobe = weight < 0 && pass.lobes != nullptr;
  const auto in_one_sum = [&](float other) { return pass.lobes == nullptr || (other < 0) == is_lobe; };
  const auto before = weights.begin() + std::ptrdiff_t(subframe);
  const bool is_first = pass.alone || std::none_of(weights.begin(), before, in_one_sum);
  const ColorTarget& sum = is_lobe ? *pass.lobes : *pass.sum;
  if (is_lobe) weight = -weight;
  gl::PassState state = tile_state(pass, sum.framebuffer, Grid::kPixels);
  state.blend = is_first ? gl::Blend::kOff : gl::Blend::kAdd;
  gl::begin_pass(pass.context, state);
  const GLuint program = screen_program(pass, "screen/accumulate.frag", true, false, 0);
  glProgramUniform1f(program, 0, weight);
  glUseProgram(program);
  draw_screen(pass, pass.targets.shading.color);
}

void pass_limit_lobes(const PassContext& pass) {
  glm::vec2 sums(0);
  for (const float weight : pass.plan.weights) (weight < 0 ? sums.y : sums.x) += std::abs(weight);
  gl::begin_pass(pass.context, tile_state(pass, pass.targets.shading.shade, Grid::kPixels));
  const GLuint program =
      pass.programs.request(pass.context, {"screen/fullscreen.vert", "screen/limit_lobes.frag", 0});
  glProgramUniform3f(program, 0, sums.x, sums.y, float(1 / pass.plan.exposure));
  glUseProgram(program);
  bind_texels(pass.context, pass.residency, 1, pass.lobes->color);
  draw_screen(pass, pass.sum->color);
  pass_keep(pass);
}

void pass_keep(const PassContext& pass) {
  glCopyImageSubData(pass.targets.shading.color.id(), GL_TEXTURE_2D, 0, 0, 0, 0, pass.sum->color.id(),
                     GL_TEXTURE_2D, 0, 0, 0, 0, pass.tile.size.width, pass.tile.size.height, 1);
}

void pass_backdrop(const PassContext& pass) {
  const BackdropTarget& backdrop = *pass.targets.backdrop;
  glCopyImageSubData(pass.sum->color.id(), GL_TEXTURE_2D, 0, 0, 0, 0, backdrop.color.id(), GL_TEXTURE_2D, 0,
                     pass.tile.x, pass.tile.y, 0, pass.tile.size.width, pass.tile.size.height, 1);
}

void pass_glow(const PassContext& pass, const ColorTarget& into) {
  gl::PassState state = tile_state(pass, into.framebuffer, Grid::kPixels);
  state.clear_color = glm::vec4(0);
  gl::begin_pass(pass.context, state);
  if (!pass.plan.bloom) return;
  const GLuint program = resolve_program(pass, pass.sum == nullptr, 0);
  glProgramUniform1ui(program, kCurveLocation, kCurveGlow);
  glUseProgram(program);
  draw_screen(pass, frame_of(pass));
}

void pass_resolve(const PassContext& pass) {
  gl::begin_pass(pass.context, tile_state(pass, pass.targets.film.framebuffer, Grid::kPixels));
  pass.plan.glow_only ? resolve_glow(pass) : resolve_picture(pass);
}

}  // namespace furnace
