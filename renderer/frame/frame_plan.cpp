#include "renderer/frame/frame_plan.hpp"

#include "renderer/frame/exposure.hpp"
#include "renderer/frame/pixel_filter.hpp"
#include "renderer/frame/sky_plan.hpp"
#include "renderer/frame/white_balance.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace furnace {
namespace {

std::vector<Tile> cut_tiles(Extent picture, Extent largest) {
  std::vector<Tile> tiles;
  for (int y = 0; y < picture.height; y += largest.height) {
    for (int x = 0; x < picture.width; x += largest.width) {
      tiles.push_back(
          {x, y, {std::min(largest.width, picture.width - x), std::min(largest.height, picture.height - y)}});
    }
  }
  return tiles;
}

double exposure_ev(const CameraSpec& camera, double auto_ev) {
  if (const auto* physical = std::get_if<PhysicalExposure>(&camera.metering))
    return exposure_ev_of_ev100(physical->ev100) + camera.exposure_ev;
  const bool is_auto = std::holds_alternative<AutoExposure>(camera.metering);
  return (is_auto ? auto_ev : 0) + camera.exposure_ev;
}

SampleType film_type(const OutputSpec& output) {
  if (output.format == OutputFormat::kExr) return output.exr_type;
  const bool is_wide = output.format == OutputFormat::kPng && output.bit_depth == 16;
  return is_wide ? SampleType::kUint16 : SampleType::kUint8;
}

std::optional<PlannedGrade> plan_grade(const ColorGrade& grade) {
  if (grade == ColorGrade{}) return std::nullopt;
  return PlannedGrade{glm::mat3(white_balance(grade.white_balance_kelvin, grade.white_balance_tint)),
                      float(grade.contrast), float(grade.saturation)};
}

// Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences": R2.
constexpr double kPlastic = 1.32471795724474602596;
constexpr double kR2StepX = 1 / kPlastic, kR2StepY = 1 / (kPlastic * kPlastic);

// Each source of film layers has a target as large as a tile: of more than so many tiles are smaller.
constexpr std::size_t kManySources = 8;
constexpr int kTileOfManyPx = 512;

}  // namespace

glm::vec2 r2_offset(int i) {
  const double x = 0.5 + i * kR2StepX, y = 0.5 + i * kR2StepY;
  return {float(x - std::floor(x) - 0.5), float(y - std::floor(y) - 0.5)};
}

namespace {

// Along one axis: so many places `step` apart, moved round [0, 1) together until their mean is the middle. Without that four of R2
// shift a picture by a fifth of a pixel.
std::vector<double> balanced_places(int count, double step) {
  std::vector<double> places;
  for (int i = 0; i < count; ++i) places.push_back(i * step - std::floor(i * step));
  std::vector<double> sorted = places;
  std::sort(sorted.begin(), sorted.end());
  const double mean = std::accumulate(sorted.begin(), sorted.end(), 0.0) / count;
  // Moved by t, those from 1 - t on come round; with k of them the mean is mean + t - k / count.
  double shift = 0.5;
  for (int k = 0; k < count; ++k) {
    const double t = 0.5 - mean + double(k) / count, border = 1 - t;
    if (t < 0) continue;
    if (sorted[std::size_t(count - k - 1)] < border && (k == 0 || sorted[std::size_t(count - k)] >= border)) {
      shift = t;
      break;
    }
  }
  for (double& place : places) {
    place += shift;
    place -= std::floor(place);
  }
  return places;
}

}  // namespace

void set_picture(FramePlan& plan, Extent picture, Extent largest_tile) {
  plan.picture = picture;
  plan.tile_size = {std::min(largest_tile.width, picture.width),
                    std::min(largest_tile.height, picture.height)};
  plan.tiles = cut_tiles(picture, plan.tile_size);
}

FramePlan scaled_plan(FramePlan plan, int max_side_px) {
  const double scale = std::min(1.0, double(max_side_px) / std::max(plan.picture.width, plan.picture.height));
  const auto scaled = [&](int side) { return std::max(1, int(std::lround(side * scale))); };
  set_picture(plan, {scaled(plan.picture.width), scaled(plan.picture.height)}, plan.tile_size);
  return plan;
}

void set_samples(FramePlan& plan, int count, const PixelFilter& filter) {
  plan.jitter_px.clear();
  const std::vector<double> x = balanced_places(count, kR2StepX), y = balanced_places(count, kR2StepY);
  for (std::size_t i = 0; i < x.size(); ++i) plan.jitter_px.emplace_back(x[i] - 0.5, y[i] - 0.5);
  plan.weights = warp_by_filter(filter, plan.jitter_px);
}

FramePlan plan_frame(const RenderSpec& spec, int max_tile_px, double auto_ev) {
  FramePlan plan;
  plan.layers = plan_layers(spec.output);
  if (plan.layers.sources.size() > kManySources) max_tile_px = std::min(max_tile_px, kTileOfManyPx);
  set_picture(plan, {spec.output.width, spec.output.height}, {max_tile_px, max_tile_px});
  set_samples(plan, spec.output.samples, spec.output.pixel_filter);

  plan.exposure_ev = exposure_ev(spec.camera, auto_ev);
  plan.exposure = std::exp2(plan.exposure_ev);
  const EnvironmentSpec& environment = spec.environment;
  plan.opaque = !std::holds_alternative<TransparentBackground>(environment.background);
  plan.environment_rotation_rad = plan.background_rotation_rad = environment.rotation_rad;
  plan.grade = plan_grade(spec.output.grade);
  // Colours are the picture's: neither exposure nor the light that shall look white must change them.
  const glm::mat3 unbalanced = plan.grade ? glm::inverse(plan.grade->white_balance) : glm::mat3(1);
  const auto unexposed = [&](const glm::vec3& color) {
    return glm::vec4(unbalanced * color / float(plan.exposure), 1);
  };
  if (const auto* seen = std::get_if<EnvironmentBackground>(&environment.background)) {
    plan.background_rotation_rad = seen->rotation_rad.value_or(environment.rotation_rad);
  } else if (const auto* one = std::get_if<ColorBackground>(&environment.background)) {
    plan.background_top = plan.background_bottom = unexposed(one->color);
  } else if (const auto* gradient = std::get_if<GradientBackground>(&environment.background)) {
    plan.background_top = unexposed(gradient->top);
    plan.background_bottom = unexposed(gradient->bottom);
  }
  if (environment.ground) {
    plan.shadow_strength = environment.ground->shadow_strength;
    plan.projection = environment.ground->projection;
  }
  plan.sky_shadows = sky_is_shadowed(spec);
  if (const auto& bloom = spec.output.bloom; bloom && plan.layers.needs_picture())
    plan.bloom = PlannedBloom{bloom->source, float(bloom->intensity), float(bloom->threshold), {}};
  plan.tone_map = spec.output.tone_map;
  plan.film_type = film_type(spec.output);
  plan.dither = spec.output.dither && plan.film_type == SampleType::kUint8;
  return plan;
}

}  // namespace furnace
