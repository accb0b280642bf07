#include "renderer/scene/sequence.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "renderer/scene/framing.hpp"
#include "renderer/scene/scene_vertices.hpp"
#include "renderer/scene/shutter.hpp"
#include "renderer/scene/tight_framing.hpp"

namespace furnace {
namespace {

double cross(glm::dvec2 origin, glm::dvec2 a, glm::dvec2 b) {
  return (a.x - origin.x) * (b.y - origin.y) - (a.y - origin.y) * (b.x - origin.x);
}

// Andrew 1979, "Another efficient algorithm for convex hulls in two dimensions".
std::vector<glm::dvec2> convex_hull(std::vector<glm::dvec2> points) {
  std::sort(points.begin(), points.end(),
            [](glm::dvec2 a, glm::dvec2 b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
  std::vector<glm::dvec2> hull;
  const auto walk = [&](auto begin, auto end) {
    const std::size_t first = hull.size();
    for (auto point = begin; point != end; ++point) {
      while (hull.size() >= first + 2 && cross(hull[hull.size() - 2], hull.back(), *point) <= 0)
        hull.pop_back();
      hull.push_back(*point);
    }
  };
  walk(points.begin(), points.end());
  walk(points.rbegin(), points.rend());
  return hull;
}

// Threads: one. Owns: the hull of what was added, and a bounded number of points that wait.
class HullBuilder {
 public:
  void add(glm::dvec2 point) {
    points_.push_back(point);
    if (points_.size() == kMost) points_ = convex_hull(std::move(points_));
  }
  std::vector<glm::dvec2> take() { return convex_hull(std::move(points_)); }

 private:
  static constexpr std::size_t kMost = 1 << 16;  // far more than corners of a hull of floats
  std::vector<glm::dvec2> points_;
};

Bounds joined(std::span<const FrameOutline> outlines) {
  Bounds all;
  for (const FrameOutline& outline : outlines) all.add(outline.bounds);
  return all;
}

// What all frames need, seen by a camera that goes round `pivot`, each frame in its own axes.
SupportOf support_of_all(std::span<const FrameOutline> outlines, std::vector<glm::dvec3> pivots, bool turns) {
  return [outlines, pivots = std::move(pivots), turns](Slopes slopes) {
    Support support{.slopes = slopes, .x = {}, .y = {}};
    for (std::size_t i = 0; i < outlines.size(); ++i) {
      for (const glm::dvec2 point : outlines[i].x_z) {
        const double x = point.x - pivots[i].x, z = point.y - pivots[i].z;
        support.x.add(slopes.x, x, z);
        if (turns) support.x.add(slopes.x, -x, z);  // the axis stays in the middle
        support.add_depth(z);
      }
      for (const glm::dvec2 point : outlines[i].y_z)
        support.y.add(slopes.y, point.x - pivots[i].y, point.y - pivots[i].z);
    }
    return support;
  };
}

void hold_orbit(const RenderSpec& spec, std::span<const FrameOutline> outlines,
                std::vector<RenderSpec>& frames) {
  const double aspect = aspect_of({spec.output.width, spec.output.height});
  const bool turns = spec.output.sequence->turntable_rad != 0;
  const Bounds all = joined(outlines);
  glm::dvec3 pivot = (glm::dvec3(all.min) + glm::dvec3(all.max)) / 2.0;
  if (!turns) pivot = glm::dvec3(0);  // any point; the framing finds the middle

  std::vector<glm::dmat3> axes;
  std::vector<glm::dvec3> pivots;
  for (const RenderSpec& frame : frames) {
    axes.push_back(orbit_axes(std::get<OrbitCamera>(frame.camera.view)));
    pivots.push_back(glm::transpose(axes.back()) * pivot);
  }
  const SupportOf support_of = support_of_all(outlines, std::move(pivots), turns);
  const OrbitCamera orbit = std::get<OrbitCamera>(spec.camera.view);
  const Stand stand = orbit.orthographic ? parallel_stand(support_of, aspect, orbit.fit)
                                         : perspective_stand(support_of, orbit_slopes(orbit, aspect));
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const glm::dvec3 target(stand.eye.x, stand.eye.y, (stand.z_min + stand.z_max) / 2);
    LookAtCamera camera;
    camera.eye = glm::vec3(pivot + axes[i] * stand.eye);
    camera.target = glm::vec3(pivot + axes[i] * target);
    camera.up = glm::vec3(axes[i][1]);
    camera.fov_y_rad = orbit.fov_y_rad;
    if (orbit.orthographic) camera.height_m = 2 * stand.half_height_m;
    frames[i].camera.view = camera;
    frames[i].camera.motion.turn_about_m = pivot;
  }
}

glm::vec3 turned_about_y(const glm::vec3& v, double angle_rad) {
  const double sin_a = std::sin(angle_rad), cos_a = std::cos(angle_rad);
  return glm::dvec3(cos_a * v.x + sin_a * v.z, v.y, cos_a * v.z - sin_a * v.x);
}

bool chooses_focus(const CameraSpec& camera) {
  return camera.depth_of_field && !camera.depth_of_field->focus_distance_m &&
         !camera.depth_of_field->focus_point;
}

bool chooses_ground(const EnvironmentSpec& environment) {
  return environment.ground && !environment.ground->level_m;
}

}  // namespace

FrameOutline outline_of(const Scene& scene, const CameraSpec& camera) {
  FrameOutline outline;
  double finite_test = 0;
  for_each_vertex(scene, glm::dmat3(1), [&](const glm::dvec3& p) {
    outline.bounds.add(glm::vec3(p));
    finite_test += 0 * (p.x + p.y + p.z);
  });
  check_finite_places(finite_test);
  const auto* orbit = std::get_if<OrbitCamera>(&camera.view);
  if (orbit == nullptr) return outline;
  HullBuilder x_z, y_z;
  for_each_vertex(scene, orbit_axes(*orbit), [&](const glm::dvec3& p) {
    x_z.add({p.x, p.z});
    y_z.add({p.y, p.z});
  });
  outline.x_z = x_z.take();
  outline.y_z = y_z.take();
  return outline;
}

double longest_clip_s(const SceneSpec& scene, std::span<const SceneAnimation> animations) {
  double longest_s = 0;
  for (const AnimationClip& clip : scene.animations) {
    for (std::size_t i = 0; i < animations.size(); ++i) {
      const int* index = std::get_if<int>(&clip.which);
      const bool is_it = index ? *index == int(i) : std::get<std::string>(clip.which) == animations[i].name;
      if (is_it) longest_s = std::max(longest_s, animations[i].duration_s);
    }
  }
  return longest_s;
}

int frame_count(const Sequence& sequence, double longest_clip_s) {
  if (sequence.frames) return *sequence.frames;
  constexpr double kMost = 1e6;  // whoever limits frames allows fewer
  return int(std::clamp(std::round(longest_clip_s * sequence.frames_per_second), 2.0, kMost));
}

std::vector<RenderSpec> frames_of(const RenderSpec& spec, int count) {
  const Sequence& sequence = *spec.output.sequence;
  std::vector<RenderSpec> frames(std::size_t(count), spec);
  for (int i = 0; i < count; ++i) {
    RenderSpec& frame = frames[std::size_t(i)];
    frame.output.sequence.reset();
    frame.scene = scene_at(spec.scene, i / sequence.frames_per_second);
    const double angle_rad = sequence.turntable_rad * i / count;
    CameraMotion& motion = frame.camera.motion;
    motion.frame_s = 1 / sequence.frames_per_second;
    motion.turn_rad_per_s = sequence.turntable_rad / count * sequence.frames_per_second;
    if (auto* orbit = std::get_if<OrbitCamera>(&frame.camera.view)) orbit->azimuth_rad += angle_rad;
    if (auto* camera = std::get_if<LookAtCamera>(&frame.camera.view)) {
      camera->eye = camera->target + turned_about_y(camera->eye - camera->target, angle_rad);
      camera->up = turned_about_y(camera->up, angle_rad);
      motion.turn_about_m = camera->target;
    }
  }
  return frames;
}

bool needs_outlines(const RenderSpec& spec) {
  return std::holds_alternative<OrbitCamera>(spec.camera.view) || chooses_ground(spec.environment) ||
         chooses_focus(spec.camera);
}

void hold_still(const RenderSpec& spec, std::span<const FrameOutline> outlines,
                std::vector<RenderSpec>& frames) {
  const Bounds all = joined(outlines);
  for (RenderSpec& frame : frames) {
    if (chooses_ground(spec.environment)) frame.environment.ground->level_m = double(all.min.y);
    if (chooses_focus(spec.camera)) frame.camera.depth_of_field->focus_point = (all.min + all.max) / 2.f;
  }
  if (std::holds_alternative<OrbitCamera>(spec.camera.view)) hold_orbit(spec, outlines, frames);
}

}  // namespace furnace
