#include "renderer/frame/light_plan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <glm/gtc/matrix_transform.hpp>

#include "renderer/base/check.hpp"
#include "renderer/frame/light_places.hpp"
#include "renderer/frame/light_polygon.hpp"
#include "renderer/scene/transform.hpp"

namespace furnace {
namespace {

constexpr int kFewViews = 6;  // of a point light, or of all lights of most scenes
constexpr int kFinePx = 1024, kCoarsePx = 512;
constexpr double kMarginPx = 4;  // round what a view must hold, for the filter

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

struct Ball {
  glm::dvec3 centre{0};
  double radius = 0;
};
Ball ball_round(const Bounds& scene) {
  return {glm::dvec3(scene.min + scene.max) * 0.5,
          std::max(glm::length(glm::dvec3(scene.max - scene.min)) * 0.5, 1e-9)};
}

// Of a disc as large as what is seen of the light.
double radius_of_disc(const Light& light) {
  return light.kind == LightKind::kRectangle ? std::sqrt(light.width_m * light.height_m / kPi)
                                             : light.radius_m;
}

// From outside, one view takes in the scene, where it must not be wider than a cube's.
bool sees_all_at_once(const Light& light, const Bounds& scene) {
  const Ball ball = ball_round(scene);
  return glm::length(ball.centre - light.position) - extent_m(light) > 1.25 * ball.radius;
}

struct LightViews {
  glm::dvec3 eye{0};
  std::vector<ShadowView> views;
};

// Of a light that shines from the middle of it, or in several sub-frames from one place of its surface, disc or ball each.
// `part`: of a flat light, what of it shines.
LightViews views_of(const Light& light, const LightPolygon& part, const Bounds& scene, int side_px,
                    int subframe, int subframes) {
  const LightAxes axes = axes_of_light(light);
  const bool lone = subframes == 1;
  const glm::dvec2 place = lone ? glm::dvec2(0) : disc_place(subframe);
  const glm::dvec3 offset = axes.x * place.x + axes.y * place.y;
  // Each place stands for its share of the light.
  const double share = 1 / std::sqrt(subframes);
  const double radius_m = radius_of_disc(light) * share;
  if (light.kind == LightKind::kDirectional) {
    const glm::dvec3 direction =
        glm::normalize(light.direction + offset * std::tan(light.angular_radius_rad));
    return {{}, {directional_view(direction, light.angular_radius_rad * share, scene, side_px)}};
  }
  if (light.kind == LightKind::kSpot) {
    constexpr double kWidest = 1.5;  // rad: a cone of 90 degrees has no perspective
    const glm::dvec3 eye = light.position + offset * light.radius_m;
    const double half_angle = std::min(light.outer_cone_rad, kWidest);
    return {eye, {perspective_view(eye, light.direction, half_angle, radius_m, scene, side_px)}};
  }
  LightViews seen;
  seen.eye = light.position;
  if (light.kind == LightKind::kDisc || light.kind == LightKind::kRectangle) {
    const glm::dvec2 middle = centroid(part);
    seen.eye += axes.x * middle.x + axes.y * middle.y;
  } else if (!lone) {
    seen.eye += ball_place(subframe) * light.radius_m;
  }
  if (sees_all_at_once(light, scene)) {
    const Ball ball = ball_round(scene);
    const glm::dvec3 to_scene = ball.centre - seen.eye;
    const double half_angle = std::asin(std::min(ball.radius / glm::length(to_scene), 0.99));
    seen.views.push_back(
        perspective_view(seen.eye, glm::normalize(to_scene), half_angle, radius_m, scene, side_px));
    return seen;
  }
  // Filters of wide lights reach that far beyond a face: shaders/surface/lights.glsl.
  constexpr double kReach = 0.08;
  const double half_angle = radius_m > 0 ? std::atan(1 / (1 - 2 * kReach)) : kPi / 4;
  for (int face = 0; face < 6; ++face) {
    glm::dvec3 direction(0);
    direction[face / 2] = face % 2 == 0 ? 1 : -1;
    seen.views.push_back(perspective_view(seen.eye, direction, half_angle, radius_m, scene, side_px));
  }
  return seen;
}

gpu::LightRow row_of(const Light& light) {
  gpu::LightRow row{};
  const bool directional = light.kind == LightKind::kDirectional;
  row.place =
      directional ? glm::vec4(-light.direction, gpu::LIGHT_FAR) : glm::vec4(light.position, gpu::LIGHT_PLACE);
  row.intensity = glm::vec4(light.intensity, 0);
  if (light.range_m && !directional) row.intensity.w = float(1 / (*light.range_m * *light.range_m));
  row.axis = glm::vec4(light.direction, directional ? light.angular_radius_rad : radius_of_disc(light));
  row.cone = {0, 1, 0, 0};
  row.across = glm::vec4(axes_of_light(light).x, 0);
  if (light.kind == LightKind::kSpot) {
    // KHR_lights_punctual, as it recommends.
    const double outer = std::cos(light.outer_cone_rad), inner = std::cos(light.inner_cone_rad);
    const double scale = 1 / std::max(0.001, inner - outer);
    row.cone = glm::vec4(scale, -outer * scale, 0, 0);
  }
  row.shadow = {-1, 0, 0, 0};
  return row;
}

int views_wanted(const Light& light, const Bounds& scene) {
  if (!light.casts_shadow || scene.empty()) return 0;
  const bool aimed = light.kind == LightKind::kDirectional || light.kind == LightKind::kSpot;
  return aimed || sees_all_at_once(light, scene) ? 1 : 6;
}

// A sub-frame takes one part of a flat light, the others in an order that leaps, so that parts and places within the pixel do not
// go hand in hand. A ball is whole in each.
LightPolygon part_of(const Light& light, int subframe, int subframes) {
  const LightPolygon outline = outline_of(light);
  if (subframes == 1 || light.kind == LightKind::kSphere) return outline;
  int leap = std::max(1, int(std::lround(subframes * 0.618)));
  while (std::gcd(leap, subframes) != 1) ++leap;
  return equal_part(outline, subframes, int(std::int64_t(subframe) * leap % subframes));
}

glm::dvec2 half_size(const Light& light) {
  return light.kind == LightKind::kRectangle ? glm::dvec2(light.width_m, light.height_m) * 0.5
                                             : glm::dvec2(light.radius_m);
}

// Gives the first row that is free after them.
int write_corners(const LightPolygon& polygon, glm::dvec2 unit, int row, gpu::LightBlock& block) {
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    glm::vec4& two = block.corners[row + int(i) / 2];
    const glm::vec2 corner = polygon[i] / unit;
    (i % 2 == 0 ? two.x : two.z) = corner.x;
    (i % 2 == 0 ? two.y : two.w) = corner.y;
  }
  return row + int(polygon.size() + 1) / 2;
}

void write_whole_outlines(gpu::LightBlock& block) {
  Light unit;
  unit.radius_m = 1;
  unit.width_m = unit.height_m = 2;
  int row = 0;
  for (const LightKind kind : {LightKind::kDisc, LightKind::kRectangle}) {
    unit.kind = kind;
    row = write_corners(outline_of(unit), glm::dvec2(1), row, block);
  }
}

float place_of(LightKind kind) {
  return kind == LightKind::kSphere ? gpu::LIGHT_BALL
         : kind == LightKind::kDisc ? gpu::LIGHT_DISC
                                    : gpu::LIGHT_RECTANGLE;
}

// What of a surface's row is its own. `row`: free of corners from there on; gives the first that still is.
int set_surface(const Light& light, const LightPolygon& part, int parts, int row, gpu::LightBlock& block,
                gpu::LightRow& out) {
  const glm::dvec2 half = half_size(light);
  const bool ball = light.kind == LightKind::kSphere;
  out.place.w = place_of(light.kind);
  out.intensity.w = ball ? 1.f : float(parts);
  out.cone = glm::vec4(ball ? 0 : row, part.size(), half);
  out.across.w = light.two_sided;
  if (!ball && parts > 1) out.eye.w = float(std::sqrt(area(part) / kPi));
  return ball ? row : write_corners(part, half, row, block);
}

}  // namespace

