#include "renderer/scene/framing.hpp"

#include "renderer/scene/transform.hpp"
#include "renderer/base/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace furnace {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Of the scene's size: an eye this near still has a sound near plane, and no usual picture notices (it takes
// a spike that points at the eye, or an angle of view beyond 170 degrees).
constexpr double kClearance = 1e-3;
// A reversed, infinite depth buffer of floats resolves about 2^-24 of any distance, so the near plane may be
// generous.
constexpr double kNearOfNearest = 0.1;
constexpr double kNearOfFarthest = 1e-5;

double aspect_of(Extent picture) {
  return double(picture.width) / picture.height;
}

// Calls visit(p) for every vertex, in the frame whose axes are the columns of `axes`; an empty scene is the
// unit cube.
template <class Visit>
void for_each_vertex(const Scene& scene, const glm::dmat3& axes, Visit&& visit) {
  const glm::dmat3 axes_from_world = glm::transpose(axes);
  bool empty = true;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    if (mesh.indices.empty()) continue;
    const glm::dmat4 world_from_model(instance.world_from_model);
    const glm::dmat3 linear = axes_from_world * glm::dmat3(world_from_model);
    const glm::dvec3 origin = axes_from_world * glm::dvec3(world_from_model[3]);
    for (const glm::vec3& position : mesh.positions) visit(linear * glm::dvec3(position) + origin);
    empty = empty && mesh.positions.empty();
  }
  if (!empty) return;
  for (int corner = 0; corner < 8; ++corner)
    visit(axes_from_world * (glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1) - 0.5));
}

// The vertex that a frame plane touches first: it maximises +-a + slope * z, a = x or y.
struct Touch {
  double reach = -kInfinity;
  double a = 0, z = 0;

  void add(double point_reach, double point_a, double point_z) {
    if (point_reach > reach) *this = {point_reach, point_a, point_z};
  }
};

// Both frame planes of one picture axis: all vertices satisfy +-a <= reach - slope * z.
struct Slab {
  Touch plus, minus;

  void add(double slope, double a, double z) {
    plus.add(a + slope * z, a, z);
    minus.add(-a + slope * z, a, z);
  }
  // The nearest eye depth at which both planes of this slope pass through one point outside.
  double eye_z(double slope) const { return (plus.reach + minus.reach) / (2 * slope); }
  double centre() const { return (plus.reach - minus.reach) / 2; }
};

struct Slopes {
  double x, y;  // tangents of the half angles of view, divided by `fit`; 0: parallel projection
};

struct Support {
  Slopes slopes;
  Slab x, y;
  double z_min = kInfinity, z_max = -kInfinity;  // z points to the eye

  // The diagonal of the scene, its width and height those of the frame at the farthest vertex; 1 m for a
  // single point, which has no scale of its own.
  double size() const {
    const double width = x.plus.reach + x.minus.reach - 2 * slopes.x * z_min;
    const double height = y.plus.reach + y.minus.reach - 2 * slopes.y * z_min;
    const double diagonal = std::hypot(width, height, z_max - z_min);
    const double rounding = 1e-12 * (std::abs(x.plus.reach) + std::abs(y.plus.reach) + std::abs(z_max));
    return diagonal > rounding ? diagonal : 1;
  }
};

Support support_of(const Scene& scene, const glm::dmat3& axes, Slopes slopes) {
  Support support{.slopes = slopes, .x = {}, .y = {}};
  double finite_test = 0;  // stays 0 unless a coordinate is infinite or not a number
  for_each_vertex(scene, axes, [&](const glm::dvec3& p) {
    support.x.add(slopes.x, p.x, p.z);
    support.y.add(slopes.y, p.y, p.z);
    support.z_min = std::min(support.z_min, p.z);
    support.z_max = std::max(support.z_max, p.z);
    finite_test += 0 * (p.x + p.y + p.z);
  });
  if (std::isnan(finite_test))
    fail(ErrorCode::kUnprocessable, "a vertex of the scene has no finite place: no camera can frame it",
         "/camera");
  return support;
}

// The slope at which the planes of an axis meet at the depth `eye_z`. The gap between planes is a convex,
// piecewise linear function of the slope, so that Newton's steps reach its root exactly after a few
// (Dinkelbach 1967, "On nonlinear fractional programming", for the same iteration).
double touching_slope(const Slab& slab, double eye_z) {
  const double depths = 2 * eye_z - slab.plus.z - slab.minus.z;
  return std::max(0.0, (slab.plus.a - slab.minus.a) / depths);
}

