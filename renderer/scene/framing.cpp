#include "renderer/scene/framing.hpp"

#include "renderer/scene/scene_vertices.hpp"
#include "renderer/scene/tight_framing.hpp"
#include "renderer/scene/transform.hpp"
#include "renderer/base/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace furnace {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A reversed, infinite depth buffer of floats resolves about 2^-24 of any distance, so the near plane may be
// generous.
constexpr double kNearOfNearest = 0.1;
constexpr double kNearOfFarthest = 1e-5;

Support support_of(const Scene& scene, const glm::dmat3& axes, Slopes slopes) {
  Support support{.slopes = slopes, .x = {}, .y = {}};
  double finite_test = 0;  // stays 0 unless a coordinate is infinite or not a number
  for_each_vertex(scene, axes, [&](const glm::dvec3& p) {
    support.x.add(slopes.x, p.x, p.z);
    support.y.add(slopes.y, p.y, p.z);
    support.add_depth(p.z);
    finite_test += 0 * (p.x + p.y + p.z);
  });
  check_finite_places(finite_test);
  return support;
}

double near_plane(double nearest, double farthest) {
  return std::max(kNearOfNearest * nearest, kNearOfFarthest * farthest);
}

View orbit_perspective(const OrbitCamera& orbit, const glm::dmat3& axes, const SupportOf& support_of_scene,
                       double aspect) {
  const Stand stand = perspective_stand(support_of_scene, orbit_slopes(orbit, aspect));
  const glm::dvec3 eye = axes * stand.eye;
  const double z_near = near_plane(stand.eye.z - stand.z_max, stand.eye.z - stand.z_min);
  return {view_from_axes(axes, eye), perspective_reversed(orbit.fov_y_rad, aspect, z_near, kInfinity),
          glm::vec3(eye), false};
}

View orbit_parallel(const OrbitCamera& orbit, const glm::dmat3& axes, const SupportOf& support_of_scene,
                    double aspect) {
  const Stand stand = parallel_stand(support_of_scene, aspect, orbit.fit);
  const glm::dvec3 eye = axes * stand.eye;
  return {view_from_axes(axes, eye),
          orthographic_reversed(stand.half_height_m * aspect, stand.half_height_m, 0.5 * stand.size_m,
                                1.5 * stand.size_m + stand.z_max - stand.z_min),
          glm::vec3(eye), true};
}

View view_of(const OrbitCamera& orbit, const Scene& scene, double aspect) {
  const glm::dmat3 axes = orbit_axes(orbit);
  const auto support = [&](Slopes slopes) { return support_of(scene, axes, slopes); };
  return orbit.orthographic ? orbit_parallel(orbit, axes, support, aspect)
                            : orbit_perspective(orbit, axes, support, aspect);
}

// Of what an explicit camera sees: its near plane scales with the scene.
struct Depths {
  double nearest, farthest;  // in front of the eye, m
  double size_m;
};
Depths depths_from(const glm::dvec3& eye, const glm::dmat3& axes, const Scene& scene) {
  const Support box = support_of(scene, axes, {0, 0});
  const double eye_z = glm::dot(axes[2], eye), size_m = box.size();
  return {eye_z - box.z_max, std::max(eye_z - box.z_min, size_m), size_m};
}

// Hartley and Zisserman 2004, "Multiple View Geometry in Computer Vision", 6.1: u = cx + fx x / z, in clip space.
View view_of(const IntrinsicsCamera& camera, const Scene& scene, double aspect) {
  const glm::dmat3 axes(glm::mat3_cast(glm::dquat(camera.rotation)));
  const glm::dvec3 eye(camera.translation);
  const double height = camera.picture_px.y, width = height * aspect;
  const double middle_x = camera.principal_px.x + (width - camera.picture_px.x) / 2;
  const Depths depths = depths_from(eye, axes, scene);
  glm::dmat4 clip(perspective_reversed(1, aspect, near_plane(depths.nearest, depths.farthest), kInfinity));
  clip[0][0] = 2 * camera.focal_px.x / width;
  clip[1][1] = 2 * camera.focal_px.y / height;
  clip[2][0] = 1 - 2 * middle_x / width;
  clip[2][1] = 2 * camera.principal_px.y / height - 1;
  return {view_from_axes(axes, eye), glm::mat4(clip), glm::vec3(eye), false};
}

View view_of(const LookAtCamera& camera, const Scene& scene, double aspect) {
  if (camera.eye == camera.target)
    fail(ErrorCode::kUnprocessable, "eye and target are the same point: move one of them",
         "/camera/lookAt/target");
  const glm::mat4 view = look_at(camera.eye, camera.target, camera.up);
  const glm::dmat3 axes(glm::transpose(glm::mat3(view)));
  const Depths depths = depths_from(glm::dvec3(camera.eye), axes, scene);
  if (camera.height_m) {
    const double half = *camera.height_m / 2;
    const double z_near = std::max(0.0, depths.nearest - 0.5 * depths.size_m);
    return {view, orthographic_reversed(half * aspect, half, z_near, depths.farthest + 0.5 * depths.size_m),
            camera.eye, true};
  }
  const double z_near = near_plane(depths.nearest, depths.farthest);
  return {view, perspective_reversed(camera.fov_y_rad, aspect, z_near, kInfinity), camera.eye, false};
}

