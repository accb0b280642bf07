#include "renderer/scene/shutter.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <numeric>
#include <set>

#include <glm/gtc/matrix_transform.hpp>

namespace furnace {
namespace {

// Halton 1960, "On the efficiency of certain quasi-random sequences of points in evaluating multi-dimensional integrals": in
// base 3, which shares nothing with the lens's base 2 and the roots that pixels and lights are sampled by.
double radical_inverse_3(int i) {
  double result = 0;
  for (double digit = 1.0 / 3; i > 0; i /= 3, digit /= 3) result += (i % 3) * digit;
  return result;
}

// Of each sub-frame its place among all of them in time: a permutation, so that every part of the shutter has one.
std::vector<int> ranks_in_time(int subframes) {
  std::vector<int> in_order(std::size_t(subframes), 0);
  std::iota(in_order.begin(), in_order.end(), 0);
  std::sort(in_order.begin(), in_order.end(),
            [](int a, int b) { return radical_inverse_3(a) < radical_inverse_3(b); });
  std::vector<int> ranks(in_order.size());
  for (int rank = 0; rank < subframes; ++rank) ranks[std::size_t(in_order[std::size_t(rank)])] = rank;
  return ranks;
}

int moment_of_rank(int rank, int subframes, int moments) {
  return int((2 * std::int64_t(rank) + 1) * moments / (2 * std::int64_t(subframes)));
}

using MatrixBytes = std::array<std::byte, sizeof(glm::mat4)>;

MatrixBytes bytes_of(const glm::mat4& matrix) {
  MatrixBytes bytes;
  std::memcpy(bytes.data(), &matrix, sizeof matrix);
  return bytes;
}

}  // namespace

bool moves(const RenderSpec& spec) {
  return !spec.scene.animations.empty() || spec.camera.motion.turn_rad_per_s != 0;
}

int moments_wanted(const RenderSpec& spec) {
  return spec.camera.motion.shutter_s > 0 && moves(spec) && spec.output.samples > 1
             ? std::min(spec.output.samples, kMostMoments)
             : 0;
}

std::vector<int> moment_of_subframes(int subframes, int moments) {
  std::vector<int> result = ranks_in_time(subframes);
  for (int& rank : result) rank = moment_of_rank(rank, subframes, moments);
  return result;
}

std::vector<double> moment_offsets_s(int subframes, int moments, double shutter_s) {
  std::vector<double> sums(std::size_t(moments), 0.0), counts(sums.size(), 0.0);
  for (int rank = 0; rank < subframes; ++rank) {
    const auto moment = std::size_t(moment_of_rank(rank, subframes, moments));
    sums[moment] += (rank + 0.5) / subframes - 0.5;
    counts[moment] += 1;
  }
  for (std::size_t i = 0; i < sums.size(); ++i) sums[i] *= shutter_s / counts[i];
  return sums;
}

SceneSpec scene_at(SceneSpec scene, double offset_s) {
  for (AnimationClip& clip : scene.animations) clip.time.seconds += offset_s;
  return scene;
}

View view_at(const View& view, const CameraMotion& motion, double offset_s) {
  const double angle_rad = motion.turn_rad_per_s * offset_s;
  if (angle_rad == 0) return view;
  const glm::dvec3 axis(0, 1, 0);
  const glm::dmat4 about = glm::translate(glm::dmat4(1), motion.turn_about_m);
  const glm::dmat4 back = glm::translate(glm::dmat4(1), -motion.turn_about_m);
  View turned = view;
  turned.view_from_world = glm::mat4(glm::dmat4(view.view_from_world) * about *
                                     glm::rotate(glm::dmat4(1), -angle_rad, axis) * back);
  turned.eye = glm::vec3(about * glm::rotate(glm::dmat4(1), angle_rad, axis) * back *
                         glm::dvec4(glm::dvec3(view.eye), 1));
  return turned;
}

Scene swept_scene(Scene scene, std::span<const Scene* const> moments) {
  std::map<const Mesh*, int> meshes;
  std::set<std::pair<const Mesh*, MatrixBytes>> seen;
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) meshes.try_emplace(scene.meshes[i].get(), int(i));
  for (const Instance& instance : scene.instances)
    seen.emplace(scene.meshes[std::size_t(instance.mesh)].get(), bytes_of(instance.world_from_model));
  for (const Scene* moment : moments) {
    for (const Instance& instance : moment->instances) {
      const SharedMesh& mesh = moment->meshes[std::size_t(instance.mesh)];
      if (!seen.emplace(mesh.get(), bytes_of(instance.world_from_model)).second) continue;
      const auto [entry, fresh] = meshes.try_emplace(mesh.get(), int(scene.meshes.size()));
      if (fresh) scene.meshes.push_back(mesh);
      Instance added = instance;
      added.mesh = entry->second;
      scene.instances.push_back(std::move(added));
    }
  }
  return scene;
}

}  // namespace furnace