// Centres the picture: where the eye stands off farther than an axis needs, that axis' planes are narrowed
// until they touch.
Support centred_support(const Scene& scene, const glm::dmat3& axes, Support support, double eye_z) {
  constexpr int kSteps = 16;
  for (int i = 0; i < kSteps; ++i) {
    const Slopes last = support.slopes,
                 next{touching_slope(support.x, eye_z), touching_slope(support.y, eye_z)};
    const double change = std::max(std::abs(next.x - last.x), std::abs(next.y - last.y));
    if (change <= 1e-9 * std::max(last.x, last.y)) break;
    support = support_of(scene, axes, next);
  }
  return support;
}

// Columns right, up, back; right stays level, so an elevation of +-90 degrees needs no other up vector.
glm::dmat3 orbit_axes(const OrbitCamera& orbit) {
  const double sin_a = std::sin(orbit.azimuth_rad), cos_a = std::cos(orbit.azimuth_rad);
  const double sin_e = std::sin(orbit.elevation_rad), cos_e = std::cos(orbit.elevation_rad);
  const glm::dvec3 right(cos_a, 0, -sin_a);
  const glm::dvec3 back(sin_a * cos_e, sin_e, cos_a * cos_e);
  return {right, glm::cross(back, right), back};
}

double near_plane(double nearest, double farthest) {
  return std::max(kNearOfNearest * nearest, kNearOfFarthest * farthest);
}

// Tight perspective framing by support planes: each side plane of the frame is pushed against the vertices,
// opposite planes meet in a line of possible eyes, and the farther of both axes' lines decides.
View orbit_perspective(const OrbitCamera& orbit, const glm::dmat3& axes, const Scene& scene, double aspect) {
  const double half = std::tan(orbit.fov_y_rad / 2) / orbit.fit;
  const Slopes slopes{half * aspect, half};
  const Support tight = support_of(scene, axes, slopes);
  const double eye_z =
      std::max({tight.x.eye_z(slopes.x), tight.y.eye_z(slopes.y), tight.z_max + kClearance * tight.size()});
  const Support support = centred_support(scene, axes, tight, eye_z);

  const glm::dvec3 eye = axes * glm::dvec3(support.x.centre(), support.y.centre(), eye_z);
  const double z_near = near_plane(eye_z - tight.z_max, eye_z - tight.z_min);
  return {view_from_axes(axes, eye), perspective_reversed(orbit.fov_y_rad, aspect, z_near, kInfinity),
          glm::vec3(eye), false};
}

View orbit_orthographic(const OrbitCamera& orbit, const glm::dmat3& axes, const Scene& scene, double aspect) {
  const Support box = support_of(scene, axes, {0, 0});
  const double size = box.size();
  const double half_width = (box.x.plus.reach + box.x.minus.reach) / 2;
  const double half_height = (box.y.plus.reach + box.y.minus.reach) / 2;
  const double half = std::max({half_height, half_width / aspect, kClearance * size}) * orbit.fit;
  const glm::dvec3 eye = axes * glm::dvec3(box.x.centre(), box.y.centre(), box.z_max + size);
  const double depth = box.z_max - box.z_min;
  return {view_from_axes(axes, eye),
          orthographic_reversed(half * aspect, half, 0.5 * size, 1.5 * size + depth), glm::vec3(eye), true};
}

View view_of(const OrbitCamera& orbit, const Scene& scene, double aspect) {
  const glm::dmat3 axes = orbit_axes(orbit);
  return orbit.orthographic ? orbit_orthographic(orbit, axes, scene, aspect)
                            : orbit_perspective(orbit, axes, scene, aspect);
}

// A near plane for an explicit camera: it scales with the scene.
double near_plane_from(const glm::dvec3& eye, const glm::dmat3& axes, const Scene& scene) {
  const Support box = support_of(scene, axes, {0, 0});
  const double eye_z = glm::dot(axes[2], eye);
  return near_plane(eye_z - box.z_max, std::max(eye_z - box.z_min, box.size()));
}

// Hartley and Zisserman 2004, "Multiple View Geometry in Computer Vision", 6.1: u = cx + fx x / z, in clip space.
View view_of(const IntrinsicsCamera& camera, const Scene& scene, double aspect) {
  const glm::dmat3 axes(glm::mat3_cast(glm::dquat(camera.rotation)));
  const glm::dvec3 eye(camera.translation);
  const double height = camera.picture_px.y, width = height * aspect;
  const double middle_x = camera.principal_px.x + (width - camera.picture_px.x) / 2;
  glm::dmat4 clip(perspective_reversed(1, aspect, near_plane_from(eye, axes, scene), kInfinity));
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
  const double z_near = near_plane_from(glm::dvec3(camera.eye), axes, scene);
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
