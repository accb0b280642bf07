#include "renderer/frame/sky_plan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "renderer/base/check.hpp"
#include "renderer/scene/transform.hpp"

namespace furnace {
namespace {

constexpr double kMarginPx = 4;  // round the scene, for the filter
// Off the surface: a texel holds the depth of its middle, at most half its diagonal away.
constexpr double kLiftTexels = 1;

struct Span {
  double low = std::numeric_limits<double>::infinity(), high = -low;

  double length() const { return high - low; }
};

Span span_along(const glm::dvec3& axis, const Bounds& scene) {
  Span span;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 at(corner & 1 ? scene.max.x : scene.min.x, corner & 2 ? scene.max.y : scene.min.y,
                        corner & 4 ? scene.max.z : scene.min.z);
    const double along = glm::dot(axis, at);
    span.low = std::min(span.low, along);
    span.high = std::max(span.high, along);
  }
  return span;
}

// The row that takes (position, 1) to 0 .. 1 over the span.
glm::dvec4 row_of(const glm::dvec3& axis, const Span& span) {
  return {axis / span.length(), -span.low / span.length()};
}

// Two axes across a unit vector. Duff et al. 2017, "Building an Orthonormal Basis, Revisited".
std::array<glm::dvec3, 2> axes_across(const glm::dvec3& n) {
  const double sign = std::copysign(1.0, n.z), a = -1 / (sign + n.z), b = n.x * n.y * a;
  return {glm::dvec3(1 + sign * n.x * n.x * a, sign * b, -sign * n.x),
          glm::dvec3(b, sign + n.y * n.y * a, -n.y)};
}

glm::dvec3 vector_of(const std::array<double, 3>& v) {
  return {v[0], v[1], v[2]};
}

// Of every cell, in each colour.
glm::dvec3 even_radiance(const std::vector<LightDirection>& lights) {
  glm::dvec3 least(std::numeric_limits<double>::infinity());
  for (const LightDirection& light : lights)
    least = glm::min(least, vector_of(light.irradiance) / light.solid_angle_sr);
  return least;
}

}  // namespace

bool sky_is_shadowed(const RenderSpec& spec) {
  const EnvironmentVisibility asked = spec.environment.visibility;
  return asked == EnvironmentVisibility::kOn ||
         (asked == EnvironmentVisibility::kAuto && spec.output.samples >= kVisibilitySamples);
}

int sky_views_wanted(int subframes, std::size_t triangles) {
  // Large faces show the shadow of each direction, and are cheap to draw; of a finely tessellated scene it is the maps that cost.
  constexpr std::size_t kFew = 1'000, kMany = 80'000;
  const int at_16_subframes = triangles <= kFew ? 32 : triangles <= kMany ? 16 : 8;
  // A few sub-frames take more each.
  return std::clamp(at_16_subframes * kVisibilitySamples / subframes, std::max(at_16_subframes / 2, 8),
                    int(gpu::MOST_SKY_VIEWS));
}

SkyPlan plan_sky(const std::vector<LightDirection>& lights, const Bounds& scene, double least_alpha,
                 int first_layer, int side_px, int subframe, int subframes) {
  const std::size_t step = std::size_t(subframes), count = lights.size() / step;
  FURNACE_CHECK(count > 0 && count <= gpu::MOST_SKY_VIEWS && count * step == lights.size(),
                "{} directions for {} sub-frames", lights.size(), subframes);
  SkyPlan plan;
  plan.block = {};
  plan.block.count = gpu::uint(count);
  plan.block.map_px = float(side_px);
  plan.block.first_layer = gpu::uint(first_layer);
  plan.block.least_alpha = float(least_alpha);
  plan.block.even = glm::vec4(even_radiance(lights), 0);
  const double least = std::max(double(glm::length(scene.max - scene.min)) * 1e-3, 1e-9);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t k = std::size_t(subframe) + i * step;
    const LightDirection& light = lights[k];
    const glm::dvec3 towards = vector_of(light.towards);
    // Each map is turned its own way about its direction: their texels' steps average out.
    const double turn = 2 * kPi * double(k) / 1.61803398874989484820;
    const auto [x, y] = axes_across(towards);
    const std::array<glm::dvec3, 3> axes = {std::cos(turn) * x + std::sin(turn) * y,
                                            std::cos(turn) * y - std::sin(turn) * x, towards};
    std::array<glm::dvec4, 3> rows;
    double texel_m = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Span span = span_along(axes[axis], scene);
      const double margin = std::max(span.length(), least) * kMarginPx / (side_px - 2 * kMarginPx);
      span = {span.low - margin, span.high + margin};
      rows[axis] = row_of(axes[axis], span);
      if (axis < 2) texel_m = std::max(texel_m, span.length() / side_px);
    }
    gpu::SkyView& view = plan.block.views[i];
    view.towards = glm::vec4(towards, kLiftTexels * texel_m);
    view.light = glm::vec4(vector_of(light.irradiance) * double(step), light.solid_angle_sr * double(step));
    view.map_u = glm::vec4(rows[0]);
    view.map_v = glm::vec4(rows[1]);
    view.map_depth = glm::vec4(rows[2]);
    const glm::dvec4 one(0, 0, 0, 1);
    // Rows of the map grow downwards, clip space upwards.
    plan.clip_from_world.push_back(
        glm::mat4(glm::transpose(glm::dmat4(2.0 * rows[0] - one, one - 2.0 * rows[1], rows[2], one))));
  }
  return plan;
}

}  // namespace furnace