const CameraNode& find_camera(const GltfCamera& camera, const Scene& scene) {
  const auto& cameras = scene.cameras;
  if (const int* index = std::get_if<int>(&camera.which)) {
    if (*index >= 0 && *index < int(cameras.size())) return cameras[*index];
    fail(ErrorCode::kUnprocessable,
         fmt::format("the scene has {} cameras, counted from 0: there is no camera {}", cameras.size(),
                     *index),
         "/camera/gltf");
  }
  const auto& name = std::get<std::string>(camera.which);
  const auto found =
      std::find_if(cameras.begin(), cameras.end(), [&](const CameraNode& c) { return c.name == name; });
  if (found != cameras.end()) return *found;
  fail(ErrorCode::kUnprocessable,
       fmt::format("none of the scene's {} cameras is named \"{}\"", cameras.size(), name), "/camera/gltf");
}

// glTF 2.0, section 3.10.2: the view is the inverse of the node's global transform without its scale.
glm::dmat3 axes_without_scale(const glm::dmat4& world_from_view) {
  const glm::dvec3 back(world_from_view[2]), up(world_from_view[1]);
  const glm::dvec3 right = glm::cross(up, back);
  if (!(glm::length(right) > 0))
    fail(ErrorCode::kUnprocessable, "the camera's node has a scale of zero: it looks nowhere",
         "/camera/gltf");
  const glm::dvec3 unit_back = glm::normalize(back), unit_right = glm::normalize(right);
  return {unit_right, glm::cross(unit_back, unit_right), unit_back};
}

glm::mat4 clip_from_view(const CameraNode& camera, double aspect) {
  if (camera.orthographic) {
    const double half_height = std::max(camera.half_height, camera.half_width / aspect);
    return orthographic_reversed(half_height * aspect, half_height, camera.z_near, camera.z_far.value());
  }
  const double own_aspect = camera.aspect_ratio.value_or(aspect);
  const double half_tangent = std::tan(camera.fov_y_rad / 2) * std::max(1.0, own_aspect / aspect);
  return perspective_reversed(2 * std::atan(half_tangent), aspect, camera.z_near,
                              camera.z_far.value_or(kInfinity));
}

View view_of(const GltfCamera& spec, const Scene& scene, double aspect) {
  const CameraNode& camera = find_camera(spec, scene);
  const glm::dmat4 world_from_view(camera.world_from_view);
  const glm::dvec3 eye(world_from_view[3]);
  return {view_from_axes(axes_without_scale(world_from_view), eye), clip_from_view(camera, aspect),
          glm::vec3(eye), camera.orthographic};
}

// Along the viewing direction.
double focus_distance(const DepthOfField& spec, const View& view, const Scene& scene) {
  if (spec.focus_distance_m) return *spec.focus_distance_m;
  const glm::dmat3 axes(glm::transpose(glm::mat3(view.view_from_world)));
  const double eye_z = glm::dot(axes[2], glm::dvec3(view.eye));
  if (spec.focus_point) {
    const double distance_m = eye_z - glm::dot(axes[2], glm::dvec3(*spec.focus_point));
    if (distance_m > 0) return distance_m;
    fail(ErrorCode::kUnprocessable, "lies behind the camera: nothing can be focused there",
         "/camera/depthOfField/focusPoint");
  }
  const Support box = support_of(scene, axes, {0, 0});
  const double distance_m = eye_z - (box.z_min + box.z_max) / 2;
  if (distance_m > 0) return distance_m;
  fail(ErrorCode::kUnprocessable,
       "the middle of the scene lies behind the camera: give focusDistanceMetres or focusPoint",
       "/camera/depthOfField");
}

Lens lens_of(const DepthOfField& spec, const View& view, const Scene& scene) {
  if (view.orthographic)
    fail(ErrorCode::kUnprocessable, "an orthographic camera has no lens: leave it out, or the projection",
         "/camera/depthOfField");
  return make_lens(spec, 1 / double(view.clip_from_view[1][1]), focus_distance(spec, view, scene));
}

}  // namespace

// Columns right, up, back; right stays level, so an elevation of +-90 degrees needs no other up vector.
glm::dmat3 orbit_axes(const OrbitCamera& orbit) {
  const double sin_a = std::sin(orbit.azimuth_rad), cos_a = std::cos(orbit.azimuth_rad);
  const double sin_e = std::sin(orbit.elevation_rad), cos_e = std::cos(orbit.elevation_rad);
  const glm::dvec3 right(cos_a, 0, -sin_a);
  const glm::dvec3 back(sin_a * cos_e, sin_e, cos_a * cos_e);
  return {right, glm::cross(back, right), back};
}

Slopes orbit_slopes(const OrbitCamera& orbit, double aspect) {
  const double half = std::tan(orbit.fov_y_rad / 2) / orbit.fit;
  return {half * aspect, half};
}

double aspect_of(Extent picture) {
  return double(picture.width) / picture.height;
}

View make_view(const CameraSpec& camera, const Scene& scene, Extent picture) {
  View view =
      std::visit([&](const auto& kind) { return view_of(kind, scene, aspect_of(picture)); }, camera.view);
  if (camera.depth_of_field) view.lens = lens_of(*camera.depth_of_field, view, scene);
  return view;
}

View through_lens(const View& view, glm::dvec2 place_m) {
  View moved = view;
  const glm::dmat3 axes(glm::transpose(glm::mat3(view.view_from_world)));
  const glm::dvec3 eye = glm::dvec3(view.eye) + axes[0] * place_m.x + axes[1] * place_m.y;
  glm::dmat4 sheared_from_view(1);
  sheared_from_view[2][0] = -place_m.x / view.lens.focus_m;
  sheared_from_view[2][1] = -place_m.y / view.lens.focus_m;
  moved.view_from_world = view_from_axes(axes, eye);
  moved.clip_from_view = glm::mat4(glm::dmat4(view.clip_from_view) * sheared_from_view);
  moved.eye = glm::vec3(eye);
  return moved;
}

}  // namespace furnace