LightPlan plan_lights(const std::vector<Light>& lights, const Bounds& scene, glm::vec2 tile_px, int subframe,
                      int subframes) {
  FURNACE_CHECK(lights.size() <= gpu::MOST_LIGHTS, "{} lights", lights.size());
  int wanted = 0;
  for (const Light& light : lights) wanted += views_wanted(light, scene);
  LightPlan plan;
  plan.block = {};
  plan.side_px = wanted <= kFewViews ? kFinePx : kCoarsePx;
  // Jimenez 2016, "Filmic SMAA": so far the noise moves that another sub-frame adds to it best.
  plan.block.tile_x = tile_px.x + 5.588238f * float(subframe);
  plan.block.tile_y = tile_px.y;
  plan.block.count = gpu::uint(lights.size());
  plan.block.shadow_texel = 1.f / float(plan.side_px);
  write_whole_outlines(plan.block);
  int free_row = int(gpu::FREE_ROW), profiles = 0;
  for (std::size_t i = 0; i < lights.size(); ++i) {
    gpu::LightRow& row = plan.block.lights[i];
    row = row_of(lights[i]);
    if (lights[i].profile != nullptr) row.across.w = float(gpu::FIRST_PROFILE + gpu::uint(profiles++));
    LightPolygon part;
    if (lights[i].is_surface()) {
      part = part_of(lights[i], subframe, subframes);
      free_row = set_surface(lights[i], part, subframes, free_row, plan.block, row);
    }
    const int views = views_wanted(lights[i], scene);
    if (views == 0 || plan.views + views > int(gpu::MOST_SHADOW_VIEWS)) continue;
    const LightViews seen = views_of(lights[i], part, scene, plan.side_px, subframe, subframes);
    const ShadowView& first = seen.views.front();
    row.shadow = {float(plan.views), float(first.penumbra), float(first.texel_m), float(views)};
    row.eye = glm::vec4(seen.eye, row.eye.w);
    for (const ShadowView& view : seen.views)
      plan.block.shadow_from_world[plan.views++] = glm::mat4(view.clip_from_world);
  }
  return plan;
}

}  // namespace furnace
