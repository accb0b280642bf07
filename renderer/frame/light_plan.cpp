#include "renderer/frame/light_plan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <glm/gtc/matrix_transform.hpp>

#include "renderer/base/check.hpp"
#include "renderer/scene/transform.hpp"

namespace furnace {
namespace {

constexpr int kFewViews = 6;  // of a point light, or of all lights of most scenes
constexpr int kFinePx = 1024, kCoarsePx = 512;
constexpr double kMarginPx = 4;  // round what a view must hold, for the filter

// Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences": place i in the unit disc, by areas.
glm::dvec2 disc_place(int i) {
  constexpr double kPlastic = 1.32471795724474602596;
  const auto fraction = [](double x) { return x - std::floor(x); };
  const double radius = std::sqrt(fraction(0.5 + i / kPlastic));
  const double angle = 2 * kPi * fraction(0.5 + i / (kPlastic * kPlastic));
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

// Two axes across a unit vector.
std::array<glm::dvec3, 2> axes_across(const glm::dvec3& along) {
  const glm::dvec3 other = std::abs(along.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
  const glm::dvec3 across = glm::normalize(glm::cross(other, along));
  return {across, glm::cross(along, across)};
}

struct ShadowView {
  glm::dmat4 clip_from_world{1};
  double penumbra = 0;  // LightRow::shadow.y
  double texel_m = 0;   // LightRow::shadow.z
};

ShadowView directional_view(const glm::dvec3& direction, double angular_radius_rad, const Bounds& scene,
                            int side_px) {
  const glm::dvec3 centre = glm::dvec3(scene.min + scene.max) * 0.5;
  const double radius = std::max(glm::length(glm::dvec3(scene.max - scene.min)) * 0.5, 1e-9);
  const double half = radius / (1 - 2 * kMarginPx / side_px);
  const double depth = 2.02 * radius;
  const glm::dvec3 eye = centre - direction * (1.01 * radius);
  const glm::dmat4 view(look_at(glm::vec3(0), glm::vec3(direction), glm::vec3(0, 1, 0)));
  ShadowView out;
  out.clip_from_world = glm::dmat4(orthographic_reversed(half, half, 0, depth)) * glm::translate(view, -eye);
  out.texel_m = 2 * half / side_px;
  // Reversed, linear depth: two texels' depths differ by 1 over `depth` metres.
  out.penumbra = depth * std::tan(angular_radius_rad) / (2 * half);
  return out;
}

ShadowView perspective_view(const glm::dvec3& eye, const glm::dvec3& direction, double half_angle_rad,
                            double radius_m, const Bounds& scene, int side_px) {
  const double reach = glm::length(glm::dvec3(scene.max - scene.min)) +
                       glm::length(glm::dvec3(scene.min + scene.max) * 0.5 - eye);
  const double near_m = std::max(1e-4 * reach, 1e-9);
  const double tangent = std::tan(half_angle_rad) / (1 - 2 * kMarginPx / side_px);
  const glm::dmat4 view(look_at(glm::vec3(0), glm::vec3(direction), glm::vec3(0, 1, 0)));
  ShadowView out;
  out.clip_from_world = glm::dmat4(perspective_reversed(2 * std::atan(tangent), 1, near_m,
                                                        std::numeric_limits<double>::infinity())) *
                        glm::translate(view, -eye);
  out.texel_m = 2 * tangent / side_px;
  // Depth is near / distance: a penumbra of radius R (1 / blocker - 1 / receiver) on a plane 1 m away.
  out.penumbra = radius_m / (2 * tangent * near_m);
  return out;
}

// Place i in the unit ball so that from every side the places fill the ball's disc evenly: by Abel's transform of an even
// disc their density is 1 / sqrt(1 - r^2), so with r = sin t the share within t is (2 t - sin 2t) / pi.
glm::dvec3 ball_place(int i) {
  constexpr double kRoot = 1.22074408460575947536;  // of x^4 = x + 1: Roberts' sequence in three dimensions
  const auto fraction = [](double x) { return x - std::floor(x); };
  const double share = fraction(0.5 + i / kRoot);
  double low = 0, high = kPi / 2;
  for (int step = 0; step < 50; ++step) {
    const double middle = (low + high) / 2;
    (2 * middle - std::sin(2 * middle) < share * kPi ? low : high) = middle;
  }
  const double up = 2 * fraction(0.5 + i / (kRoot * kRoot)) - 1, across = std::sqrt(1 - up * up);
  const double angle = 2 * kPi * fraction(0.5 + i / (kRoot * kRoot * kRoot));
  return std::sin(low) * glm::dvec3(across * std::cos(angle), up, across * std::sin(angle));
}

struct LightViews {
  glm::dvec3 eye{0};
  std::vector<ShadowView> views;
};

// Of a light that shines from one place of its disc or ball, or (`lone`) from all of it.
LightViews views_of(const Light& light, const Bounds& scene, int side_px, int subframe, bool lone) {
  const auto [across, up] = axes_across(light.direction);
  const glm::dvec2 place = lone ? glm::dvec2(0) : disc_place(subframe);
  const glm::dvec3 offset = across * place.x + up * place.y;
  const double radius_m = lone ? light.radius_m : 0;
  if (light.kind == LightKind::kDirectional) {
    const glm::dvec3 direction =
        glm::normalize(light.direction + offset * std::tan(light.angular_radius_rad));
    return {{}, {directional_view(direction, lone ? light.angular_radius_rad : 0, scene, side_px)}};
  }
  if (light.kind == LightKind::kSpot) {
    constexpr double kWidest = 1.5;  // rad: a cone of 90 degrees has no perspective
    const glm::dvec3 eye = light.position + offset * light.radius_m;
    const double half_angle = std::min(light.outer_cone_rad, kWidest);
    return {eye, {perspective_view(eye, light.direction, half_angle, radius_m, scene, side_px)}};
  }
  LightViews seen;
  seen.eye = light.position + (lone ? glm::dvec3(0) : ball_place(subframe) * light.radius_m);
  for (int face = 0; face < 6; ++face) {
    glm::dvec3 direction(0);
    direction[face / 2] = face % 2 == 0 ? 1 : -1;
    seen.views.push_back(perspective_view(seen.eye, direction, kPi / 4, radius_m, scene, side_px));
  }
  return seen;
}

gpu::LightRow row_of(const Light& light) {
  gpu::LightRow row{};
  const bool directional = light.kind == LightKind::kDirectional;
  row.place = directional ? glm::vec4(-light.direction, 0) : glm::vec4(light.position, 1);
  row.intensity = glm::vec4(light.intensity, 0);
  if (light.range_m && !directional) row.intensity.w = float(1 / (*light.range_m * *light.range_m));
  row.axis = glm::vec4(light.direction, directional ? light.angular_radius_rad : light.radius_m);
  row.cone = {0, 1, 0, 0};
  if (light.kind == LightKind::kSpot) {
    // KHR_lights_punctual, as it recommends.
    const double outer = std::cos(light.outer_cone_rad), inner = std::cos(light.inner_cone_rad);
    const double scale = 1 / std::max(0.001, inner - outer);
    row.cone = glm::vec4(scale, -outer * scale, 0, 0);
  }
  row.shadow = {-1, 0, 0, 0};
  return row;
}

int views_wanted(const Light& light) {
  if (!light.casts_shadow) return 0;
  return light.kind == LightKind::kPoint ? 6 : 1;
}

}  // namespace

LightPlan plan_lights(const std::vector<Light>& lights, const Bounds& scene, glm::vec2 tile_px, int subframe,
                      int subframes) {
  FURNACE_CHECK(lights.size() <= gpu::MOST_LIGHTS, "{} lights", lights.size());
  int wanted = 0;
  for (const Light& light : lights) wanted += views_wanted(light);
  LightPlan plan;
  plan.block = {};
  plan.side_px = wanted <= kFewViews ? kFinePx : kCoarsePx;
  plan.block.tile_x = tile_px.x;
  plan.block.tile_y = tile_px.y;
  plan.block.count = gpu::uint(lights.size());
  plan.block.shadow_texel = 1.f / float(plan.side_px);
  for (std::size_t i = 0; i < lights.size(); ++i) {
    gpu::LightRow& row = plan.block.lights[i];
    row = row_of(lights[i]);
    const int views = views_wanted(lights[i]);
    if (views == 0 || scene.empty() || plan.views + views > int(gpu::MOST_SHADOW_VIEWS)) continue;
    const LightViews seen = views_of(lights[i], scene, plan.side_px, subframe, subframes == 1);
    const ShadowView& first = seen.views.front();
    row.shadow = {float(plan.views), float(first.penumbra), float(first.texel_m), float(views)};
    row.eye = glm::vec4(seen.eye, 0);
    for (const ShadowView& view : seen.views)
      plan.block.shadow_from_world[plan.views++] = glm::mat4(view.clip_from_world);
  }
  return plan;
}

}  // namespace furnace
